#include "kernels/analyse/region_counts.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "kernels/core/random.h"
#include "support/catch.h"

using namespace meander;

namespace {

constexpr std::size_t triangles = 4000;
constexpr std::uint32_t regions = 60;

struct Scene {
  std::vector<std::uint32_t> region;
  std::vector<double> measure, cumulative;
};

// Regions are runs of triangles, of unequal measure.
Scene make_scene() {
  Scene scene;
  const RandomKey key = make_random_key(3, {});
  double sum = 0;
  for (std::size_t t = 0; t < triangles; ++t) {
    scene.region.push_back(static_cast<std::uint32_t>(t * t / triangles * regions / triangles));
    scene.measure.push_back(0.1 + random_pair(key, Stream::sequence, t).first);
    scene.cumulative.push_back(sum += scene.measure.back());
  }
  return scene;
}

// The triangles at the given places of the cumulative measure.
template <class Place>
std::vector<std::uint32_t> samples_at(const Scene& scene, std::size_t count, const Place& place) {
  std::vector<std::uint32_t> out;
  for (std::size_t i = 0; i < count; ++i) {
    const double at = place(i) * scene.cumulative.back();
    const auto found = std::upper_bound(scene.cumulative.begin(), scene.cumulative.end() - 1, at);
    out.push_back(static_cast<std::uint32_t>(found - scene.cumulative.begin()));
  }
  return out;
}

}  // namespace

TEST_CASE("region_counts: independent samples pass, and fail against a wrong measure") {
  const Scene scene = make_scene();
  double dispersion = 0;
  int small = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const RandomKey key = make_random_key(100 + seed, {});
    const auto samples =
        samples_at(scene, 3000, [&](std::size_t i) { return random_pair(key, Stream::sequence, i).first; });
    const RegionCounts counts = region_counts(scene.region, scene.measure, samples, regions);
    std::uint64_t total = 0;
    double expected = 0;
    for (std::uint32_t r = 0; r < regions; ++r) {
      total += counts.counts[r];
      expected += counts.expected[r];
    }
    CHECK(total == 3000);
    CHECK(expected == Approx(3000));
    CHECK(counts.test.cells > 50);
    CHECK(counts.worst < 5);
    dispersion += counts.dispersion / 20;
    small += counts.test.p_value < 0.01;
    std::vector<double> wrong = scene.measure;
    for (std::size_t t = 0; t < triangles / 2; ++t) wrong[t] *= 2;
    CHECK(region_counts(scene.region, wrong, samples, regions).test.p_value < 1e-4);
  }
  // 20 x 58 degrees or so: standard deviation sqrt(2 / 1160) = 0.04.
  CHECK(dispersion == Approx(1).margin(0.15));
  CHECK(small <= 2);
}

TEST_CASE("region_counts: stratified samples lie far below the chi-square bound") {
  const Scene scene = make_scene();
  const RandomKey key = make_random_key(9, {});
  const auto samples = samples_at(scene, 3000, [&](std::size_t i) {
    return (static_cast<double>(i) + random_pair(key, Stream::sequence, i).first) / 3000;
  });
  const RegionCounts counts = region_counts(scene.region, scene.measure, samples, regions);
  // A region is one run: it cuts at most two strata.
  CHECK(counts.dispersion < 0.05);
  CHECK(counts.test.p_value > 0.999);
  for (std::uint32_t r = 0; r < regions; ++r)
    CHECK(std::abs(static_cast<double>(counts.counts[r]) - counts.expected[r]) <= 2);
}

TEST_CASE("region_counts: small cases, and invalid arguments are refused") {
  const std::vector<std::uint32_t> region = {0, 1, 1}, samples = {0, 1, 2, 2};
  const std::vector<double> measure = {1, 0.5, 0.5};
  const RegionCounts counts = region_counts(region, measure, samples, 3, 1);
  CHECK(counts.counts == std::vector<std::uint64_t>{1, 3, 0});
  CHECK(counts.expected == std::vector<double>{2, 2, 0});
  CHECK(counts.worst == Approx(1 / std::sqrt(2.0)));
  CHECK(counts.test.statistic == Approx(1));
  CHECK(counts.dispersion == Approx(1));
  CHECK(std::isnan(region_counts(region, measure, samples, 3, 100).dispersion));
  CHECK(region_counts(region, measure, {}, 3).counts == std::vector<std::uint64_t>(3, 0));
  const std::vector<double> zero = {0, 0, 0}, negative = {1, -1, 1}, two = {1, 1};
  const std::vector<std::uint32_t> outside = {3};
  CHECK_THROWS_AS(region_counts(region, measure, samples, 1), std::invalid_argument);
  CHECK_THROWS_AS(region_counts(region, zero, samples, 3), std::invalid_argument);
  CHECK_THROWS_AS(region_counts(region, negative, samples, 3), std::invalid_argument);
  CHECK_THROWS_AS(region_counts(region, two, samples, 3), std::invalid_argument);
  CHECK_THROWS_AS(region_counts(region, measure, outside, 3), std::invalid_argument);
}
