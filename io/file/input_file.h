// A file of an item, open for reading.
#pragma once

#include <cstddef>
#include <cstdint>
#include <ctime>
#include <filesystem>
#include <string>

#include "io/file/byte_source.h"
#include "io/file/file_descriptor.h"

namespace meander {

// Throws ItemError(unreadable) with the system's reason, or for anything but a regular file. bytes() is the
// size at the time of opening.
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

// Throws ItemError(unreadable), "the file cannot be <done>: <reason of the system>".
[[noreturn]] void throw_unreadable(const char* done, int error);

}  // namespace meander
