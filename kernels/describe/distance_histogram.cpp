#include "kernels/describe/distance_histogram.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include "kernels/core/parallel.h"
#include "kernels/describe/pair_points.h"

namespace meander {

namespace {

const PairLoops& pair_loops(InstructionSet set) {
  if constexpr (is_x86)
    return loops_of(set, scalar_pair_loops, avx2_pair_loops, avx512_pair_loops);
  else
    return scalar_pair_loops;
}

// The points that may be an end of a longest pair: with r the distances from the center of the box, those
// with r + max r at least the length of some pair. Few on most shapes, all on a sphere.
PairPoints far_points(const PairPoints& points) {
  const std::size_t n = points.count;
  const auto middle = [n](const std::vector<float>& values) {
    const auto [low, high] =
        std::minmax_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(n));
    return 0.5 * (double{*low} + double{*high});
  };
  const double cx = middle(points.x), cy = middle(points.y), cz = middle(points.z);
  const auto distance_to = [&](std::size_t i, double x, double y, double z) {
    const double dx = points.x[i] - x, dy = points.y[i] - y, dz = points.z[i] - z;
    return std::sqrt(dx * dx + dy * dy + dz * dz);
  };
  std::vector<double> radius(n);
  for (std::size_t i = 0; i < n; ++i) radius[i] = distance_to(i, cx, cy, cz);
  auto end = static_cast<std::size_t>(std::max_element(radius.begin(), radius.end()) - radius.begin());
  const double max_radius = radius[end];
  double known = 0;
  for (int sweep = 0; sweep < 3; ++sweep) {
    const double x = points.x[end], y = points.y[end], z = points.z[end];
    for (std::size_t i = 0; i < n; ++i)
      if (const double d = distance_to(i, x, y, z); d > known) {
        known = d;
        end = i;
      }
  }
  PairPoints far;
  for (std::size_t i = 0; i < n; ++i) {
    if (radius[i] + max_radius < known * (1 - 1e-5)) continue;  // beyond the error of float distances
    far.x.push_back(points.x[i]);
    far.y.push_back(points.y[i]);
    far.z.push_back(points.z[i]);
  }
  far.repeat();
  return far;
}

double largest_distance(const PairPoints& points, const PairLoops& loops, const CancelToken& cancel) {
  const PairPoints far = far_points(points);
  const auto largest = results_of_tasks<float>(far.count, [&](std::size_t begin, std::size_t end) {
    float squared = 0;
    for_each_tile(far, loops, scalar_pair_loops, begin, end, cancel,
                  [&](const PairLoops& with, const PairTile& tile) {
                    squared = std::max(squared, with.largest(tile));
                  });
    return squared;
  });
  return std::sqrt(static_cast<double>(*std::max_element(largest.begin(), largest.end())));
}

// Adds the counts of a table, over its copies and, where it is joint, along rows and columns.
void add_counts(const PairCounter& counter, std::span<std::uint64_t> counts) {
  const std::size_t bins = counts.size(), side = std::size_t{1} << counter.side_bits;
  for (std::size_t copy = 0; copy < pair_copies; ++copy) {
    const std::uint32_t* table = counter.table + copy * counter.copy_stride;
    for (std::size_t row = 0; row < (counter.side_bits > 0 ? bins : 1); ++row)
      for (std::size_t column = 0; column < bins; ++column) {
        const std::uint32_t count = table[row * side + column];
        counts[column] += count;
        if (counter.side_bits > 0) counts[row] += count;
      }
  }
}

// Counts the pairs. range: working units; 0 puts every pair into bin 0.
void count_pairs(const PairPoints& points, const PairLoops& loops, double range, const CancelToken& cancel,
                 DistanceHistogram& histogram) {
  const std::size_t bins = histogram.counts.size();
  PairCounter counter;
  counter.factor = range > 0 ? static_cast<float>(std::min(1e30, static_cast<double>(bins) / range)) : 0.0f;
  counter.top = static_cast<float>(bins) - 0.5f;
  counter.side_bits = bins <= max_joint_bins ? static_cast<unsigned>(std::bit_width(bins - 1)) : 0u;
  counter.copy_stride = counter.side_bits > 0 ? std::size_t{1} << (2 * counter.side_bits) : bins;
  const auto parts =
      results_of_tasks<std::vector<std::uint64_t>>(points.count, [&](std::size_t begin, std::size_t end) {
        std::vector<std::uint32_t> table(pair_copies * counter.copy_stride);
        PairCounter own = counter;
        own.table = table.data();
        for_each_tile(points, loops, scalar_pair_loops, begin, end, cancel,
                      [&](const PairLoops& with, const PairTile& tile) { with.count(tile, own); });
        std::vector<std::uint64_t> counts(bins);
        add_counts(own, counts);
        return counts;
      });
  std::uint64_t all = 0;
  for (const auto& part : parts)
    for (std::size_t b = 0; b < bins; ++b) {
      histogram.counts[b] += part[b];
      all += part[b];
    }
  histogram.counts[0] -= all - histogram.pairs;  // the pads
}

}  // namespace

void check_histogram_parameters(const DistanceHistogramParameters& parameters) {
  if (parameters.bins < 8 || parameters.bins > 1024)
    throw std::invalid_argument("a distance histogram has 8 to 1024 bins, not " +
                                std::to_string(parameters.bins));
  if (!(parameters.range >= 0) || !std::isfinite(parameters.range))
    throw std::invalid_argument("the range of a distance histogram is 0 or a positive number");
  require_available(parameters.instructions);
}

double mean_distance(const PairPoints& points, InstructionSet instructions, const CancelToken& cancel) {
  const PairLoops& loops = pair_loops(instructions);
  const auto sums = results_of_tasks<std::uint64_t>(points.count, [&](std::size_t begin, std::size_t end) {
    std::uint64_t sum = 0;
    for_each_tile(points, loops, scalar_pair_loops, begin, end, cancel,
                  [&](const PairLoops& with, const PairTile& tile) { sum += with.sum(tile); });
    return sum;
  });
  const double pairs = 0.5 * static_cast<double>(points.count) * static_cast<double>(points.count - 1);
  double sum = 0;
  for (const std::uint64_t part : sums) sum += static_cast<double>(part);
  return sum / pairs / distance_unit;
}

DistanceHistogram distance_histogram(std::span<const float> points,
                                     const DistanceHistogramParameters& parameters,
                                     const CancelToken& cancel) {
  check_histogram_parameters(parameters);
  if (points.size() < 6 || points.size() % 3 != 0)
    throw std::invalid_argument("a distance histogram needs at least two points of three coordinates");
  check_finite(points, "a coordinate");
  const PairPoints working(points);
  const PairLoops& loops = pair_loops(parameters.instructions);
  DistanceHistogram histogram;
  histogram.pairs = std::uint64_t{working.count} * (working.count - 1) / 2;
  histogram.counts.resize(parameters.bins);
  const bool by_mean = parameters.scale == HistogramScale::mean;
  const double scale = by_mean ? mean_distance(working, parameters.instructions, cancel)
                               : largest_distance(working, loops, cancel);
  const double range = parameters.range > 0 ? parameters.range / working.unit
                                            : (by_mean ? histogram_range_per_mean : 1) * scale;
  count_pairs(working, loops, range, cancel, histogram);
  histogram.scale = scale * working.unit;
  histogram.range = range * working.unit;
  for (const std::uint64_t count : histogram.counts)
    histogram.shares.push_back(static_cast<double>(count) / static_cast<double>(histogram.pairs));
  return histogram;
}

}  // namespace meander
