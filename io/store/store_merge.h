// Journal to sealed shard, sealed shards to store.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <vector>

#include "io/store/schema.h"
#include "io/store/store.h"
#include "io/store/store_file.h"

namespace meander::store {

// Fills `payload` with the first `most` bytes (or all there are) of the journal payload of a row.
using ReadPayload = std::function<void(std::uint64_t row, std::size_t most, std::vector<std::byte>& payload)>;

// Writes the finished rows of one shard to the HDF5 file `path` and syncs it. The bytes depend on header and
// rows alone. Chunks of several rows are filtered here, in parallel; memory: 256 rows and the item columns of
// 4096. `reserve` is what the journal of the shard takes on disk.
void write_shard(const std::filesystem::path& path, const StoreHeader& header, const StoreLayout& layout,
                 RowRange rows, std::uint64_t reserve, const ReadPayload& read);

// Copies the chunks of all sealed shards, in row order, to the new store `path` and syncs it. RunError:
// stopped when it cannot be written, unusable when a shard is damaged (named in the message).
void merge_shards(const std::filesystem::path& path, const StoreHeader& header, const StoreLayout& layout,
                  const std::vector<std::filesystem::path>& shards);

}  // namespace meander::store
