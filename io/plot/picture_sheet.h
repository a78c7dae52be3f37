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
  RgbImage picture;    // of the size of a cell; empty: a tile with the text of `failure`
  std::string title;   // below the picture; only the end of a long one is shown
  std::string note{};  // a second, smaller line; empty: none
  Rgb note_color{120, 120, 120};
  std::string failure{};       // the reason for no picture; empty too: the cell stays white
  std::optional<Rgb> frame{};  // around the picture
};

// The meaning of the colors of a sheet: a bar from `low` to `high` or the text of `title`, followed by colors
// with their meanings.
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
  std::uint32_t columns = 0;  // 0: for a sheet of about 4 : 3
  double text_size = 15;      // pixels of an em
  std::uint32_t gap = 18;     // pixels between cells and at the border
};

// The sheet: cells row by row from the upper left on white, with the legend below; one empty cell if there
// are none. Throws std::invalid_argument for a picture that is not of the size of a cell, and what paint_text
// throws.
RgbImage picture_sheet(std::span<const SheetCell> cells, const std::optional<SheetLegend>& legend,
                       const SheetLook& look = {});

}  // namespace meander
