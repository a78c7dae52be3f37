#include "io/plot/picture_sheet.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "io/plot/text_painter.h"

namespace meander {

namespace {

constexpr Rgb caption_color{40, 40, 40}, failure_color{150, 60, 40};
constexpr std::uint8_t tile_gray = 243;

void draw_failure(RgbImage& sheet, const std::string& words, std::uint32_t x, std::uint32_t y,
                  const SheetLook& look) {
  sheet.fill(x, y, look.cell, look.cell, {tile_gray, tile_gray, tile_gray});
  const TextStyle style{look.text_size, false, failure_color};
  const double line = 1.4 * look.text_size, room = look.cell - 2 * look.text_size;
  const auto most = static_cast<std::size_t>(std::max(1.0, std::floor(0.8 * look.cell / line)));
  const std::vector<std::string> lines = wrapped_text(words, room, most, style);
  double baseline =
      y + 0.5 * look.cell - 0.5 * line * static_cast<double>(lines.size() - 1) + 0.35 * look.text_size;
  for (const std::string& text : lines) {
    paint_text(sheet, text, x + 0.5 * look.cell, baseline, style, TextAlign::center);
    baseline += line;
  }
}

void draw_frame(RgbImage& sheet, Rgb color, std::uint32_t x, std::uint32_t y, const SheetLook& look) {
  const std::uint32_t width = std::max<std::uint32_t>(2, look.cell / 60);
  sheet.fill(x, y, look.cell, width, srgb(color));
  sheet.fill(x, y + look.cell - width, look.cell, width, srgb(color));
  sheet.fill(x, y, width, look.cell, srgb(color));
  sheet.fill(x + look.cell - width, y, width, look.cell, srgb(color));
}

void draw_cell(RgbImage& sheet, const SheetCell& cell, std::uint32_t x, std::uint32_t y,
               const SheetLook& look) {
  if (cell.picture.width == 0 && cell.failure.empty()) {
    // An empty cell stays white.
  } else if (cell.picture.width == 0) {
    draw_failure(sheet, cell.failure, x, y, look);
  } else {
    if (cell.picture.width != look.cell || cell.picture.height != look.cell)
      throw std::invalid_argument("a picture of a sheet must have the size of a cell");
    for (std::uint32_t row = 0; row < look.cell; ++row)
      std::copy_n(cell.picture.pixel(0, row), std::size_t{3} * look.cell, sheet.pixel(x, y + row));
  }
  if (cell.frame) draw_frame(sheet, *cell.frame, x, y, look);
  const TextStyle title{look.text_size, false, caption_color};
  const double middle = x + 0.5 * look.cell;
  paint_text(sheet, shortened_at_front(cell.title, look.cell, title), middle,
             y + look.cell + 1.1 * look.text_size, title, TextAlign::center);
  if (cell.note.empty()) return;
  const TextStyle note{0.85 * look.text_size, false, cell.note_color};
  paint_text(sheet, shortened_at_front(cell.note, look.cell, note), middle,
             y + look.cell + 2.4 * look.text_size, note, TextAlign::center);
}

double bar_length(const SheetLook& look) { return 20 * look.text_size; }

// The width of a legend in pixels.
double legend_width(const SheetLegend& legend, const SheetLook& look) {
  const TextStyle style{look.text_size};
  double title = painted_width(legend.title, style);
  for (const LegendKey& key : legend.keys) title += 2.5 * look.text_size + painted_width(key.text, style);
  if (!legend.bar) return title;
  const double ends = std::max(painted_width(legend.low, style), painted_width(legend.high, style));
  return std::max(title, bar_length(look) + 2 * ends + look.text_size);
}

void draw_legend(RgbImage& sheet, const SheetLegend& legend, double top, const SheetLook& look) {
  const TextStyle style{look.text_size, false, caption_color};
  const double middle = 0.5 * sheet.width, baseline = top + look.text_size;
  if (!legend.keys.empty()) {
    double x = 0.5 * (sheet.width - legend_width(legend, look));
    paint_text(sheet, legend.title, x, baseline, style);
    x += painted_width(legend.title, style);
    const auto side = static_cast<std::uint32_t>(0.9 * look.text_size);
    for (const LegendKey& key : legend.keys) {
      x += 1.2 * look.text_size;
      sheet.fill(static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(baseline) - side + 1, side, side,
                 srgb(key.color));
      x += 1.3 * look.text_size;
      paint_text(sheet, key.text, x, baseline, style);
      x += painted_width(key.text, style);
    }
    return;
  }
  paint_text(sheet, legend.title, middle, baseline, style, TextAlign::center);
  if (!legend.bar) return;
  const double length = bar_length(look), begin = middle - 0.5 * length;
  const auto y = static_cast<std::uint32_t>(baseline + 0.6 * look.text_size);
  const auto height = static_cast<std::uint32_t>(look.text_size);
  for (std::uint32_t i = 0; i < static_cast<std::uint32_t>(length); ++i) {
    sheet.fill(static_cast<std::uint32_t>(begin) + i, y, 1, height, srgb(map_color(i / (length - 1))));
  }
  paint_text(sheet, legend.low, begin - 0.5 * look.text_size, y + 0.85 * height, style, TextAlign::right);
  paint_text(sheet, legend.high, begin + length + 0.5 * look.text_size, y + 0.85 * height, style);
}

}  // namespace

RgbImage picture_sheet(std::span<const SheetCell> cells, const std::optional<SheetLegend>& legend,
                       const SheetLook& look) {
  const auto count = static_cast<std::uint32_t>(std::max<std::size_t>(1, cells.size()));
  std::uint32_t columns = look.columns;
  if (columns == 0) columns = static_cast<std::uint32_t>(std::ceil(std::sqrt(count * 4.0 / 3.0)));
  columns = std::min(columns, count);
  const std::uint32_t rows = (count + columns - 1) / columns;
  const bool has_notes =
      std::any_of(cells.begin(), cells.end(), [](const SheetCell& c) { return !c.note.empty(); });
  const auto caption = static_cast<std::uint32_t>(std::ceil((has_notes ? 2.8 : 1.5) * look.text_size));
  const std::uint32_t step_x = look.cell + look.gap, step_y = look.cell + caption + look.gap;
  const double legend_height = !legend ? 0 : (legend->bar ? 3.2 : 1.6) * look.text_size;
  const double legend_room = legend ? legend_width(*legend, look) + 2 * look.gap : 0;
  RgbImage sheet(std::max(look.gap + columns * step_x, static_cast<std::uint32_t>(std::ceil(legend_room))),
                 look.gap + rows * step_y + static_cast<std::uint32_t>(std::ceil(legend_height)));
  for (std::uint32_t i = 0; i < cells.size(); ++i)
    draw_cell(sheet, cells[i], look.gap + i % columns * step_x, look.gap + i / columns * step_y, look);
  if (legend) draw_legend(sheet, *legend, look.gap + rows * step_y, look);
  return sheet;
}

}  // namespace meander
