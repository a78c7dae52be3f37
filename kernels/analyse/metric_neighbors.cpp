#include "kernels/analyse/metric_neighbors.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "kernels/analyse/differential_domain.h"
#include "kernels/analyse/kd_tree.h"
#include "kernels/core/parallel.h"

namespace meander {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr std::size_t neighbor_block = 256;

// Infinite where the samples are not neighbors. Never below half the chord over s1 of either sample.
double metric_length(const PreparedTangentSamples& samples, std::uint32_t i, std::uint32_t j) {
  const TangentFrame &a = samples.frames[i], &b = samples.frames[j];
  if (dot(a.normal, b.normal) < neighbor_normal_cosine) return infinity;
  const auto v = geodesic_vector(samples.points[i], a, samples.points[j], b.normal);
  const auto w = geodesic_vector(samples.points[j], b, samples.points[i], a.normal);
  if (!v || !w) return infinity;
  return 0.5 * (std::hypot((*v)[0] / samples.s1[i], (*v)[1] / samples.s2[i]) +
                std::hypot((*w)[0] / samples.s1[j], (*w)[1] / samples.s2[j]));
}

// Calls visit(position in the tree) for all samples, in parallel.
template <class Visit>
void for_each_sample(const KdTree<3>& tree, const Visit& visit) {
  parallel_blocks(tree.count(), neighbor_block, [&](std::size_t begin, std::size_t end) {
    for (std::size_t p = begin; p < end; ++p) visit(p);
  });
}

}  // namespace

std::vector<double> metric_nearest_distances(const TangentSamples& samples) {
  const PreparedTangentSamples prepared = prepare_tangent_samples(samples);
  const KdTree<3> tree(samples.points);
  // No two samples are farther apart than the corners of their box.
  Vector3 low{infinity, infinity, infinity}, high{-infinity, -infinity, -infinity};
  for (const Vector3& p : prepared.points) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  const double diagonal = tree.count() > 0 ? distance(low, high) : 0;
  std::vector<double> result(tree.count(), infinity);
  for_each_sample(tree, [&](std::size_t position) {
    const std::uint32_t i = tree.index(position);
    double best = infinity;
    KdTree<3>::Nearest nearest;
    tree.nearest(tree.point(position), i, nearest);
    if (nearest.index != KdTree<3>::none) best = metric_length(prepared, i, nearest.index);
    // A ball of twice the best length times s1 holds every sample that is nearer. Where the nearest one is no
    // neighbor, balls grow until one holds a neighbor.
    double radius = std::isfinite(best) ? 2 * best * prepared.s1[i] : prepared.s1[i];
    for (;;) {
      radius *= 1 + 1e-12;
      tree.in_ball(tree.point(position), radius * radius, [&](std::uint32_t j, const auto&) {
        if (j != i) best = std::min(best, metric_length(prepared, i, j));
      });
      if (radius >= diagonal || 2 * best * prepared.s1[i] <= radius) break;
      radius = std::isfinite(best) ? 2 * best * prepared.s1[i] : 2 * radius;
    }
    result[i] = best;
  });
  return result;
}

std::vector<double> metric_neighbor_counts(const TangentSamples& samples, double radius) {
  if (!(radius > 0) || !std::isfinite(radius))
    throw std::invalid_argument("metric_neighbor_counts: the radius must be positive");
  const PreparedTangentSamples prepared = prepare_tangent_samples(samples);
  const KdTree<3> tree(samples.points);
  std::vector<double> result(tree.count(), 0.0);
  for_each_sample(tree, [&](std::size_t position) {
    const std::uint32_t i = tree.index(position);
    const double reach = 2 * radius * prepared.s1[i] * (1 + 1e-12);
    tree.in_ball(tree.point(position), reach * reach, [&](std::uint32_t j, const auto&) {
      if (j != i && metric_length(prepared, i, j) <= radius) result[i] += 1;
    });
  });
  return result;
}

BandComparison compare_band(std::span<const double> values, std::span<const std::uint8_t> in_band,
                            double shared) {
  if (values.size() != in_band.size())
    throw std::invalid_argument(
        "compare_band: one value and one flag a "
        "sample");
  if (!(shared >= 1) || !std::isfinite(shared)) throw std::invalid_argument("compare_band: shared >= 1");
  std::array<double, 2> count{}, mean{}, squares{};
  const auto visit = [&](const auto& add) {
    for (std::size_t i = 0; i < values.size(); ++i)
      if (std::isfinite(values[i])) add(std::size_t{in_band[i] != 0}, values[i]);
  };
  visit([&](std::size_t k, double v) {
    ++count[k];
    mean[k] += v;
  });
  for (std::size_t k = 0; k < 2; ++k) mean[k] = count[k] > 0 ? mean[k] / count[k] : 0;
  visit([&](std::size_t k, double v) { squares[k] += (v - mean[k]) * (v - mean[k]); });
  BandComparison result;
  result.outside = static_cast<std::uint64_t>(count[0]);
  result.in_band = static_cast<std::uint64_t>(count[1]);
  result.outside_mean = mean[0];
  result.band_mean = mean[1];
  result.ratio = result.standard_error = std::numeric_limits<double>::quiet_NaN();
  if (count[0] < 2 || count[1] < 2 || mean[0] == 0) return result;
  result.ratio = mean[1] / mean[0];
  const auto variance = [&](std::size_t k) { return shared * squares[k] / ((count[k] - 1) * count[k]); };
  result.standard_error =
      std::sqrt(variance(1) + result.ratio * result.ratio * variance(0)) / std::abs(mean[0]);
  return result;
}

std::vector<std::uint8_t> seam_band(std::span<const double> distances, double width) {
  std::vector<std::uint8_t> band(distances.size());
  for (std::size_t i = 0; i < distances.size(); ++i) band[i] = distances[i] <= width;
  return band;
}

}  // namespace meander
