#include "io/file/memory_file.h"

#include <sys/mman.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <system_error>

namespace meander {

namespace {

[[noreturn]] void fail() { throw std::system_error(errno, std::generic_category(), "a file in memory"); }

}  // namespace

MemoryFile::MemoryFile(std::string_view content) : descriptor_(memfd_create("meander", MFD_CLOEXEC)) {
  if (descriptor_ < 0) fail();
  while (!content.empty()) {
    const ssize_t written = ::write(descriptor_, content.data(), content.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) {
      const int error = errno;
      ::close(descriptor_);
      errno = error;
      fail();
    }
    content.remove_prefix(static_cast<std::size_t>(written));
  }
  ::lseek(descriptor_, 0, SEEK_SET);
}

MemoryFile::~MemoryFile() { ::close(descriptor_); }

std::string MemoryFile::content() const {
  std::string text;
  std::array<char, 65536> block;
  for (;;) {
    const ssize_t got = ::pread(descriptor_, block.data(), block.size(), static_cast<off_t>(text.size()));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) fail();
    if (got == 0) return text;
    text.append(block.data(), static_cast<std::size_t>(got));
  }
}

}  // namespace meander
