// PNG files that tests make, of every color type. Programs that use it link libpng themselves.
#pragma once

#include <png.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace meander::test {

struct PngPicture {
  std::uint32_t width = 0, height = 0;
  int depth = 8, type = PNG_COLOR_TYPE_GRAY;
  bool interlaced = false;
  std::vector<png_color> palette;
  bool transparent = false;  // some of the palette or one gray
};

// The bytes of a PNG file whose samples, before packing, are sample(x, y, channel).
inline std::string png_bytes(const PngPicture& picture,
                             const std::function<unsigned(std::size_t, std::size_t, std::size_t)>& sample) {
  std::string bytes;
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  png_set_write_fn(
      png, &bytes,
      [](png_structp to, png_bytep data, std::size_t count) {
        static_cast<std::string*>(png_get_io_ptr(to))->append(reinterpret_cast<char*>(data), count);
      },
      [](png_structp) {});
  png_set_IHDR(png, info, picture.width, picture.height, picture.depth, picture.type,
               picture.interlaced ? PNG_INTERLACE_ADAM7 : PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
               PNG_FILTER_TYPE_DEFAULT);
  if (!picture.palette.empty())
    png_set_PLTE(png, info, picture.palette.data(), static_cast<int>(picture.palette.size()));
  png_byte alpha[2] = {0, 128};
  png_color_16 clear{};
  if (picture.transparent) png_set_tRNS(png, info, alpha, picture.palette.empty() ? 0 : 2, &clear);
  png_set_gAMA(png, info, 0.45455);
  png_write_info(png, info);
  png_set_packing(png);
  const std::size_t channels = png_get_channels(png, info), size = picture.depth == 16 ? 2 : 1;
  const std::size_t row_bytes = picture.width * channels * size;
  std::vector<png_byte> data(row_bytes * picture.height);
  std::vector<png_bytep> rows;
  for (std::size_t y = 0; y < picture.height; ++y) {
    rows.push_back(data.data() + y * row_bytes);
    for (std::size_t k = 0; k < picture.width * channels; ++k) {
      const unsigned value = sample(k / channels, y, k % channels);
      if (size == 2) rows[y][2 * k] = static_cast<png_byte>(value >> 8);
      rows[y][size * k + size - 1] = static_cast<png_byte>(value & 255);
    }
  }
  png_write_image(png, rows.data());
  png_write_end(png, nullptr);
  png_destroy_write_struct(&png, &info);
  return bytes;
}

}  // namespace meander::test
