#include "io/plot/picture_row.h"

#include <algorithm>
#include <cmath>

#include "io/plot/text_painter.h"

namespace meander {

namespace {

constexpr Rgb title_colour{35, 38, 45}, line_colour{72, 76, 85};
constexpr double line_height = 1.4;  // ems from one line to the next

// Smaller where it would be wider than `room`.
void draw_centred(RgbImage& image, const std::string& text, double middle, double baseline, TextStyle style,
                  double room) {
  const double width = painted_width(text, style);
  if (width > room) style.size = std::max(1.0, style.size * room / width);
  paint_text(image, text, middle, baseline, style, TextAlign::centre);
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
  const double title_line = 1.4 * parameters.gap + height + parameters.title_size,
               first_line = title_line + 0.3 * parameters.title_size + line_height * parameters.line_size;
  RgbImage row(width, static_cast<std::uint32_t>(std::lround(
                          first_line + line_height * parameters.line_size * (static_cast<double>(lines) - 1) +
                          0.3 * parameters.line_size + 0.5 * parameters.gap)));
  std::uint32_t x = parameters.gap;
  for (const CaptionedPicture& picture : pictures) {
    for (std::uint32_t y = 0; y < picture.image.height; ++y)
      std::copy_n(picture.image.pixel(0, y), std::size_t{3} * picture.image.width,
                  row.pixel(x, parameters.gap + y));
    const double middle = x + 0.5 * picture.image.width, room = picture.image.width + 0.4 * parameters.gap;
    draw_centred(row, picture.title, middle, title_line, {parameters.title_size, false, title_colour}, room);
    for (std::size_t l = 0; l < picture.lines.size(); ++l)
      draw_centred(row, picture.lines[l], middle,
                   first_line + line_height * parameters.line_size * static_cast<double>(l),
                   {parameters.line_size, false, line_colour}, room);
    x += picture.image.width + parameters.gap;
  }
  return row;
}

}  // namespace meander
