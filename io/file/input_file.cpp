#include "io/file/input_file.h"

#include <fcntl.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <span>
#include <system_error>

#include "kernels/core/status.h"

namespace meander {

void throw_unreadable(const char* done, int error) {
  throw ItemError(Status::unreadable,
                  std::string("the file cannot be ") + done + ": " + std::generic_category().message(error));
}

// O_NONBLOCK: opening a named pipe must not wait for a writer.
InputFile::InputFile(const std::filesystem::path& path) : file_(try_open(path, O_RDONLY | O_NONBLOCK)) {
  if (!file_) throw_unreadable("opened", errno);
  struct stat facts {};
  if (::fstat(file_.get(), &facts) != 0) throw_unreadable("inspected", errno);
  if (!S_ISREG(facts.st_mode)) throw ItemError(Status::unreadable, "not a regular file");
  bytes_ = static_cast<std::uint64_t>(facts.st_size);
  modified_ = facts.st_mtim;
}

std::string InputFile::read(std::uint64_t offset, std::size_t count) const {
  // The buffer is no longer than the rest of the file: clearing more would cost more than reading a small
  // file.
  std::string data(std::min<std::uint64_t>(count, bytes_ - std::min(offset, bytes_)), '\0');
  const Transfer done = try_read(file_, std::as_writable_bytes(std::span(data.data(), data.size())), offset);
  if (done.error != 0) throw_unreadable("read", done.error);
  data.resize(done.bytes);
  return data;
}

}  // namespace meander
