// A file of an item, opened for reading.
#pragma once

#include <cstddef>
#include <cstdint>
#include <ctime>
#include <filesystem>
#include <string>

#include "io/file/byte_source.h"
#include "io/file/file_descriptor.h"

namespace meander {

// Throws ItemError(unreadable) with the system's reason, or when it is not a regular file. `bytes` is the
// size when it was opened.
class InputFile final : public ByteSource {
 public:
  explicit InputFile(const std::filesystem::path& path);

  const FileDescriptor& descriptor() const { return file_; }
  std::uint64_t bytes() const override { return bytes_; }
  std::timespec modified() const { return modified_; }
  std::string read(std::uint64_t offset, std::size_t count) const override;

 private:
  FileDescriptor file_;
  std::uint64_t bytes_ = 0;
  std::timespec modified_{};
};

// "the file cannot be <done>: <what the system says>", as the reason of a row.
[[noreturn]] void throw_unreadable(const char* done, int error);

}  // namespace meander
