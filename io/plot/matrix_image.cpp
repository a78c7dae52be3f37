#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string_view>

#include "io/plot/svg_matrix.h"
#include "kernels/render/bitmap_font.h"

namespace meander {

namespace {

constexpr std::uint32_t most_name_width = 140, margin = 12, gap = 5, line = 20;
constexpr std::uint32_t number_cell = 20, name_cell = 8;
constexpr std::size_t most_cells = 4096;

void fill(RgbImage& image, std::uint32_t x, std::uint32_t y, std::uint32_t width, std::uint32_t height,
          Rgb colour) {
  for (std::uint32_t row = y; row < y + height; ++row)
    for (std::uint32_t column = x; column < x + width; ++column) {
      std::uint8_t* const pixel = image.pixel(column, row);
      pixel[0] = colour.red;
      pixel[1] = colour.green;
      pixel[2] = colour.blue;
    }
}

void draw_centred(RgbImage& image, std::string_view text, std::uint32_t x, std::uint32_t y,
                  std::uint32_t scale) {
  const std::int64_t half = scale * text_width(text) / 2;
  draw_text(image, text, x - half, y - scale * glyph_height / 2, scale, 34);
}

// Reads upwards, the end of the text at the bottom left corner (x, y) of what it covers.
void draw_upright(RgbImage& image, std::string_view text, std::uint32_t x, std::uint32_t y) {
  const std::uint32_t width = text_width(text);
  RgbImage lying(width, glyph_height);
  draw_text(lying, text, 0, 0, 1, 34);
  for (std::uint32_t row = 0; row < glyph_height; ++row)
    for (std::uint32_t column = 0; column < width; ++column)
      if (y >= column + 1 && y - column - 1 < image.height && x + row < image.width)
        std::copy_n(lying.pixel(column, row), 3, image.pixel(x + row, y - column - 1));
}

std::uint32_t names_width(const std::vector<std::string>& names) {
  std::uint32_t width = 0;
  for (const std::string& name : names) width = std::max(width, text_width(name));
  return std::min(width, most_name_width) + gap;
}

// Where the parts of the picture are, in pixels.
struct Layout {
  std::uint32_t cell = 1, left = 0, top = 0, width = 0, height = 0;

  explicit Layout(const NamedMatrix& matrix) {
    const std::size_t rows = matrix.rows.size(), columns = matrix.columns.size();
    cell = static_cast<std::uint32_t>(
        std::clamp<std::size_t>(1600 / std::max<std::size_t>({rows, columns, 1}), 1, 36));
    const bool named = cell >= name_cell;
    left = margin + (matrix.row_label.empty() ? 0 : line) + (named ? names_width(matrix.rows) : 0);
    top = margin + (matrix.title.empty() ? 0 : line) + (matrix.column_label.empty() ? 0 : line) +
          (named ? names_width(matrix.columns) : 0);
    width = std::max(left + cell * static_cast<std::uint32_t>(columns), margin + text_width(matrix.title)) +
            margin;
    height = top + cell * static_cast<std::uint32_t>(rows) + margin;
  }
  std::uint32_t x(std::size_t column) const { return left + cell * static_cast<std::uint32_t>(column); }
  std::uint32_t y(std::size_t row) const { return top + cell * static_cast<std::uint32_t>(row); }
};

void draw_names(RgbImage& image, const NamedMatrix& matrix, const Layout& at) {
  const std::uint32_t columns_end = at.x(matrix.columns.size()), rows_end = at.y(matrix.rows.size());
  draw_text(image, matrix.title, margin, margin, 1, 0);
  draw_centred(image, matrix.column_label, (at.left + columns_end) / 2,
               margin + (matrix.title.empty() ? 0 : line) + glyph_height / 2, 1);
  draw_upright(image, matrix.row_label, margin, (at.top + rows_end + text_width(matrix.row_label)) / 2);
  if (at.cell < name_cell) return;
  for (std::size_t j = 0; j < matrix.columns.size(); ++j)
    draw_upright(image, shortened_text(matrix.columns[j], most_name_width),
                 at.x(j) + (at.cell - glyph_height) / 2, at.top - gap);
  for (std::size_t i = 0; i < matrix.rows.size(); ++i) {
    const std::string name = shortened_text(matrix.rows[i], most_name_width);
    draw_text(image, name, std::int64_t{at.left} - gap - text_width(name),
              at.y(i) + (at.cell - glyph_height) / 2, 1, 34);
  }
}

void draw_cell(RgbImage& image, double value, std::uint32_t x, std::uint32_t y, std::uint32_t cell) {
  if (!std::isfinite(value)) return;
  const double share = std::clamp(value, 0.0, 1.0);
  if (share <= 0) return;
  fill(image, x, y, cell, cell, share_colour(share));
  if (cell < number_cell || share < 0.005) return;
  const std::string number = fmt::format("{}", std::lround(100 * share));
  draw_text(image, number, x + (cell - text_width(number)) / 2, y + (cell - glyph_height) / 2, 1,
            share_text_colour(share).red);
}

}  // namespace

RgbImage matrix_image(const NamedMatrix& matrix) {
  const std::size_t rows = matrix.rows.size(), columns = matrix.columns.size();
  if (matrix.values.size() != rows * columns)
    throw std::invalid_argument("a matrix does not fit the names of its rows and columns");
  if (std::max(rows, columns) > most_cells)
    throw std::invalid_argument("a picture of a matrix has at most 4096 rows and columns");
  const Layout at(matrix);
  RgbImage image(at.width, at.height);
  for (std::size_t i = 0; i < rows; ++i)
    for (std::size_t j = 0; j < columns; ++j)
      draw_cell(image, matrix.values[i * columns + j], at.x(j), at.y(i), at.cell);
  const Rgb frame{85, 85, 85};
  const std::uint32_t width = at.x(columns) - at.left, height = at.y(rows) - at.top;
  fill(image, at.left - 1, at.top - 1, width + 2, 1, frame);
  fill(image, at.left - 1, at.y(rows), width + 2, 1, frame);
  fill(image, at.left - 1, at.top - 1, 1, height + 2, frame);
  fill(image, at.x(columns), at.top - 1, 1, height + 2, frame);
  draw_names(image, matrix, at);
  return image;
}

}  // namespace meander
