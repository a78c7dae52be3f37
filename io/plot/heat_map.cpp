#include "io/plot/heat_map.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <vector>

namespace meander {

namespace {

void check(const HeatMapParameters& parameters) {
  const auto is_share = [](double q) { return q >= 0 && q <= 1; };
  if (!is_share(parameters.lower_quantile) || !is_share(parameters.upper_quantile) ||
      parameters.lower_quantile > parameters.upper_quantile)
    throw std::invalid_argument("heat_map: quantiles must rise inside [0, 1]");
  if (parameters.pixels < 1 || parameters.pixels > 64)
    throw std::invalid_argument("heat_map: pixels of a cell must be 1 to 64");
  for (const std::optional<double>& bound : {parameters.lower, parameters.upper})
    if (bound && !std::isfinite(*bound)) throw std::invalid_argument("heat_map: bounds must be finite");
  if (parameters.lower && parameters.upper && *parameters.lower > *parameters.upper)
    throw std::invalid_argument("heat_map: lower > upper");
}

double toned(double t, ToneMap tone) {
  switch (tone) {
    case ToneMap::square_root:
      return std::sqrt(t);
    case ToneMap::logarithm:
      return std::log1p(100 * t) / std::log(101.0);
    case ToneMap::linear:
      break;
  }
  return t;
}

// Place of a value in the range; the middle when the range is empty.
double place(double value, ValueRange range) {
  if (!(range.upper > range.lower)) return 0.5;
  // Halves, so that the difference of two huge bounds stays finite.
  const double t = (0.5 * value - 0.5 * range.lower) / (0.5 * range.upper - 0.5 * range.lower);
  return std::clamp(t, 0.0, 1.0);
}

}  // namespace

ValueRange heat_map_range(std::span<const double> values, const HeatMapParameters& parameters) {
  check(parameters);
  std::vector<double> finite;
  finite.reserve(values.size());
  for (const double value : values)
    if (std::isfinite(value)) finite.push_back(value);
  ValueRange range;
  if (!finite.empty()) {
    const auto quantile = [&](double q) {
      const auto rank = static_cast<std::ptrdiff_t>(std::lround(q * static_cast<double>(finite.size() - 1)));
      std::nth_element(finite.begin(), finite.begin() + rank, finite.end());
      return finite[static_cast<std::size_t>(rank)];
    };
    range = {quantile(parameters.lower_quantile), quantile(parameters.upper_quantile)};
  }
  // A single given bound on the wrong side of the values leaves an empty range there.
  if (parameters.lower) range = {*parameters.lower, std::max(*parameters.lower, range.upper)};
  if (parameters.upper) range = {std::min(range.lower, *parameters.upper), *parameters.upper};
  return range;
}

RgbImage heat_map(std::span<const double> values, std::uint32_t columns, std::uint32_t rows,
                  const HeatMapParameters& parameters) {
  if (values.size() != std::size_t{columns} * rows)
    throw std::invalid_argument("heat_map: values are not rows x columns");
  const ValueRange range = heat_map_range(values, parameters);
  std::array<Rgb, 1024> map;
  for (std::size_t i = 0; i < map.size(); ++i)
    map[i] = map_colour(parameters.colours, static_cast<double>(i) / (map.size() - 1));
  const std::uint32_t side = parameters.pixels;
  RgbImage image(columns * side, rows * side);
  for (std::uint32_t y = 0; y < image.height; ++y) {
    const std::uint32_t row = parameters.upwards ? rows - 1 - y / side : y / side;
    for (std::uint32_t x = 0; x < image.width; ++x) {
      const double value = values[std::size_t{row} * columns + x / side];
      Rgb colour = parameters.not_a_number;
      if (!std::isnan(value)) {
        const double t = toned(place(value, range), parameters.tone);
        colour = map[static_cast<std::size_t>(std::lround(t * (map.size() - 1)))];
      }
      std::uint8_t* pixel = image.pixel(x, y);
      pixel[0] = colour.red;
      pixel[1] = colour.green;
      pixel[2] = colour.blue;
    }
  }
  return image;
}

}  // namespace meander
