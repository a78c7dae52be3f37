#include "io/plot/svg_matrix.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "io/plot/colour.h"
#include "io/plot/svg_writer.h"

namespace meander {

namespace {

constexpr double most_name_width = 140;
constexpr double margin = 12;

double name_width(const std::vector<std::string>& names, double size) {
  double width = 0;
  for (const std::string& name : names) width = std::max(width, svg::text_width(name, size));
  return std::min(width, most_name_width);
}

}  // namespace

Rgb share_colour(double share) {
  const auto mix = [&](double dark) {
    return static_cast<std::uint8_t>(std::lround(255 + share * (dark - 255)));
  };
  return {mix(8), mix(48), mix(107)};
}

Rgb share_text_colour(double share) { return share > 0.5 ? Rgb{255, 255, 255} : Rgb{34, 34, 34}; }

std::string svg_matrix(const NamedMatrix& matrix) {
  const std::size_t rows = matrix.rows.size(), columns = matrix.columns.size();
  if (matrix.values.size() != rows * columns)
    throw std::invalid_argument("a matrix does not fit the names of its rows and columns");
  const double cell =
      std::clamp(1600 / static_cast<double>(std::max<std::size_t>({rows, columns, 1})), 6.0, 36.0);
  const double size = std::clamp(cell * 0.6, 5.0, 12.0);
  const double title = matrix.title.empty() ? 0 : 24, row_label = matrix.row_label.empty() ? 0 : 20,
               column_label = matrix.column_label.empty() ? 0 : 20;
  const double left = margin + row_label + name_width(matrix.rows, size) + 6;
  const double top = margin + title + column_label + name_width(matrix.columns, size) + 6;
  const double right = left + cell * static_cast<double>(columns),
               bottom = top + cell * static_cast<double>(rows);
  std::string out;
  const auto write = [&](const std::string& text, double x, double y, svg::TextStyle style) {
    if (!text.empty()) out += svg::text(text, {x, y}, style);
  };
  write(matrix.title, margin, margin + 12, {.size = 14, .bold = true});
  write(matrix.column_label, (left + right) / 2, margin + title + 12, {.anchor = TextAnchor::middle});
  write(matrix.row_label, margin + 12, (top + bottom) / 2, {.anchor = TextAnchor::middle, .upright = true});
  for (std::size_t j = 0; j < columns; ++j)
    write(svg::fit_text(matrix.columns[j], size, most_name_width),
          left + cell * (static_cast<double>(j) + 0.5) + size * 0.35, top - 6,
          {.size = size, .upright = true});
  for (std::size_t i = 0; i < rows; ++i) {
    const double y = top + cell * static_cast<double>(i), base_line = y + cell / 2 + size * 0.35;
    write(svg::fit_text(matrix.rows[i], size, most_name_width), left - 6, base_line,
          {.size = size, .anchor = TextAnchor::end});
    for (std::size_t j = 0; j < columns; ++j) {
      const double value = matrix.values[i * columns + j];
      if (!std::isfinite(value)) continue;
      const double share = std::clamp(value, 0.0, 1.0), x = left + cell * static_cast<double>(j);
      if (share <= 0) continue;
      out +=
          fmt::format("<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" fill=\"{}\"/>\n", svg::number(x),
                      svg::number(y), svg::number(cell), svg::number(cell), hex_colour(share_colour(share)));
      if (cell >= 18 && share >= 0.005)
        write(
            fmt::format("{}", std::lround(100 * share)), x + cell / 2, base_line,
            {.size = std::min(size, 10.0), .anchor = TextAnchor::middle, .colour = share_text_colour(share)});
    }
  }
  out +=
      fmt::format("<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" fill=\"none\" stroke=\"#555555\"/>\n",
                  svg::number(left), svg::number(top), svg::number(right - left), svg::number(bottom - top));
  const double width = std::max(right, svg::text_width(matrix.title, 15) + margin) + margin;
  return svg::document(width, bottom + margin, matrix.title, out);
}

}  // namespace meander
