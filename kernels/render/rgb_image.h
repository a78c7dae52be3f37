// A picture as plain bytes.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace meander {

using SrgbColour = std::array<std::uint8_t, 3>;

// height rows from top to bottom of width pixels from left to right, three bytes each: red, green, blue
// (sRGB).
struct RgbImage {
  std::uint32_t width = 0, height = 0;
  std::vector<std::uint8_t> pixels;

  RgbImage() = default;
  // All white.
  RgbImage(std::uint32_t w, std::uint32_t h)
      : width(w), height(h), pixels(std::size_t{3} * w * h, std::uint8_t{255}) {}
  std::uint8_t* pixel(std::uint32_t x, std::uint32_t y) {
    return pixels.data() + 3 * (std::size_t{y} * width + x);
  }
  const std::uint8_t* pixel(std::uint32_t x, std::uint32_t y) const {
    return pixels.data() + 3 * (std::size_t{y} * width + x);
  }
};

}  // namespace meander
