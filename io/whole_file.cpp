#include "io/whole_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <string>
#include <system_error>

namespace meander {

namespace {

[[noreturn]] void fail(const std::string& what, const std::filesystem::path& path) {
  throw std::system_error(errno, std::generic_category(), what + " " + path.string());
}

// Writes all bytes and syncs; the descriptor is closed in any case.
void write_synced(int file, std::span<const std::byte> bytes, const std::filesystem::path& path) {
  while (!bytes.empty()) {
    const ssize_t wrote = ::write(file, bytes.data(), bytes.size());
    if (wrote < 0 && errno == EINTR) continue;
    if (wrote < 0) {
      const int reason = errno;
      ::close(file);
      errno = reason;
      fail("cannot write", path);
    }
    bytes = bytes.subspan(static_cast<std::size_t>(wrote));
  }
  const bool synced = ::fsync(file) == 0;
  const int reason = errno;
  const bool closed = ::close(file) == 0;
  if (!synced) errno = reason;
  if (!synced || !closed) fail("cannot write", path);
}

}  // namespace

void write_whole_file(const std::filesystem::path& path, std::span<const std::byte> bytes) {
  std::filesystem::path temporary = path;
  temporary += ".tmp" + std::to_string(::getpid());
  const int file = ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (file < 0) fail("cannot create", temporary);
  try {
    write_synced(file, bytes, temporary);
    if (::rename(temporary.c_str(), path.c_str()) != 0) fail("cannot rename to", path);
  } catch (...) {
    ::unlink(temporary.c_str());
    throw;
  }
}

void write_whole_file(const std::filesystem::path& path, std::string_view text) {
  write_whole_file(path, std::as_bytes(std::span<const char>(text)));
}

}  // namespace meander
