// Colors of pictures: a palette for classes and a map for values.
#pragma once

#include <cstddef>
#include <cstdint>

#include "kernels/data/rgb_image.h"

namespace meander {

// An sRGB color.
struct Rgb {
  std::uint8_t red = 0, green = 0, blue = 0;
  friend bool operator==(const Rgb&, const Rgb&) = default;
};

// The color as pixels of pictures store it.
inline SrgbColor srgb(Rgb color) { return {color.red, color.green, color.blue}; }

// Ten colors that stay apart for readers with protanopia and deuteranopia (simulated after Machado et al.
// 2009, any two are at least 0.076 apart in OKLab): those of Okabe and Ito (2008, "Color Universal Design")
// without yellow, which is too pale for lines on white, then indigo and wine of Tol (2021, SRON technical
// note) and brown of ColorBrewer (Harrower and Brewer 2003). From the eleventh on hues in steps of the golden
// angle in three lightnesses: the first distinct_colors differ, though not all are easy to tell apart.
inline constexpr std::size_t palette_size = 10, distinct_colors = 200;
Rgb palette_color(std::size_t index);

// Dark violet over blue and green to yellow, in even steps of lightness (also when printed gray): color of t
// in [0, 1]; values outside are clamped, NaN is 0. A curve in OKLab (Ottosson 2020, "A perceptual color space
// for image processing"): lightness 0.28 + 0.64 t, hue 305 degrees (violet) falling linearly to 108 (yellow),
// chroma 0.094 + 0.065 s^2 + 0.025 s^3 with s = 2 t - 1, which stays inside sRGB.
Rgb map_color(double t);

}  // namespace meander
