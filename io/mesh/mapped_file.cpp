#include "io/mesh/mapped_file.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <string>
#include <system_error>
#include <utility>

#include "io/mesh/open_file.h"
#include "kernels/core/status.h"

namespace meander {

namespace {

[[noreturn]] void fail(const char* what, int error) {
  throw ItemError(Status::unreadable,
                  std::string("the file cannot be ") + what + ": " + std::generic_category().message(error));
}

}  // namespace

OpenFile::OpenFile(const std::filesystem::path& path) {
  // O_NONBLOCK: opening a named pipe must not wait for a writer.
  descriptor_ = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (descriptor_ < 0) fail("opened", errno);
  struct stat info {};
  const int error = ::fstat(descriptor_, &info) != 0 ? errno : 0;
  if (error == 0 && S_ISREG(info.st_mode)) {
    bytes_ = static_cast<std::uint64_t>(info.st_size);
    return;
  }
  ::close(descriptor_);
  if (error != 0) fail("inspected", error);
  throw ItemError(Status::unreadable, "not a regular file");
}

OpenFile::~OpenFile() { ::close(descriptor_); }

std::string OpenFile::read(std::uint64_t offset, std::size_t count) const {
  std::string data(count, '\0');
  std::size_t done = 0;
  while (done < count) {
    const ::ssize_t got =
        ::pread(descriptor_, data.data() + done, count - done, static_cast<::off_t>(offset + done));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) fail("read", errno);
    if (got == 0) break;
    done += static_cast<std::size_t>(got);
  }
  data.resize(done);
  return data;
}

MappedFile::MappedFile(const std::filesystem::path& path) {
  const OpenFile file(path);
  const auto size = static_cast<std::size_t>(file.bytes());
  if (size == 0) return;
  void* const map = ::mmap(nullptr, size, PROT_READ, MAP_PRIVATE, file.descriptor(), 0);
  if (map == MAP_FAILED) fail("mapped", errno);
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
