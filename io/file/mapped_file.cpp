#include "io/file/mapped_file.h"

#include <sys/mman.h>

#include <cerrno>
#include <utility>

#include "io/file/input_file.h"

namespace meander {

MappedFile::MappedFile(const std::filesystem::path& path) {
  const InputFile file(path);
  const auto size = static_cast<std::size_t>(file.bytes());
  if (size == 0) return;
  void* const map = ::mmap(nullptr, size, PROT_READ, MAP_PRIVATE, file.descriptor().get(), 0);
  if (map == MAP_FAILED) throw_unreadable("mapped", errno);
  ::madvise(map, size, MADV_SEQUENTIAL);
  ::madvise(map, size, MADV_WILLNEED);
  data_ = static_cast<const std::byte*>(map);
  size_ = size;
}

MappedFile::MappedFile(MappedFile&& other) noexcept
    : data_(std::exchange(other.data_, nullptr)), size_(std::exchange(other.size_, 0)) {}

MappedFile::~MappedFile() {
  // munmap takes a pointer to non-const; the mapping is private to this object.
  if (data_ != nullptr) ::munmap(const_cast<std::byte*>(data_), size_);
}

}  // namespace meander
