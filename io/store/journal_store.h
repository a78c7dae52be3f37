// Journals to store: what the end of a run does.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>

#include "io/store/journal.h"
#include "io/store/schema.h"

namespace meander::store {

// Where the record of a finished row begins in its journal, and how long its payload is.
struct RecordPlace {
  std::uint64_t offset = 0, payload_bytes = 0;
};

// Writes the rows of the journals, all rows of `header`, to the new store `path` and syncs it. The bytes
// depend on header and rows alone; they are those that merge_rows makes of stores of some of the rows each.
// The checksum of every record is compared again when its samples, or its reason, are written. Chunks of
// several rows are filtered here, in parallel. Memory: store_writing_bytes(header). `statuses` and `places`
// are by row. RunError(stopped): the store cannot be written, or a journal has changed since its records were
// appended or replayed (the message names it); the next process computes again what is damaged.
void write_store_of_journals(const std::filesystem::path& path, const StoreHeader& header,
                             const StoreLayout& layout, Journals& journals,
                             std::span<const std::uint8_t> statuses, std::span<const RecordPlace> places);

}  // namespace meander::store

namespace meander {

// Bytes that writing such a store from the journals of its run takes at most.
std::uint64_t store_writing_bytes(const StoreHeader& header);

}  // namespace meander
