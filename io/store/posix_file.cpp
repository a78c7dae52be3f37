#include "io/store/posix_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "io/store/store.h"

namespace meander::store {

namespace fs = std::filesystem;

FileDescriptor::~FileDescriptor() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

void throw_file_error(int error, std::string_view action, const fs::path& path) {
  const bool resumable = error == ENOSPC || error == EDQUOT || error == EFBIG || error == EIO;
  throw RunError(resumable ? RunError::Kind::stopped : RunError::Kind::unusable,
                 fmt::format("cannot {} {}: {}", action, path.string(), std::strerror(error)));
}

FileDescriptor open_file(const fs::path& path, int flags) {
  for (;;) {
    const int descriptor = ::open(path.c_str(), flags | O_CLOEXEC, 0666);
    if (descriptor >= 0) return FileDescriptor(descriptor);
    if (errno != EINTR) throw_file_error(errno, "open", path);
  }
}

std::uint64_t file_size(const FileDescriptor& file, const fs::path& path) {
  struct stat facts {};
  if (::fstat(file.get(), &facts) != 0) throw_file_error(errno, "look at", path);
  return static_cast<std::uint64_t>(facts.st_size);
}

void write_at(const FileDescriptor& file, std::span<const std::byte> bytes, std::uint64_t offset,
              const fs::path& path) {
  while (!bytes.empty()) {
    const ssize_t count = ::pwrite(file.get(), bytes.data(), bytes.size(), static_cast<off_t>(offset));
    if (count < 0) {
      if (errno == EINTR) continue;
      throw_file_error(errno, "write", path);
    }
    bytes = bytes.subspan(static_cast<std::size_t>(count));
    offset += static_cast<std::uint64_t>(count);
  }
}

std::size_t read_at(const FileDescriptor& file, std::span<std::byte> bytes, std::uint64_t offset,
                    const fs::path& path) {
  std::size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t count =
        ::pread(file.get(), bytes.data() + done, bytes.size() - done, static_cast<off_t>(offset + done));
    if (count == 0) break;
    if (count < 0) {
      if (errno == EINTR) continue;
      throw_file_error(errno, "read", path);
    }
    done += static_cast<std::size_t>(count);
  }
  return done;
}

std::optional<std::string> read_text(const fs::path& path) {
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) {
    if (errno == ENOENT) return std::nullopt;
    throw_file_error(errno, "open", path);
  }
  const FileDescriptor file(descriptor);
  std::string text(file_size(file, path), '\0');
  text.resize(read_at(file, std::as_writable_bytes(std::span(text.data(), text.size())), 0, path));
  return text;
}

void sync_file(const FileDescriptor& file, const fs::path& path) {
  if (::fsync(file.get()) != 0) throw_file_error(errno, "sync", path);
}

void sync_folder(const fs::path& folder) {
  const FileDescriptor file = open_file(folder.empty() ? fs::path(".") : folder, O_RDONLY | O_DIRECTORY);
  // Some network file systems cannot sync a folder; the rename is then as durable as they make it.
  if (::fsync(file.get()) != 0 && errno != EINVAL) throw_file_error(errno, "sync", folder);
}

void rename_file(const fs::path& from, const fs::path& to) {
  if (::rename(from.c_str(), to.c_str()) != 0) throw_file_error(errno, "rename", from);
  sync_folder(to.parent_path());
}

void replace_file(const fs::path& path, std::span<const std::byte> bytes) {
  fs::path temporary = path;
  temporary += ".new";
  {
    const FileDescriptor file = open_file(temporary, O_WRONLY | O_CREAT | O_TRUNC);
    write_at(file, bytes, 0, temporary);
    sync_file(file, temporary);
  }
  rename_file(temporary, path);
}

void reserve_space(const fs::path& path, std::uint64_t bytes) {
  struct rlimit limit {};
  if (::getrlimit(RLIMIT_FSIZE, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY && bytes > limit.rlim_cur)
    throw_file_error(EFBIG, fmt::format("reserve {} bytes for", bytes), path);
  const FileDescriptor file = open_file(path, O_WRONLY);
  for (;;) {
    if (::fallocate(file.get(), FALLOC_FL_KEEP_SIZE, 0, static_cast<off_t>(bytes)) == 0) return;
    if (errno == EINTR) continue;
    if (errno == EOPNOTSUPP || errno == ENOSYS) return;  // writes will report a full disk
    throw_file_error(errno, fmt::format("reserve {} bytes for", bytes), path);
  }
}

void release_reserved(const FileDescriptor& file, const fs::path& path) {
  if (::ftruncate(file.get(), static_cast<off_t>(file_size(file, path))) != 0)
    throw_file_error(errno, "truncate", path);
}

}  // namespace meander::store
