#include "kernels/render/picture_row.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "kernels/render/bitmap_font.h"

namespace meander {

namespace {

constexpr std::array<std::uint8_t, 3> title_colour = {35, 38, 45}, line_colour = {72, 76, 85};
constexpr double line_height = 12;  // font pixels from one line to the next

// Smaller where it would be wider than `room`.
void draw_centred(RgbImage& image, const std::string& text, double middle, double y, double size, double room,
                  std::array<std::uint8_t, 3> colour) {
  const double width = smooth_text_width(text, size);
  if (width > room) size *= room / width;
  draw_smooth_text(image, text, middle - 0.5 * smooth_text_width(text, size), y, size, colour);
}

}  // namespace

RgbImage picture_row(std::span<const CaptionedPicture> pictures, const PictureRowParameters& parameters) {
  if (pictures.empty()) return {};
  std::uint32_t width = parameters.gap, height = 0;
  std::size_t lines = 0;
  for (const CaptionedPicture& picture : pictures) {
    width += picture.image.width + parameters.gap;
    height = std::max(height, picture.image.height);
    lines = std::max(lines, picture.lines.size());
  }
  const double title_top = 1.4 * parameters.gap + height + 2 * parameters.title_size,
               lines_top = title_top + line_height * parameters.title_size;
  RgbImage row(width, static_cast<std::uint32_t>(std::lround(
                          lines_top + line_height * parameters.line_size * static_cast<double>(lines) +
                          0.5 * parameters.gap)));
  std::uint32_t x = parameters.gap;
  for (const CaptionedPicture& picture : pictures) {
    for (std::uint32_t y = 0; y < picture.image.height; ++y)
      std::copy_n(picture.image.pixel(0, y), std::size_t{3} * picture.image.width,
                  row.pixel(x, parameters.gap + y));
    const double middle = x + 0.5 * picture.image.width, room = picture.image.width + 0.4 * parameters.gap;
    draw_centred(row, picture.title, middle, title_top, parameters.title_size, room, title_colour);
    for (std::size_t l = 0; l < picture.lines.size(); ++l)
      draw_centred(row, picture.lines[l], middle,
                   lines_top + line_height * parameters.line_size * static_cast<double>(l),
                   parameters.line_size, room, line_colour);
    x += picture.image.width + parameters.gap;
  }
  return row;
}

}  // namespace meander
