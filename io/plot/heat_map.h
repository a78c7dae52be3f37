// Arrays of values as coloured pictures.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "io/plot/colour.h"
#include "kernels/render/rgb_image.h"

namespace meander {

// How t = (value - lower) / (upper - lower), clamped to [0, 1], becomes the place on the colour map.
enum class ToneMap {
  linear,
  square_root,  // amplitude instead of power
  logarithm,    // log(1 + 100 t) / log(101): weak rings of a spectrum beside strong ones
};

struct HeatMapParameters {
  ColourMap colours = ColourMap::grey;
  ToneMap tone = ToneMap::linear;
  std::optional<double> lower{}, upper{};         // without them:
  double lower_quantile = 0, upper_quantile = 1;  // the values below which this share of the finite ones lies
  std::uint32_t pixels = 1;                       // of a cell along each side, 1..64
  bool upwards = false;                           // the first row is the bottom one
  Rgb not_a_number{200, 60, 160};
};

struct ValueRange {
  double lower = 0, upper = 1;
};

// The range that heat_map uses, for captions. Quantiles are those of the sorted finite values at the rounded
// place q (count - 1). No finite value: [0, 1]. O(values log values).
ValueRange heat_map_range(std::span<const double> values, const HeatMapParameters& parameters);

// values: rows x columns, row by row (x fastest), the top row first unless `upwards`. When the range is empty
// (all values equal) every cell gets the middle of the map. Infinite values are clamped like others, NaN gets
// `not_a_number`. No cells: a picture of size 0 x 0. Throws std::invalid_argument when the size does not fit,
// pixels or quantiles are out of range, or lower > upper.
RgbImage heat_map(std::span<const double> values, std::uint32_t columns, std::uint32_t rows,
                  const HeatMapParameters& parameters = {});

}  // namespace meander
