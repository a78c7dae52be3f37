#include "io/file/read_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>

#include "io/file/file_descriptor.h"

namespace meander {

namespace {

std::string content_of(const FileDescriptor& file, const std::filesystem::path& path) {
  constexpr std::uint64_t min_room = 4096;
  std::string content;
  std::size_t done = 0;
  for (;;) {
    // Room for a regular file, and one byte more in which its end shows.
    if (done == content.size())
      content.resize(std::max({min_room, file_size(file, path) + 1, 2 * std::uint64_t{done}}));
    const ssize_t count = ::read(file.get(), content.data() + done, content.size() - done);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) throw_file_error(errno, "read", path);
    if (count == 0) break;
    done += static_cast<std::size_t>(count);
  }
  content.resize(done);
  return content;
}

}  // namespace

std::string content_of_file(const std::filesystem::path& path) {
  return content_of(open_file(path, O_RDONLY), path);
}

std::optional<std::string> content_if_exists(const std::filesystem::path& path) {
  const FileDescriptor file = try_open(path, O_RDONLY);
  if (!file && errno == ENOENT) return std::nullopt;
  if (!file) throw_file_error(errno, "open", path);
  return content_of(file, path);
}

}  // namespace meander
