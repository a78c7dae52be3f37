// Pictures of many items on one sheet, with their names.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "io/plot/color.h"
#include "kernels/data/rgb_image.h"

namespace meander {

struct SheetCell {
  RgbImage picture;    // of the size of a cell; empty: a tile with the words of `failure`
  std::string title;   // below the picture; of one that is too long the end is shown
  std::string note{};  // a second, smaller line; empty: none
  Rgb note_color{120, 120, 120};
  std::string failure{};       // why there is no picture; empty as well: the place stays white
  std::optional<Rgb> frame{};  // around the picture
};

// What the colors of a sheet mean: a bar from `low` to `high`, or the words of `title`, and colors with
// their meanings behind it.
struct LegendKey {
  Rgb color;
  std::string text;
};
struct SheetLegend {
  std::string title;
  bool bar = false;
  std::string low, high;
  std::vector<LegendKey> keys{};
};

struct SheetLook {
  std::uint32_t cell = 360;   // pixels, width and height of a picture; 32..4096
  std::uint32_t columns = 0;  // 0: as many as make the sheet about 4 : 3
  double text_size = 15;      // pixels of an em
  std::uint32_t gap = 18;     // pixels between cells and at the border
};

// Cells row by row from the upper left on white, the legend below. Without cells one empty cell. Throws
// std::invalid_argument for a picture of another size than a cell's, and what paint_text throws.
RgbImage picture_sheet(std::span<const SheetCell> cells, const std::optional<SheetLegend>& legend,
                       const SheetLook& look = {});

}  // namespace meander
