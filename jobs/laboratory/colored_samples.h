// The colors of samples in pictures, and their legend.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "io/plot/picture_sheet.h"
#include "jobs/rows/sample_colorings.h"

namespace meander {

// What the colors of all models of a picture have in common.
struct ColorScale {
  double low = 0, high = 1;           // the range of ColoringKind::number
  bool lacking = false;               // a sample has no value, which is drawn gray
  std::vector<std::int64_t> classes;  // those that are drawn, ascending; more than most_keys: most_keys + 1
  std::vector<std::string> names;     // of classes by number, where they are those of every model
  static constexpr std::size_t most_keys = 8;
};

// Of the first `count` samples (0: all) of these rows, as far as they are ok. Reads them where the coloring
// needs it. Throws RunError.
ColorScale color_scale(const StoreReader& store, std::span<const std::uint64_t> rows, std::size_t count,
                       const SampleColoring& coloring);

// The colors of the first `count` samples of a model with this class (negative: none), or one color for all
// of them; `plain` where colors have no meaning.
std::vector<SrgbColor> colors_of(const Samples& samples, std::int32_t label, std::size_t count,
                                 const SampleColoring& coloring, const ColorScale& scale, SrgbColor plain);

// Nothing where colors have no meaning.
std::optional<SheetLegend> legend_of(const ColorScale& scale, const SampleColoring& coloring);

}  // namespace meander
