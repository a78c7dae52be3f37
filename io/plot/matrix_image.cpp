#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string_view>

#include "io/plot/svg_matrix.h"
#include "io/plot/text_painter.h"

namespace meander {

namespace {

constexpr double most_name_pixels = 140;
constexpr std::uint32_t image_margin = 12, gap = 5, line = 20;
constexpr std::uint32_t number_cell = 20, name_cell = 8;
constexpr std::size_t most_cells = 4096;

TextStyle name_style(std::uint32_t cell) { return {.size = std::clamp(0.7 * cell, 7.0, 12.0)}; }
const TextStyle title_style{.size = 14, .bold = true}, label_style{.size = 12};
constexpr double capital = 0.72;  // height of capitals over the size of the text

// From its upper or left edge to the line that the text stands on, so that capitals are in the middle.
double base_line(double extent, double size) { return 0.5 * (extent + capital * size); }

// Reads upwards; the text begins at the lower end of what it covers, a strip from x on, and ends above y.
void paint_upright(RgbImage& image, std::string_view text, std::uint32_t x, std::uint32_t y,
                   std::uint32_t strip, const TextStyle& style) {
  RgbImage lying(static_cast<std::uint32_t>(std::ceil(painted_width(text, style))) + 2, strip);
  paint_text(lying, text, 1, base_line(strip, style.size), style);
  for (std::uint32_t row = 0; row < strip; ++row)
    for (std::uint32_t column = 0; column < std::min(lying.width, y); ++column)
      if (x + row < image.width && y - column - 1 < image.height)
        std::copy_n(lying.pixel(column, row), 3, image.pixel(x + row, y - column - 1));
}

std::uint32_t names_width(const std::vector<std::string>& names, const TextStyle& style) {
  double width = 0;
  for (const std::string& name : names) width = std::max(width, painted_width(name, style));
  return static_cast<std::uint32_t>(std::ceil(std::min(width, most_name_pixels))) + gap;
}

// Where the parts of the picture are, in pixels.
struct MatrixLayout {
  std::uint32_t cell = 1, left = 0, top = 0, width = 0, height = 0;

  explicit MatrixLayout(const NamedMatrix& matrix) {
    const std::size_t rows = matrix.rows.size(), columns = matrix.columns.size();
    cell = static_cast<std::uint32_t>(
        std::clamp<std::size_t>(1600 / std::max<std::size_t>({rows, columns, 1}), 1, 36));
    const bool named = cell >= name_cell;
    left = image_margin + (matrix.row_label.empty() ? 0 : line) +
           (named ? names_width(matrix.rows, name_style(cell)) : 0);
    top = image_margin + (matrix.title.empty() ? 0 : line) + (matrix.column_label.empty() ? 0 : line) +
          (named ? names_width(matrix.columns, name_style(cell)) : 0);
    width = std::max(left + cell * static_cast<std::uint32_t>(columns),
                     image_margin + static_cast<std::uint32_t>(painted_width(matrix.title, title_style))) +
            image_margin;
    height = top + cell * static_cast<std::uint32_t>(rows) + image_margin;
  }
  std::uint32_t x(std::size_t column) const { return left + cell * static_cast<std::uint32_t>(column); }
  std::uint32_t y(std::size_t row) const { return top + cell * static_cast<std::uint32_t>(row); }
};

void paint_names(RgbImage& image, const NamedMatrix& matrix, const MatrixLayout& at) {
  const std::uint32_t columns_end = at.x(matrix.columns.size()), rows_end = at.y(matrix.rows.size());
  paint_text(image, matrix.title, image_margin, image_margin + base_line(line, title_style.size) - 4,
             title_style);
  paint_text(image, matrix.column_label, 0.5 * (at.left + columns_end),
             image_margin + (matrix.title.empty() ? 0 : line) + base_line(line, label_style.size),
             label_style, TextAlign::centre);
  const double half = 0.5 * painted_width(matrix.row_label, label_style);
  paint_upright(image, matrix.row_label, image_margin,
                static_cast<std::uint32_t>(0.5 * (at.top + rows_end) + half), line, label_style);
  if (at.cell < name_cell) return;
  const TextStyle style = name_style(at.cell);
  for (std::size_t j = 0; j < matrix.columns.size(); ++j)
    paint_upright(image, shortened_at_front(matrix.columns[j], most_name_pixels, style), at.x(j),
                  at.top - gap, at.cell, style);
  for (std::size_t i = 0; i < matrix.rows.size(); ++i)
    paint_text(image, shortened_at_front(matrix.rows[i], most_name_pixels, style), at.left - gap,
               at.y(i) + base_line(at.cell, style.size), style, TextAlign::right);
}

void draw_cell(RgbImage& image, double value, std::uint32_t x, std::uint32_t y, std::uint32_t cell) {
  if (!std::isfinite(value)) return;
  const double share = std::clamp(value, 0.0, 1.0);
  if (share <= 0) return;
  image.fill(x, y, cell, cell, srgb(share_colour(share)));
  if (cell < number_cell || share < 0.005) return;
  const TextStyle style{.size = 11, .colour = share_text_colour(share)};
  paint_text(image, fmt::format("{}", std::lround(100 * share)), x + 0.5 * cell,
             y + base_line(cell, style.size), style, TextAlign::centre);
}

}  // namespace

RgbImage matrix_image(const NamedMatrix& matrix) {
  const std::size_t rows = matrix.rows.size(), columns = matrix.columns.size();
  if (matrix.values.size() != rows * columns)
    throw std::invalid_argument("a matrix does not fit the names of its rows and columns");
  if (std::max(rows, columns) > most_cells)
    throw std::invalid_argument("a picture of a matrix has at most 4096 rows and columns");
  const MatrixLayout at(matrix);
  RgbImage image(at.width, at.height);
  for (std::size_t i = 0; i < rows; ++i)
    for (std::size_t j = 0; j < columns; ++j)
      draw_cell(image, matrix.values[i * columns + j], at.x(j), at.y(i), at.cell);
  const Rgb frame{85, 85, 85};
  const std::uint32_t width = at.x(columns) - at.left, height = at.y(rows) - at.top;
  image.fill(at.left - 1, at.top - 1, width + 2, 1, srgb(frame));
  image.fill(at.left - 1, at.y(rows), width + 2, 1, srgb(frame));
  image.fill(at.left - 1, at.top - 1, 1, height + 2, srgb(frame));
  image.fill(at.x(columns), at.top - 1, 1, height + 2, srgb(frame));
  paint_names(image, matrix, at);
  return image;
}

}  // namespace meander
