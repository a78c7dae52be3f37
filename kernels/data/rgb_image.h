// A picture as plain bytes.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace meander {

using SrgbColor = std::array<std::uint8_t, 3>;

// height rows from top to bottom of width pixels from left to right, three bytes each: red, green, blue
// (sRGB).
struct RgbImage {
  std::uint32_t width = 0, height = 0;
  std::vector<std::uint8_t> pixels;

  RgbImage() = default;
  // All white.
  RgbImage(std::uint32_t w, std::uint32_t h)
      : width(w), height(h), pixels(std::size_t{3} * w * h, std::uint8_t{255}) {}
  // Paints the part of a rectangle that lies within the picture.
  void fill(std::uint32_t x, std::uint32_t y, std::uint32_t columns, std::uint32_t rows, SrgbColor color) {
    for (std::uint32_t row = y; row < height && row - y < rows; ++row)
      for (std::uint32_t column = x; column < width && column - x < columns; ++column)
        std::copy(color.begin(), color.end(), pixel(column, row));
  }
  std::uint8_t* pixel(std::uint32_t x, std::uint32_t y) {
    return pixels.data() + 3 * (std::size_t{y} * width + x);
  }
  const std::uint8_t* pixel(std::uint32_t x, std::uint32_t y) const {
    return pixels.data() + 3 * (std::size_t{y} * width + x);
  }
};

}  // namespace meander
