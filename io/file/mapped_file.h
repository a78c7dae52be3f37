// A file mapped into memory, read-only.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>

namespace meander {

// A file mapped read-only for as long as the object lives, advised for one pass from front to back. Throws
// ItemError(unreadable) with the system's reason; anything but a regular file is unreadable too. An empty
// file has no bytes and no mapping. A file that another program shortens while it is mapped raises SIGBUS on
// access: models must not be rewritten in place during a run.
class MappedFile {
 public:
  explicit MappedFile(const std::filesystem::path& path);
  ~MappedFile();
  MappedFile(MappedFile&& other) noexcept;
  MappedFile& operator=(MappedFile&&) = delete;
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;
  std::span<const std::byte> bytes() const { return {data_, size_}; }

 private:
  const std::byte* data_ = nullptr;
  std::size_t size_ = 0;
};

}  // namespace meander
