// Small labels for pictures: a fixed-width bitmap font of 5 x 7 pixels for printable ASCII.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include "kernels/render/rgb_image.h"

namespace meander {

inline constexpr std::uint32_t glyph_width = 5, glyph_height = 7;
inline constexpr std::uint32_t glyph_advance = 6;  // pixels from one glyph to the next, at scale 1

// Width of a text in pixels at scale 1: 6 per character without the last gap. Characters are bytes of UTF-8
// that begin one (each character outside ASCII is one box).
std::uint32_t text_width(std::string_view text);

// The text if it fits into `width` pixels at scale 1, else its beginning and end with `..` between them.
std::string shortened_text(std::string_view text, std::uint32_t width);

// Draws with the upper left corner at (x, y); every font pixel becomes scale x scale. What lies outside the
// picture is cut off. Characters outside ASCII appear as a box.
void draw_text(RgbImage& image, std::string_view text, std::int64_t x, std::int64_t y, std::uint32_t scale,
               std::uint8_t grey);

// The same glyphs as smooth strokes of a round pen through their pixels, each as wide as it is, in a colour
// that is mixed with what is there: for texts that are larger than the font. size: pixels from one pixel of
// the font to the next, so that capitals are 6 size high; (x, y): centre of the upper left one.
void draw_smooth_text(RgbImage& image, std::string_view text, double x, double y, double size,
                      std::array<std::uint8_t, 3> colour);
double smooth_text_width(std::string_view text, double size);

}  // namespace meander
