#include "io/plot/png_writer.h"

#include <png.h>

#include <stdexcept>
#include <string>

#include "io/file/atomic_file.h"

namespace meander {

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
  replace_file(path, encode_png(image));
}

}  // namespace meander
