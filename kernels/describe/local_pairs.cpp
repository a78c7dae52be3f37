#include "kernels/describe/local_pairs.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "kernels/core/parallel.h"
#include "kernels/describe/oriented_counts.h"

namespace meander {

namespace {

constexpr std::size_t centers_per_task = 16;

// In working units, as the following.
double root_mean_square_distance(const PairPoints& points) {
  double sums[3] = {}, squares = 0;
  const std::vector<float>* const axes[] = {&points.x, &points.y, &points.z};
  for (std::size_t k = 0; k < 3; ++k)
    for (std::size_t i = 0; i < points.count; ++i) sums[k] += static_cast<double>((*axes[k])[i]);
  const auto count = static_cast<double>(points.count);
  for (std::size_t k = 0; k < 3; ++k)
    for (std::size_t i = 0; i < points.count; ++i) {
      const double offset = static_cast<double>((*axes[k])[i]) - sums[k] / count;
      squares += offset * offset;
    }
  return std::sqrt(squares / count);
}

double mean_nearest_distance(const PairPoints& points, const CancelToken& cancel) {
  std::vector<double> nearest(points.count);
  parallel_blocks(points.count, centers_per_task, [&](std::size_t begin, std::size_t end) {
    cancel.check();
    for (std::size_t i = begin; i < end; ++i) {
      float least = std::numeric_limits<float>::max();
      for (std::size_t j = i + 1; j < i + points.count; ++j) {
        const float dx = points.x[j] - points.x[i], dy = points.y[j] - points.y[i],
                    dz = points.z[j] - points.z[i];
        least = std::min(least, (dx * dx + dy * dy) + dz * dz);
      }
      nearest[i] = std::sqrt(static_cast<double>(least));
    }
  });
  return blocked_sum(nearest) / static_cast<double>(points.count);
}

// Counts the pairs of point `center` with every other.
void count_around(const PairPoints& points, const PairNormals& normals, NormalSense sense,
                  const OrientedLoops& loops, const OrientedCounter& counter, std::size_t center) {
  const auto loop =
      sense == NormalSense::signed_normals ? &OrientedLoops::signed_normals : &OrientedLoops::either_side;
  for (std::size_t s = 1; s < points.count; s += pair_offsets)
    (loops.*loop)(normals.with(points.tile(center, center + 1, s, std::min(points.count, s + pair_offsets))),
                  counter);
}

// Takes the counts out of the table; those beyond the radius are dropped.
void take_roots(std::vector<std::uint32_t>& table, std::span<float> roots) {
  std::uint32_t counts[local_pair_bins] = {};
  std::uint64_t total = 0;
  for (std::size_t b = 0; b < local_pair_bins; ++b) {
    for (std::size_t copy = 0; copy < pair_copies; ++copy)
      counts[b] += table[copy * oriented_copy_stride + b];
    total += counts[b];
  }
  std::fill(table.begin(), table.end(), 0u);
  for (std::size_t b = 0; b < local_pair_bins; ++b)
    roots[b] =
        total == 0
            ? 0.0f
            : static_cast<float>(std::sqrt(static_cast<double>(counts[b]) / static_cast<double>(total)));
}

}  // namespace

std::vector<float> local_pair_histograms(std::span<const float> points, std::span<const float> normals,
                                         const LocalPairParameters& parameters, const CancelToken& cancel) {
  if (points.size() < 6 || points.size() % 3 != 0)
    throw std::invalid_argument("histograms of local pairs need at least two points of three coordinates");
  if (normals.size() != points.size())
    throw std::invalid_argument("histograms of local pairs need one normal per point");
  if (!(parameters.radius > 0)) throw std::invalid_argument("a radius that is not positive");
  require_available(parameters.instructions);
  check_finite(points, "a coordinate");
  check_finite(normals, "a normal");
  const PairPoints working(points);
  const PairNormals turned(normals);
  const double unit = parameters.unit == RadiusUnit::size ? root_mean_square_distance(working)
                                                          : mean_nearest_distance(working, cancel);
  const OrientedLoops& loops = oriented_loops(parameters.instructions);
  OrientedCounter counter =
      oriented_counter(parameters.sense, unit > 0 ? local_distance_bins / (parameters.radius * unit) : 0);
  const std::size_t centers = std::min<std::size_t>(parameters.centers, working.count);
  std::vector<float> roots(centers * local_pair_bins);
  parallel_tasks((centers + centers_per_task - 1) / centers_per_task, [&](std::size_t task) {
    cancel.check();
    std::vector<std::uint32_t> table(pair_copies * oriented_copy_stride);
    OrientedCounter own = counter;
    own.table.table = table.data();
    for (std::size_t i = task * centers_per_task; i < std::min(centers, (task + 1) * centers_per_task); ++i) {
      count_around(working, turned, parameters.sense, loops, own, i);
      take_roots(table, std::span(roots).subspan(i * local_pair_bins, local_pair_bins));
    }
  });
  return roots;
}

}  // namespace meander
