#include "io/file/file_descriptor.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>

namespace meander {

namespace fs = std::filesystem;

namespace {

template <class Bytes, class Call>
Transfer transfer(std::span<Bytes> bytes, std::uint64_t offset, const Call& call) {
  Transfer done;
  while (done.bytes < bytes.size()) {
    const std::span<Bytes> rest = bytes.subspan(done.bytes);
    const ssize_t count = call(rest.data(), rest.size(), static_cast<off_t>(offset + done.bytes));
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) done.error = errno;
    if (count <= 0) break;
    done.bytes += static_cast<std::size_t>(count);
  }
  return done;
}

}  // namespace

int FileDescriptor::close() {
  if (descriptor_ < 0) return 0;
  // It is never repeated, not even after EINTR: Linux has then released the number, which another thread may
  // use.
  return ::close(std::exchange(descriptor_, -1)) == 0 || errno == EINTR ? 0 : errno;
}

FileDescriptor try_open(const fs::path& path, int flags) {
  return FileDescriptor(uninterrupted([&] { return ::open(path.c_str(), flags | O_CLOEXEC, 0666); }));
}

Transfer try_read(const FileDescriptor& file, std::span<std::byte> bytes, std::uint64_t offset) {
  return transfer(bytes, offset, [&](std::byte* to, std::size_t count, off_t at) {
    return ::pread(file.get(), to, count, at);
  });
}

Transfer try_write(const FileDescriptor& file, std::span<const std::byte> bytes, std::uint64_t offset) {
  Transfer done = transfer(bytes, offset, [&](const std::byte* from, std::size_t count, off_t at) {
    return ::pwrite(file.get(), from, count, at);
  });
  if (done.bytes < bytes.size() && done.error == 0) done.error = ENOSPC;  // no error, but nothing is written
  return done;
}

FileDescriptor open_file(const fs::path& path, int flags) {
  FileDescriptor file = try_open(path, flags);
  if (!file) throw_file_error(errno, "open", path);
  return file;
}

std::uint64_t file_size(const FileDescriptor& file, const fs::path& path) {
  struct stat facts {};
  if (::fstat(file.get(), &facts) != 0) throw_file_error(errno, "look at", path);
  return static_cast<std::uint64_t>(facts.st_size);
}

void write_at(const FileDescriptor& file, std::span<const std::byte> bytes, std::uint64_t offset,
              const fs::path& path) {
  if (const int error = try_write(file, bytes, offset).error; error != 0)
    throw_file_error(error, "write", path);
}

std::size_t read_at(const FileDescriptor& file, std::span<std::byte> bytes, std::uint64_t offset,
                    const fs::path& path) {
  const Transfer done = try_read(file, bytes, offset);
  if (done.error != 0) throw_file_error(done.error, "read", path);
  return done.bytes;
}

void sync_file(const FileDescriptor& file, const fs::path& path) {
  if (uninterrupted([&] { return ::fsync(file.get()); }) != 0) throw_file_error(errno, "sync", path);
}

void sync_data(const FileDescriptor& file, const fs::path& path) {
  if (uninterrupted([&] { return ::fdatasync(file.get()); }) != 0) throw_file_error(errno, "sync", path);
}

void begin_sync(const FileDescriptor& file) {
  // The result is ignored: an error of the disk stays with the file until a sync has reported it.
  uninterrupted([&] { return ::sync_file_range(file.get(), 0, 0, SYNC_FILE_RANGE_WRITE); });
}

void truncate_file(const FileDescriptor& file, std::uint64_t bytes, const fs::path& path) {
  if (uninterrupted([&] { return ::ftruncate(file.get(), static_cast<off_t>(bytes)); }) != 0)
    throw_file_error(errno, "truncate", path);
}

void reserve_space(const fs::path& path, std::uint64_t bytes, FullDisk full_disk) {
  const auto fail = [&](int error) {
    throw_file_error(error, fmt::format("reserve {} bytes for", bytes), path, full_disk);
  };
  struct rlimit limit {};
  if (::getrlimit(RLIMIT_FSIZE, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY && bytes > limit.rlim_cur)
    fail(EFBIG);
  const FileDescriptor file = open_file(path, O_WRONLY);
  const int reserved = uninterrupted(
      [&] { return ::fallocate(file.get(), FALLOC_FL_KEEP_SIZE, 0, static_cast<off_t>(bytes)); });
  if (reserved == 0 || errno == EOPNOTSUPP || errno == ENOSYS) return;  // writes will report a full disk
  fail(errno);
}

void release_reserved(const FileDescriptor& file, const fs::path& path) {
  truncate_file(file, file_size(file, path), path);
}

}  // namespace meander
