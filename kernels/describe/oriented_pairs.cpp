#include "kernels/describe/oriented_pairs.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "kernels/core/portable_angles.h"
#include "kernels/describe/oriented_counts.h"

namespace meander {

OrientedCounter oriented_counter(NormalSense sense, double bins_per_distance) {
  const PairAngleEdges& edges =
      sense == NormalSense::signed_normals ? signed_angle_edges : either_side_angle_edges;
  const auto cosine = [](double degrees) {
    return static_cast<float>(direction_of(degrees * (std::numbers::pi / 180)).cosine);
  };
  OrientedCounter counter{};
  counter.factor = static_cast<float>(std::min(1e30, bins_per_distance));
  for (std::size_t k = 0; k + 1 < pair_angle_bins; ++k) {
    counter.line[k] = cosine(edges.line[k]);
    counter.normals[k] = cosine(edges.normals[k]);
  }
  counter.table.copy_stride = oriented_copy_stride;
  return counter;
}

const OrientedLoops& oriented_loops(InstructionSet set) {
  if constexpr (is_x86)
    return loops_of(set, scalar_oriented_loops, avx2_oriented_loops, avx512_oriented_loops);
  else
    return scalar_oriented_loops;
}

namespace {

std::vector<std::uint64_t> count_pairs(const PairPoints& points, const PairNormals& normals,
                                       const OrientedPairParameters& parameters,
                                       const OrientedCounter& counter, const CancelToken& cancel) {
  const OrientedLoops& loops = oriented_loops(parameters.instructions);
  const auto loop = parameters.sense == NormalSense::signed_normals ? &OrientedLoops::signed_normals
                                                                    : &OrientedLoops::either_side;
  const auto parts =
      results_of_tasks<std::vector<std::uint64_t>>(points.count, [&](std::size_t begin, std::size_t end) {
        std::vector<std::uint32_t> table(pair_copies * oriented_copy_stride);
        OrientedCounter own = counter;
        own.table.table = table.data();
        for_each_tile(points, loops, scalar_oriented_loops, begin, end, cancel,
                      [&](const OrientedLoops& with, const PairTile& places) {
                        (with.*loop)(normals.with(places), own);
                      });
        std::vector<std::uint64_t> counts(oriented_pair_bins);
        for (std::size_t copy = 0; copy < pair_copies; ++copy)
          for (std::size_t b = 0; b < oriented_pair_bins; ++b)
            counts[b] += table[copy * oriented_copy_stride + b];
        return counts;
      });
  std::vector<std::uint64_t> counts(oriented_pair_bins);
  for (const auto& part : parts)
    for (std::size_t b = 0; b < oriented_pair_bins; ++b) counts[b] += part[b];
  return counts;
}

}  // namespace

OrientedPairHistogram oriented_pair_histogram(std::span<const float> points, std::span<const float> normals,
                                              const OrientedPairParameters& parameters,
                                              const CancelToken& cancel) {
  if (points.size() < 6 || points.size() % 3 != 0)
    throw std::invalid_argument(
        "a histogram of oriented pairs needs at least two points of three coordinates");
  if (normals.size() != points.size())
    throw std::invalid_argument("a histogram of oriented pairs needs one normal per point");
  require_available(parameters.instructions);
  check_finite(points, "a coordinate");
  check_finite(normals, "a normal");
  const PairPoints working(points);
  const double mean = mean_distance(working, parameters.instructions, cancel);
  const double bins_per_distance = mean > 0 ? pair_distance_bins / (pair_distance_range * mean) : 0;
  OrientedPairHistogram histogram;
  histogram.pairs = std::uint64_t{working.count} * (working.count - 1) / 2;
  histogram.mean_distance = mean * working.unit;
  histogram.counts = count_pairs(working, PairNormals(normals), parameters,
                                 oriented_counter(parameters.sense, bins_per_distance), cancel);
  for (const std::uint64_t count : histogram.counts)
    histogram.roots.push_back(
        static_cast<float>(std::sqrt(static_cast<double>(count) / static_cast<double>(histogram.pairs))));
  return histogram;
}

}  // namespace meander
