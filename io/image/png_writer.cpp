#include "io/image/png_writer.h"

#include <fcntl.h>
#include <png.h>
#include <unistd.h>

#include <cerrno>
#include <stdexcept>
#include <string>
#include <system_error>

namespace meander {

namespace {

[[noreturn]] void fail(const std::string& what, const std::filesystem::path& path) {
  throw std::system_error(errno, std::generic_category(), what + " " + path.string());
}

// Writes all bytes and syncs; the descriptor is closed in any case.
void write_synced(int file, const std::vector<std::byte>& bytes, const std::filesystem::path& path) {
  std::size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t wrote = ::write(file, bytes.data() + done, bytes.size() - done);
    if (wrote < 0 && errno == EINTR) continue;
    if (wrote < 0) {
      const int reason = errno;
      ::close(file);
      errno = reason;
      fail("cannot write", path);
    }
    done += static_cast<std::size_t>(wrote);
  }
  const bool synced = ::fsync(file) == 0;
  const int reason = errno;
  const bool closed = ::close(file) == 0;
  if (!synced) errno = reason;
  if (!synced || !closed) fail("cannot write", path);
}

}  // namespace

std::vector<std::byte> encode_png(const RgbImage& image) {
  if (image.width == 0 || image.height == 0 ||
      image.pixels.size() != std::size_t{3} * image.width * image.height)
    throw std::invalid_argument("encode_png: the buffer is not width x height x 3 bytes");
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  header.width = image.width;
  header.height = image.height;
  header.format = PNG_FORMAT_RGB;
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(header);
  std::vector<std::byte> bytes(size);
  if (png_image_write_to_memory(&header, bytes.data(), &size, 0, image.pixels.data(), 0, nullptr) == 0)
    throw std::runtime_error(std::string("libpng: ") + header.message);
  bytes.resize(size);
  return bytes;
}

void write_png(const std::filesystem::path& path, const RgbImage& image) {
  const std::vector<std::byte> bytes = encode_png(image);
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

}  // namespace meander
