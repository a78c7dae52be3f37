#include "kernels/describe/distance_histogram.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "kernels/box_points.h"
#include "kernels/core/random.h"
#include "support/catch.h"
#include "support/threads.h"

using namespace meander;
using namespace meander::test;

namespace {

std::vector<float> sphere_surface(std::size_t n, double radius) {
  const RandomKey key = make_random_key(5, {});
  std::vector<float> points;
  for (std::size_t i = 0; i < n; ++i) {
    const UnitPair u = random_pair(key, Stream::point_set, i);
    const double z = 2 * u.first - 1, s = std::sqrt(1 - z * z), turn = 2 * std::numbers::pi * u.second;
    points.push_back(static_cast<float>(radius * s * std::cos(turn)));
    points.push_back(static_cast<float>(radius * s * std::sin(turn)));
    points.push_back(static_cast<float>(radius * z));
  }
  return points;
}

std::vector<double> all_distances(const std::vector<float>& p) {
  std::vector<double> distances;
  for (std::size_t i = 0; i < p.size() / 3; ++i)
    for (std::size_t j = i + 1; j < p.size() / 3; ++j) distances.push_back(distance(p, i, j));
  return distances;
}

// Pairs by which the two histograms can differ at most: distances within `slack` of an edge.
void check_against_reference(const std::vector<float>& points,
                             const DistanceHistogramParameters& parameters) {
  const std::vector<double> distances = all_distances(points);
  const DistanceHistogram histogram = distance_histogram(points, parameters);
  double largest = 0, mean = 0;
  for (const double d : distances) {
    largest = std::max(largest, d);
    mean += d / static_cast<double>(distances.size());
  }
  const bool by_mean = parameters.scale == HistogramScale::mean;
  CHECK(histogram.scale == Approx(by_mean ? mean : largest).epsilon(1e-7));
  const double range = parameters.range > 0 ? parameters.range : by_mean ? 3 * mean : largest;
  CHECK(histogram.range == Approx(range).epsilon(1e-7));
  REQUIRE(histogram.counts.size() == parameters.bins);
  std::vector<double> least(parameters.bins), most(parameters.bins);
  for (const double d : distances) {
    const double at = d / range * parameters.bins, top = parameters.bins - 0.5;
    const auto low = static_cast<std::size_t>(std::min(at * (1 - 4e-7), top));
    const auto high = static_cast<std::size_t>(std::min(at * (1 + 4e-7), top));
    ++most[low];
    if (low == high)
      ++least[low];
    else
      ++most[high];
  }
  std::uint64_t all = 0;
  double share = 0;
  bool within = true;
  for (std::size_t b = 0; b < parameters.bins; ++b) {
    const auto count = static_cast<double>(histogram.counts[b]);
    within = within && least[b] <= count && count <= most[b];
    all += histogram.counts[b];
    share += histogram.shares[b];
  }
  CHECK(within);
  CHECK(all == distances.size());
  CHECK(histogram.pairs == distances.size());
  CHECK(share == Approx(1));
}

std::vector<InstructionSet> available_sets() {
  std::vector<InstructionSet> sets;
  for (const InstructionSet set : {InstructionSet::scalar, InstructionSet::avx2, InstructionSet::avx512})
    if (is_available(set)) sets.push_back(set);
  return sets;
}

bool same(const DistanceHistogram& a, const DistanceHistogram& b) {
  return a.counts == b.counts && a.shares == b.shares && a.scale == b.scale && a.range == b.range;
}

}  // namespace

TEST_CASE("distance histogram: agrees with a double loop over all pairs") {
  for (const std::size_t n : {2, 3, 5, 33, 34, 400, 1101})
    for (const HistogramScale scale : {HistogramScale::largest, HistogramScale::mean})
      for (const std::uint32_t bins : {8u, 32u, 47u, 64u, 65u, 1024u}) {
        if (n > 400 && bins != 32 && bins != 65) continue;
        INFO(n << " points, " << bins << " bins, scale " << static_cast<int>(scale));
        check_against_reference(box_points(n), {.bins = bins, .scale = scale});
      }
  check_against_reference(box_points(300), {.range = 0.5});
  check_against_reference(box_points(300), {.bins = 100, .range = 7});
}

