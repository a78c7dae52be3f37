// Internal to io/mesh: a file opened for reading.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>

namespace meander {

// Throws ItemError(unreadable) with the system's reason, or when it is not a regular file. `bytes` is the
// size when it was opened.
class OpenFile {
 public:
  explicit OpenFile(const std::filesystem::path& path);
  ~OpenFile();
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;

  int descriptor() const { return descriptor_; }
  std::uint64_t bytes() const { return bytes_; }
  // Up to `count` bytes from `offset`; fewer at the end of the file. Throws ItemError(unreadable).
  std::string read(std::uint64_t offset, std::size_t count) const;

 private:
  int descriptor_ = -1;
  std::uint64_t bytes_ = 0;
};

}  // namespace meander
