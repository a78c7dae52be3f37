#include "kernels/analyse/weighted_distance_histogram.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "kernels/core/parallel.h"
#include "kernels/describe/pair_points.h"

namespace meander {

namespace {

constexpr std::size_t weighted_rows = 64;

struct WeightedPoints {
  std::vector<double> x, y, z, weight;

  WeightedPoints(std::span<const double> points, std::span<const double> weights) {
    for (std::size_t i = 0; i < weights.size(); ++i) {
      if (weights[i] == 0) continue;
      x.push_back(points[3 * i]);
      y.push_back(points[3 * i + 1]);
      z.push_back(points[3 * i + 2]);
      weight.push_back(weights[i]);
    }
  }
  std::size_t count() const { return x.size(); }
  double distance(std::size_t i, std::size_t j) const {
    const double dx = x[i] - x[j], dy = y[i] - y[j], dz = z[i] - z[j];
    return std::sqrt(dx * dx + dy * dy + dz * dz);
  }
};

// Returns one result per block of rows, to be added in order: make(), then add(result, i, j) for all j > i.
template <class Result, class Make, class Add>
std::vector<Result> weighted_blocks(std::size_t n, const Make& make, const Add& add) {
  std::vector<Result> results((n + weighted_rows - 1) / weighted_rows);
  parallel_tasks(results.size(), [&](std::size_t block) {
    Result result = make();
    for (std::size_t i = block * weighted_rows; i < std::min(n, (block + 1) * weighted_rows); ++i)
      for (std::size_t j = i + 1; j < n; ++j) add(result, i, j);
    results[block] = std::move(result);
  });
  return results;
}

}  // namespace

DistanceHistogram weighted_distance_histogram(std::span<const double> points, std::span<const double> weights,
                                              const DistanceHistogramParameters& parameters) {
  check_histogram_parameters(parameters);
  if (parameters.instructions != InstructionSet::automatic &&
      parameters.instructions != InstructionSet::scalar)
    throw std::invalid_argument("weighted distance histograms are scalar");
  if (points.size() != 3 * weights.size())
    throw std::invalid_argument("a weighted distance histogram needs three coordinates per weight");
  check_finite(points, "a coordinate");
  check_finite(weights, "a weight");
  for (const double weight : weights)
    if (weight < 0) throw std::invalid_argument("a weight that is negative");
  const WeightedPoints working(points, weights);
  const std::size_t n = working.count(), bins = parameters.bins;
  if (n < 2) throw std::invalid_argument("a distance histogram needs at least two points of positive weight");

  struct Totals {
    double largest = 0, weight = 0, weighted_distance = 0;
  };
  Totals totals;
  for (const Totals& part : weighted_blocks<Totals>(
           n, [] { return Totals(); },
           [&](Totals&result, std::size_t i, std::size_t j) {
             const double distance = working.distance(i, j), weight = working.weight[i] * working.weight[j];
             result.largest = std::max(result.largest, distance);
             result.weight += weight;
             result.weighted_distance += weight * distance;
           })) {
    totals.largest = std::max(totals.largest, part.largest);
    totals.weight += part.weight;
    totals.weighted_distance += part.weighted_distance;
  }
  if (!(totals.weight > 0) || !std::isfinite(totals.weight) || !std::isfinite(totals.weighted_distance))
    throw std::invalid_argument("weights or coordinates whose products leave the range of double");

  DistanceHistogram histogram;
  const bool by_mean = parameters.scale == HistogramScale::mean;
  histogram.pairs = std::uint64_t{n} * (n - 1) / 2;
  histogram.scale = by_mean ? totals.weighted_distance / totals.weight : totals.largest;
  histogram.range =
      parameters.range > 0 ? parameters.range : (by_mean ? histogram_range_per_mean : 1) * histogram.scale;
  const double top = static_cast<double>(bins) - 0.5;
  const double factor =
      histogram.range > 0 ? std::min(1e300, static_cast<double>(bins) / histogram.range) : 0;
  histogram.shares.resize(bins);
  for (const auto& part : weighted_blocks<std::vector<double>>(
           n, [&] { return std::vector<double>(bins); },
           [&](std::vector<double>&result, std::size_t i, std::size_t j) {
             const auto bin = static_cast<std::size_t>(std::min(working.distance(i, j) * factor, top));
             result[bin] += working.weight[i] * working.weight[j];
           }))
    for (std::size_t b = 0; b < bins; ++b) histogram.shares[b] += part[b];
  for (double& share : histogram.shares) share /= totals.weight;
  return histogram;
}

}  // namespace meander