TEST_CASE("distance histogram: the same for every instruction set and number of threads") {
  for (const std::size_t n : {2, 17, 64, 1023, 1500, 3000})
    for (const HistogramScale scale : {HistogramScale::largest, HistogramScale::mean})
      for (const std::uint32_t bins : {32u, 64u, 256u}) {
        const std::vector<float> points = n == 1023 ? sphere_surface(n, 3) : box_points(n);
        DistanceHistogramParameters parameters{
            .bins = bins, .scale = scale, .instructions = InstructionSet::scalar};
        const DistanceHistogram reference = distance_histogram(points, parameters);
        for (const InstructionSet set : available_sets()) {
          INFO(n << " points, " << bins << " bins, " << name_of(set));
          parameters.instructions = set;
          CHECK(same(distance_histogram(points, parameters), reference));
          if (n < 3000) continue;
          for (const std::size_t threads : {1u, 4u})
            CHECK(same(test::on_threads(threads, [&] { return distance_histogram(points, parameters); }),
                       reference));
        }
      }
}

TEST_CASE("distance histogram: invariant to order, position and size") {
  const std::vector<float> points = box_points(701);
  for (const HistogramScale scale : {HistogramScale::largest, HistogramScale::mean}) {
    const DistanceHistogramParameters parameters{.bins = 64, .scale = scale};
    const DistanceHistogram reference = distance_histogram(points, parameters);
    std::vector<float> changed;
    for (std::size_t i = 0; i < 701; ++i)
      for (std::size_t k = 0; k < 3; ++k) changed.push_back(points[3 * (i * 300 % 701) + k]);
    CHECK(same(distance_histogram(changed, parameters), reference));

    // Powers of two up to the ends of float32 scale exactly; the coordinates of a quarter turn only change
    // place.
    for (const int exponent : {100, -100}) {
      changed.clear();
      for (std::size_t i = 0; i < 701; ++i)
        for (const std::size_t k : {1, 0, 2})
          changed.push_back(std::ldexp(k == 1 ? -points[3 * i + k] : points[3 * i + k], exponent));
      const DistanceHistogram large = distance_histogram(changed, parameters);
      CHECK(large.scale == Approx(std::ldexp(reference.scale, exponent)));
      std::uint64_t moved = 0;  // the order of the sum of squares changed: pairs at the edges may move
      for (std::size_t b = 0; b < 64; ++b)
        moved +=
            std::max(large.counts[b], reference.counts[b]) - std::min(large.counts[b], reference.counts[b]);
      CHECK(moved <= 4);
    }
    changed = points;
    for (std::size_t i = 0; i < changed.size(); ++i) changed[i] += 1000;
    const DistanceHistogram far = distance_histogram(changed, parameters);
    double difference = 0;
    for (std::size_t b = 0; b < 64; ++b) difference += std::abs(far.shares[b] - reference.shares[b]);
    CHECK(difference < 0.01);  // of the rounding to 6e-5 in the input
  }
}

TEST_CASE("distance histogram: distances on a sphere have linear density") {
  const std::size_t n = 3000;
  const double radius = 2.5;
  const DistanceHistogram histogram =
      distance_histogram(sphere_surface(n, radius), {.bins = 16, .range = 2 * radius});
  // p(d) = d / (2 R^2): the share up to d is d^2 / (4 R^2).
  for (std::size_t b = 0; b < 16; ++b)
    CHECK(histogram.shares[b] == Approx((2.0 * static_cast<double>(b) + 1) / 256).margin(0.002));
  CHECK(distance_histogram(sphere_surface(n, radius), {.scale = HistogramScale::mean}).scale ==
        Approx(4 * radius / 3).epsilon(0.01));
}

TEST_CASE("distance histogram: coincident points are counted, invalid arguments refused") {
  const std::vector<float> spot(30, 4.0f);
  const DistanceHistogram histogram = distance_histogram(spot);
  CHECK(histogram.scale == 0);
  CHECK(histogram.counts[0] == 45);
  CHECK(distance_histogram(spot, {.scale = HistogramScale::mean}).shares[0] == 1);
  const std::vector<float> points = box_points(10);
  CHECK_THROWS_AS(distance_histogram(std::vector<float>(3)), std::invalid_argument);
  CHECK_THROWS_AS(distance_histogram(points, {.bins = 7}), std::invalid_argument);
  CHECK_THROWS_AS(distance_histogram(points, {.bins = 1025}), std::invalid_argument);
  CHECK_THROWS_AS(distance_histogram(points, {.range = -1}), std::invalid_argument);
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    std::vector<float> broken = points;
    broken[7] = bad;
    CHECK_THROWS_AS(distance_histogram(broken), std::invalid_argument);
  }
}
