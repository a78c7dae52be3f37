// Reads and writes parts of files: every call is checked, and continued after signals and partial transfers.
#pragma once

#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <utility>

#include "io/file/file_error.h"

namespace meander {

class FileDescriptor {
 public:
  FileDescriptor() = default;
  explicit FileDescriptor(int descriptor) : descriptor_(descriptor) {}
  FileDescriptor(FileDescriptor&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}
  FileDescriptor& operator=(FileDescriptor&& other) noexcept {
    std::swap(descriptor_, other.descriptor_);
    return *this;
  }
  ~FileDescriptor() { close(); }
  int get() const { return descriptor_; }
  explicit operator bool() const { return descriptor_ >= 0; }
  int close();  // returns 0, or an error that the system reports only now; called again, it returns 0

 private:
  int descriptor_ = -1;
};

// The result of a system call, which is repeated while signals interrupt it.
template <class Call>
auto uninterrupted(const Call& call) {
  for (;;) {
    const auto result = call();
    if (result != -1 || errno != EINTR) return result;
  }
}

// The bytes that were transferred, and the error (errno) that ended the transfer; 0 at the end.
struct Transfer {
  std::size_t bytes = 0;
  int error = 0;
};

// These functions do not throw, for callers with errors of their own. try_open adds O_CLOEXEC and creates
// files with mode 0666; when it fails, the descriptor is empty and errno is set.
FileDescriptor try_open(const std::filesystem::path& path, int flags);
Transfer try_read(const FileDescriptor& file, std::span<std::byte> bytes, std::uint64_t offset);
Transfer try_write(const FileDescriptor& file, std::span<const std::byte> bytes, std::uint64_t offset);

// The same for files of a run: they throw FileError, with the kind `stopped` on a full disk.
FileDescriptor open_file(const std::filesystem::path& path, int flags);
std::uint64_t file_size(const FileDescriptor& file, const std::filesystem::path& path);
// Writes all bytes at `offset`, which may be the end of the file.
void write_at(const FileDescriptor& file, std::span<const std::byte> bytes, std::uint64_t offset,
              const std::filesystem::path& path);
// Reads up to bytes.size() bytes; fewer only at the end of the file. Returns how many.
std::size_t read_at(const FileDescriptor& file, std::span<std::byte> bytes, std::uint64_t offset,
                    const std::filesystem::path& path);
void sync_file(const FileDescriptor& file, const std::filesystem::path& path);  // contents and length
void sync_data(const FileDescriptor& file, const std::filesystem::path& path);  // without times
// Has the system begin to write its pages of the file to the disk, so that a later sync waits for less. It is
// only a hint: the sync reports errors.
void begin_sync(const FileDescriptor& file);
void truncate_file(const FileDescriptor& file, std::uint64_t bytes, const std::filesystem::path& path);

// Makes sure that the existing file `path` can grow to `bytes`: reserves its blocks if the file system can,
// without changing its length. A file that cannot be completed is refused here, before anything has to be
// undone.
void reserve_space(const std::filesystem::path& path, std::uint64_t bytes,
                   FullDisk full_disk = FullDisk::stops_run);
// Cuts the file to its length, which frees reserved blocks beyond it.
void release_reserved(const FileDescriptor& file, const std::filesystem::path& path);

}  // namespace meander
