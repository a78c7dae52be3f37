#include "kernels/describe/shape_functions.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

#include "kernels/core/parallel.h"
#include "kernels/core/portable_angles.h"
#include "kernels/core/portable_functions.h"
#include "kernels/core/vector3.h"

namespace meander {

namespace {

constexpr double mean_value_range = 3;  // range of the bins over the mean value

// Draws four different numbers below n >= 4: the k-th of the n - k that are left.
std::array<std::size_t, 4> tuple_of(RandomKey key, std::size_t tuple, std::size_t n) {
  const PhiloxBlock words = random_words(key, Stream::shape_tuple, tuple);
  std::array<std::size_t, 4> drawn{}, sorted{};
  for (std::size_t k = 0; k < 4; ++k) {
    std::size_t number = static_cast<std::size_t>(std::uint64_t{words[k]} * (n - k) >> 32);
    std::size_t at = 0;
    for (; at < k && sorted[at] <= number; ++at) ++number;
    for (std::size_t m = k; m > at; --m) sorted[m] = sorted[m - 1];
    sorted[at] = drawn[k] = number;
  }
  return drawn;
}

double value_of(ShapeFunction function, const std::array<Vector3, 4>& p) {
  const Vector3 a = p[1] - p[0], b = p[2] - p[0];
  switch (function) {
    case ShapeFunction::angle:
      return upper_angle(norm(cross(a, b)), dot(a, b));
    case ShapeFunction::triangle:
      return std::sqrt(0.5 * norm(cross(a, b)));
    default:
      return portable::cbrt(std::abs(dot(cross(a, b), p[3] - p[0])) / 6);
  }
}

Vector3 centroid_of(std::span<const double> coordinates) {
  const std::size_t n = coordinates.size() / 3;
  std::array<double, 3> mean{};
  std::vector<double> column(n);
  for (std::size_t k = 0; k < 3; ++k) {
    for (std::size_t i = 0; i < n; ++i) column[i] = coordinates[3 * i + k];
    mean[k] = blocked_sum(column) / static_cast<double>(n);
  }
  return {mean[0], mean[1], mean[2]};
}

}  // namespace

std::string_view name_of(ShapeFunction function) {
  constexpr std::array<std::string_view, 4> names = {"a3", "d1", "d3", "d4"};
  return names[static_cast<std::size_t>(function)];
}

ShapeHistogram shape_function_histogram(std::span<const float> points, ShapeFunction function, RandomKey key,
                                        const ShapeFunctionParameters& parameters,
                                        const CancelToken& cancel) {
  if (parameters.bins < 8 || parameters.bins > 1024)
    throw std::invalid_argument("a shape function has 8 to 1024 bins, not " +
                                std::to_string(parameters.bins));
  if (parameters.tuples < 1 || parameters.tuples > 1u << 28)
    throw std::invalid_argument("a shape function takes 1 to 2^28 tuples, not " +
                                std::to_string(parameters.tuples));
  if (points.size() < 12 || points.size() % 3 != 0 || points.size() / 3 > 0xFFFFFFFFu)
    throw std::invalid_argument("a shape function needs at least four points of three coordinates");
  std::vector<double> coordinates(points.begin(), points.end());
  for (const double value : coordinates)
    if (!std::isfinite(value)) throw std::invalid_argument("a coordinate that is not finite");
  const std::size_t n = points.size() / 3;
  const auto point = [&](std::size_t i) {
    return Vector3{coordinates[3 * i], coordinates[3 * i + 1], coordinates[3 * i + 2]};
  };

  std::vector<double> values(function == ShapeFunction::centroid ? n : parameters.tuples);
  if (function == ShapeFunction::centroid) {
    const Vector3 centroid = centroid_of(coordinates);
    for (std::size_t i = 0; i < n; ++i) values[i] = distance(point(i), centroid);
  } else {
    parallel_blocks(values.size(), sum_block, [&](std::size_t begin, std::size_t end) {
      cancel.check();
      for (std::size_t t = begin; t < end; ++t) {
        const auto tuple = tuple_of(key, t, n);
        values[t] = value_of(function, {point(tuple[0]), point(tuple[1]), point(tuple[2]), point(tuple[3])});
      }
    });
  }

  ShapeHistogram histogram;
  const auto number = static_cast<double>(values.size());
  histogram.scale = blocked_sum(values) / number;
  histogram.range = function == ShapeFunction::angle ? std::numbers::pi : mean_value_range * histogram.scale;
  const double bins = parameters.bins, factor = histogram.range > 0 ? bins / histogram.range : 0;
  std::vector<std::uint64_t> counts(parameters.bins);
  for (const double value : values) ++counts[static_cast<std::size_t>(std::min(value * factor, bins - 0.5))];
  for (const std::uint64_t count : counts) histogram.shares.push_back(static_cast<double>(count) / number);
  return histogram;
}

}  // namespace meander
