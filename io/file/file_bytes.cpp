#include "io/file/file_bytes.h"

#include <sys/mman.h>

#include <cerrno>
#include <utility>

#include "io/file/input_file.h"

namespace meander {

FileBytes::FileBytes(const std::filesystem::path& path, std::size_t most) {
  const InputFile file(path);
  const auto size = static_cast<std::size_t>(file.bytes());
  if (size == 0) return;
  if (size <= most) {
    read_ = std::make_unique_for_overwrite<std::byte[]>(size);
    const Transfer done = try_read(file.descriptor(), std::span(read_.get(), size), 0);
    if (done.error != 0) throw_unreadable("read", done.error);
    data_ = read_.get();
    size_ = done.bytes;
    return;
  }
  void* const map = ::mmap(nullptr, size, PROT_READ, MAP_PRIVATE, file.descriptor().get(), 0);
  if (map == MAP_FAILED) throw_unreadable("mapped", errno);
  ::madvise(map, size, MADV_SEQUENTIAL);
  ::madvise(map, size, MADV_WILLNEED);
  data_ = static_cast<const std::byte*>(map);
  size_ = size;
}

FileBytes::FileBytes(FileBytes&& other) noexcept
    : read_(std::move(other.read_)),
      data_(std::exchange(other.data_, nullptr)),
      size_(std::exchange(other.size_, 0)) {}

FileBytes::~FileBytes() {
  // munmap takes a pointer to non-const; the mapping is private to this object.
  if (data_ != nullptr && !read_) ::munmap(const_cast<std::byte*>(data_), size_);
}

}  // namespace meander
