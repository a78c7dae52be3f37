// Stores of some of the rows each to one store.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "io/store/schema.h"
#include "io/store/store.h"
#include "io/store/store_file.h"

namespace meander::store {

// A file with the rows [rows.begin, rows.end) of the store: a finished store of the same parameters, which
// may have rows before and after them that the store does not get.
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
