#include "io/plot/color.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace meander {

namespace {

std::uint8_t byte_of(double share) {
  return static_cast<std::uint8_t>(std::lround(255 * std::clamp(share, 0.0, 1.0)));
}

// The sRGB transfer function.
double encoded(double linear) {
  return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
}

// hue: radians. Colors outside sRGB are clamped.
Rgb from_oklab(double lightness, double chroma, double hue) {
  const double a = chroma * std::cos(hue), b = chroma * std::sin(hue);
  // OKLab to the cubes of cone responses to linear sRGB (matrices of Ottosson 2020).
  const auto cube = [](double v) { return v * v * v; };
  const double l = cube(lightness + 0.3963377774 * a + 0.2158037573 * b);
  const double m = cube(lightness - 0.1055613458 * a - 0.0638541728 * b);
  const double n = cube(lightness - 0.0894841775 * a - 1.2914855480 * b);
  return {byte_of(encoded(4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * n)),
          byte_of(encoded(-1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * n)),
          byte_of(encoded(-0.0041960863 * l - 0.7034186147 * m + 1.7076147010 * n))};
}

Rgb lagoon(double t) {
  const double s = 2 * t - 1;
  const double chroma = 0.094 + s * s * (0.065 + 0.025 * s);
  return from_oklab(0.28 + 0.64 * t, chroma, (305 + (108 - 305) * t) * std::numbers::pi / 180);
}

// Hues in steps of the golden angle, which never come near an earlier one soon, in three lightnesses.
Rgb further_color(std::size_t index) {
  constexpr std::array<double, 3> lightness = {0.52, 0.70, 0.38};
  const double turn = static_cast<double>(index) * (3 - std::sqrt(5.0)) / 2;
  return from_oklab(lightness[index % lightness.size()], 0.11,
                    2 * std::numbers::pi * (turn - std::floor(turn)));
}

}  // namespace

Rgb palette_color(std::size_t index) {
  static constexpr std::array<Rgb, palette_size> palette{{{0x00, 0x72, 0xB2},
                                                          {0xD5, 0x5E, 0x00},
                                                          {0x00, 0x9E, 0x73},
                                                          {0xCC, 0x79, 0xA7},
                                                          {0xE6, 0x9F, 0x00},
                                                          {0x56, 0xB4, 0xE9},
                                                          {0x00, 0x00, 0x00},
                                                          {0x33, 0x22, 0x88},
                                                          {0x88, 0x22, 0x55},
                                                          {0x8C, 0x51, 0x0A}}};
  return index < palette.size() ? palette[index] : further_color(index - palette.size());
}

Rgb map_color(double t) { return lagoon(t > 0 ? std::min(t, 1.0) : 0.0); }  // NaN too becomes 0

}  // namespace meander
