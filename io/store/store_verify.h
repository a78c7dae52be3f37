// Whether a store is what was written.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace meander {

// Everything wrong with a store, one sentence each, at most `limit`; empty when it is whole. Checks: the
// digest over every byte of the file, the schema, every chunk's checksum, points_crc32c and content of every
// row (an ok row is finite but for descriptors that are NaN as a whole, every column of it and every sample
// within the range that its meaning allows; any other row is all fill), ids ascending and unique, statuses
// known. Of an index of packs the same of every pack, and that they are those that it names. progress(done,
// total rows) may be empty.
struct VerifyResult {
  std::uint64_t rows = 0, ok_rows = 0;
  std::vector<std::string> problems;
};
VerifyResult verify_store(const std::filesystem::path& store, std::size_t limit = 100,
                          const std::function<void(std::uint64_t, std::uint64_t)>& progress = {});

}  // namespace meander
