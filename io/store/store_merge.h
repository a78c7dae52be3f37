// Journal to sealed shard, sealed shards to store.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <vector>

#include "io/store/schema.h"
#include "io/store/store.h"
#include "io/store/store_file.h"

namespace meander::store {

// Reads the journal payload of a row from `begin` on, up to its end or that of `bytes`; returns how many
// bytes.
using ReadPayload =
    std::function<std::size_t(std::uint64_t row, std::uint64_t begin, std::span<std::byte> bytes)>;

// Writes the finished rows of one shard to the HDF5 file `path` and syncs it. The bytes depend on header and
// rows alone. Chunks of several rows are filtered here, in parallel; memory: 256 rows and the item columns of
// 4096; of rows of one chunk or more, one chunk. `reserve` is what the journal of the shard takes on disk.
void write_shard(const std::filesystem::path& path, const StoreHeader& header, const StoreLayout& layout,
                 RowRange rows, std::uint64_t reserve, const ReadPayload& read);

// The same of all rows of a store of at most shard_rows, straight to the store: the bytes are those that
// merge_rows makes of their shard.
void write_store_of_journal(const std::filesystem::path& path, const StoreHeader& header,
                            const StoreLayout& layout, std::uint64_t reserve, const ReadPayload& read);

// A file with the rows [rows.begin, rows.end) of the store: a sealed shard of the same run, or a finished
// store of the same parameters, which may have rows before and after them that the store does not get.
struct MergeSource {
  std::filesystem::path path;
  RowRange rows;
  std::uint64_t rows_before = 0, rows_after = 0;
};

// Writes the rows of all sources, which follow each other and are all rows of `header`, to the new store
// `path` and syncs it. The bytes depend on the header and the rows alone, not on how the sources divide them:
// chunks that a source has whole are copied as they are, others are put together. Memory: one chunk, and what
// the HDF5 library keeps of the sources of 4096 rows. RunError: stopped when the store cannot be written,
// unusable when a source is damaged or does not belong to the others (named in the message).
void merge_rows(const std::filesystem::path& path, const StoreHeader& header, const StoreLayout& layout,
                const std::vector<MergeSource>& sources);

}  // namespace meander::store
