// A file of an item, opened for reading.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>

#include "io/file/file_descriptor.h"

namespace meander {

// Throws ItemError(unreadable) with the system's reason, or when it is not a regular file. `bytes` is the
// size when it was opened.
class InputFile {
 public:
  explicit InputFile(const std::filesystem::path& path);

  const FileDescriptor& descriptor() const { return file_; }
  std::uint64_t bytes() const { return bytes_; }
  // Up to `count` bytes from `offset`; fewer at the end of the file. Throws ItemError(unreadable).
  std::string read(std::uint64_t offset, std::size_t count) const;

 private:
  FileDescriptor file_;
  std::uint64_t bytes_ = 0;
};

// "the file cannot be <done>: <what the system says>", as the reason of a row.
[[noreturn]] void throw_unreadable(const char* done, int error);

}  // namespace meander
