#include "kernels/render/contact_sheet.h"

#include <algorithm>
#include <cmath>

#include "kernels/core/parallel.h"
#include "kernels/render/bitmap_font.h"

namespace meander {

namespace {

constexpr std::uint8_t label_grey = 60;

void copy_cell(RgbImage& sheet, const RgbImage& cell, std::uint32_t x, std::uint32_t y) {
  for (std::uint32_t row = 0; row < cell.height; ++row)
    std::copy_n(cell.pixel(0, row), std::size_t{3} * cell.width, sheet.pixel(x, y + row));
}

}  // namespace

RgbImage contact_sheet(std::span<const SheetModel> models, const ContactSheetParameters& parameters) {
  const auto count = static_cast<std::uint32_t>(std::max<std::size_t>(1, models.size()));
  const std::uint32_t size = parameters.splat.size, gap = parameters.gap, scale = parameters.label_scale;
  // Three quarters of the gap separate a label from its model, the rest comes from the next cell's gap.
  const std::uint32_t label_height = scale == 0 ? 0 : glyph_height * scale + 3 * gap / 4;
  std::uint32_t columns = parameters.columns;
  if (columns == 0) columns = static_cast<std::uint32_t>(std::ceil(std::sqrt(count * 4.0 / 3.0)));
  columns = std::min(columns, count);
  const std::uint32_t rows = (count + columns - 1) / columns;
  const std::uint32_t step_x = size + gap, step_y = size + label_height + gap;
  RgbImage sheet(gap + columns * step_x, gap + rows * step_y);

  parallel_tasks(models.size(), [&](std::size_t i) {
    const SheetModel& model = models[i];
    const auto x = static_cast<std::uint32_t>(gap + i % columns * step_x);
    const auto y = static_cast<std::uint32_t>(gap + i / columns * step_y);
    copy_cell(sheet, splat_picture(model.points, model.normals, model.area, parameters.splat), x, y);
    if (scale == 0) return;
    const std::string label = shortened_text(model.label, size / scale);
    draw_text(sheet, label, x + (size - text_width(label) * scale) / 2, y + size + gap / 2, scale,
              label_grey);
  });
  return sheet;
}

}  // namespace meander
