#include "kernels/analyse/weighted_distance_histogram.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "kernels/box_points.h"
#include "support/catch.h"

using namespace meander;
using namespace meander::test;

TEST_CASE("weighted distance histograms count a point of weight two as two points") {
  const std::vector<float> points = box_points(150);
  const std::vector<double> exact(points.begin(), points.end());
  const DistanceHistogramParameters parameters{.bins = 32, .scale = HistogramScale::mean};
  const DistanceHistogram plain = distance_histogram(points, parameters);
  const DistanceHistogram ones =
      weighted_distance_histogram(exact, std::vector<double>(150, 3.0), parameters);
  CHECK(ones.scale == Approx(plain.scale).epsilon(1e-7));
  for (std::size_t b = 0; b < 32; ++b) CHECK(ones.shares[b] == Approx(plain.shares[b]).margin(2.1 / 11175));

  // Against the definition, weights of many sizes and zeros.
  std::vector<double> weights(150);
  for (std::size_t i = 0; i < 150; ++i) weights[i] = static_cast<double>(i % 7);
  for (const HistogramScale scale : {HistogramScale::largest, HistogramScale::mean}) {
    const DistanceHistogram weighted =
        weighted_distance_histogram(exact, weights, {.bins = 16, .scale = scale});
    double total = 0, mean = 0, largest = 0;
    for (std::size_t i = 0; i < 150; ++i)
      for (std::size_t j = i + 1; j < 150; ++j) {
        const double w = weights[i] * weights[j];
        total += w;
        mean += w * distance(points, i, j);
        if (w > 0) largest = std::max(largest, distance(points, i, j));
      }
    const double expected = scale == HistogramScale::mean ? mean / total : largest;
    CHECK(weighted.scale == Approx(expected));
    std::vector<double> shares(16);
    const double range = weighted.range;
    for (std::size_t i = 0; i < 150; ++i)
      for (std::size_t j = i + 1; j < 150; ++j)
        shares[static_cast<std::size_t>(std::min(distance(points, i, j) / range * 16, 15.5))] +=
            weights[i] * weights[j] / total;
    for (std::size_t b = 0; b < 16; ++b) CHECK(weighted.shares[b] == Approx(shares[b]).margin(1e-4));
  }
  CHECK_THROWS_AS(weighted_distance_histogram(exact, std::vector<double>(150, -1.0)), std::invalid_argument);
  CHECK_THROWS_AS(weighted_distance_histogram(exact, std::vector<double>(149, 1.0)), std::invalid_argument);
  CHECK_THROWS_AS(weighted_distance_histogram(exact, std::vector<double>(150, 0.0)), std::invalid_argument);
}
