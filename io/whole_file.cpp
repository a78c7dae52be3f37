#include "io/whole_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <string>
#include <system_error>
#include <utility>

namespace meander {

namespace {

[[noreturn]] void fail(const std::string& what, const std::filesystem::path& path) {
  throw std::system_error(errno, std::generic_category(), what + " " + path.string());
}

}  // namespace

std::filesystem::path replaced_file(const std::filesystem::path& path) {
  namespace fs = std::filesystem;
  std::error_code none;
  const fs::file_status status = fs::status(path, none);
  if (fs::exists(status) && !fs::is_regular_file(status)) {
    errno = fs::is_directory(status) ? EISDIR : EEXIST;
    fail("not a file that can be replaced:", path);
  }
  return fs::exists(status) && fs::is_symlink(path, none) ? fs::canonical(path) : path;
}

WholeFileWriter::WholeFileWriter(const std::filesystem::path& path)
    : path_(replaced_file(path)), temporary_(path_) {
  temporary_ += ".tmp" + std::to_string(::getpid());
  file_ = ::open(temporary_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (file_ < 0) fail("cannot create", temporary_);
}

WholeFileWriter::~WholeFileWriter() {
  if (file_ >= 0) ::close(file_);
  if (!temporary_.empty()) ::unlink(temporary_.c_str());
}

void WholeFileWriter::append(std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t wrote = ::write(file_, bytes.data(), bytes.size());
    if (wrote < 0 && errno == EINTR) continue;
    if (wrote < 0) fail("cannot write", temporary_);
    bytes = bytes.subspan(static_cast<std::size_t>(wrote));
  }
}

void WholeFileWriter::finish() {
  if (::fsync(file_) != 0) fail("cannot write", temporary_);
  const int file = std::exchange(file_, -1);
  if (::close(file) != 0) fail("cannot write", temporary_);
  if (::rename(temporary_.c_str(), path_.c_str()) != 0) fail("cannot rename to", path_);
  temporary_.clear();
}

void write_whole_file(const std::filesystem::path& path, std::span<const std::byte> bytes) {
  WholeFileWriter writer(path);
  writer.append(bytes);
  writer.finish();
}

void write_whole_file(const std::filesystem::path& path, std::string_view text) {
  write_whole_file(path, std::as_bytes(std::span<const char>(text)));
}

}  // namespace meander
