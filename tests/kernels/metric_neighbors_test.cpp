#include "kernels/analyse/metric_neighbors.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "kernels/analyse/differential_domain.h"
#include "support/catch.h"
#include "tests/support/metric_samples.h"
#include "tests/support/tangent_arrays.h"

using namespace meander;
using namespace meander::test;

namespace {

using std::numbers::pi;

// Random points of the unit sphere in a field of ratios 1 .. most.
TangentArrays random_sphere(std::size_t count, double most, std::uint64_t seed) {
  const PlanarSamples u = random_samples(count, seed);
  const double s = sample_spacing_scale(4 * pi, count);
  TangentArrays sphere;
  for (std::size_t i = 0; i < count; ++i) {
    const double z = 2 * u.x[i] - 1, r = std::sqrt(1 - z * z), a = 2 * pi * u.y[i];
    const Vector3 p = {r * std::cos(a), r * std::sin(a), z};
    const double half = 0.5 * std::log(1 + (most - 1) * (1 - p.x * p.x));
    sphere.add(p, p, Vector3{1, 0, 0} - p.x * p, s * std::exp(half), s * std::exp(-half));
  }
  return sphere;
}

// Jittered in the metric of a constant tensor, in the unit square.
TangentArrays stratified_square(double count, double ratio, std::uint64_t seed) {
  const TangentTensor log_s = log_spacing(ratio, 0.5);
  const PlanarSamples set = jittered_samples(count, log_s, 0.3, seed);
  const TensorAxes axes = spacings_of(log_s);
  const double scale = 1 / std::sqrt(count);
  TangentArrays square;
  for (std::size_t i = 0; i < set.x.size(); ++i)
    square.add({set.x[i], set.y[i], 0}, {0, 0, 1}, {axes.x, axes.y, 0}, scale * axes.first,
               scale * axes.second);
  return square;
}

// The definition, with arrays of its own.
double slow_length(const TangentArrays& s, std::size_t i, std::size_t j) {
  const auto at = [](const std::vector<double>& a, std::size_t k) {
    return Vector3{a[3 * k], a[3 * k + 1], a[3 * k + 2]};
  };
  const auto unit = [](Vector3 v) { return (1 / norm(v)) * v; };
  const Vector3 p = at(s.points, i), q = at(s.points, j);
  const Vector3 n = unit(at(s.normals, i)), m = unit(at(s.normals, j));
  if (dot(n, m) < 0.2) return std::numeric_limits<double>::infinity();
  const double length = geodesic_length(p, n, q, m);
  const auto in_spacings = [&](Vector3 d, Vector3 normal, Vector3 axis, double s1, double s2) {
    d = unit(d - dot(d, normal) * normal);
    const Vector3 e1 = unit(axis - dot(axis, normal) * normal);
    const double c = dot(d, e1);
    return length * std::sqrt(c * c / (s1 * s1) + (1 - c * c) / (s2 * s2));
  };
  return 0.5 * (in_spacings(q - p, n, at(s.axes, i), s.s1[i], s.s2[i]) +
                in_spacings(p - q, m, at(s.axes, j), s.s1[j], s.s2[j]));
}

double mean(const std::vector<double>& values) {
  double sum = 0;
  for (const double v : values) sum += v;
  return sum / static_cast<double>(values.size());
}

}  // namespace

TEST_CASE("metric neighbors: equal a comparison of all pairs") {
  TangentArrays surface = random_sphere(250, 8, 4);
  // Samples of a second sheet right beside the first ones: no neighbors.
  for (std::size_t i = 0; i < 20; ++i) {
    const Vector3 p = {surface.points[3 * i], surface.points[3 * i + 1], surface.points[3 * i + 2]};
    surface.add(1.001 * p, -1.0 * p, {1, 0.3, 0.2}, 0.3, 0.1);
  }
  const std::size_t count = surface.s1.size();
  const std::vector<double> nearest = metric_nearest_distances(surface.view());
  const std::vector<double> counts = metric_neighbor_counts(surface.view(), 1.2);
  for (std::size_t i = 0; i < count; ++i) {
    double best = std::numeric_limits<double>::infinity(), within = 0;
    for (std::size_t j = 0; j < count; ++j) {
      if (j == i) continue;
      const double length = slow_length(surface, i, j);
      best = std::min(best, length);
      within += length <= 1.2;
    }
    CHECK(nearest[i] == Approx(best).epsilon(1e-6));
    CHECK(counts[i] == within);
  }
}

TEST_CASE("metric neighbors: random samples of any ratio have the distances of the plane") {
  constexpr std::size_t n = 4000;
  for (const double most : {1.0, 4.0}) {
    const TangentArrays sphere = random_sphere(n, most, 9);
    const std::vector<double> nearest = metric_nearest_distances(sphere.view());
    // Mean 1/2, variance 1/pi - 1/4 a sample; neighbors share.
    CHECK(mean(nearest) == Approx(0.5).margin(5 * 0.261 * std::sqrt(2.0 / n)));
    const double radius = 1.5;
    const double expected = pi * radius * radius;
    CHECK(mean(metric_neighbor_counts(sphere.view(), radius)) ==
          Approx(expected).epsilon(0.02).margin(5 * std::sqrt(2 * expected / n)));
  }
}

TEST_CASE("metric neighbors: stratified samples keep their distance whatever the ratio") {
  const double isotropic = mean(metric_nearest_distances(stratified_square(2500, 1, 3).view()));
  CHECK(isotropic > 0.56);
  for (const double ratio : {2.0, 4.0, 8.0}) {
    const TangentArrays square = stratified_square(2500, ratio, 3);
    // At the border samples lack neighbors, a little more so with long strata.
    CHECK(mean(metric_nearest_distances(square.view())) == Approx(isotropic).epsilon(0.05));
    CHECK(mean(metric_neighbor_counts(square.view(), 1)) < 0.9 * pi);
  }
}

TEST_CASE("compare_band: the stated error of the ratio holds if band and rest are alike") {
  double nearest_squares = 0, count_squares = 0;
  constexpr int repeats = 40;
  for (std::uint64_t seed = 0; seed < repeats; ++seed) {
    const TangentArrays sphere = random_sphere(600, 2, 50 + seed);
    std::vector<double> height;
    for (std::size_t i = 0; i < 600; ++i) height.push_back(std::abs(sphere.points[3 * i + 2]));
    const std::vector<std::uint8_t> band = seam_band(height, 0.25);
    const BandComparison nearest = compare_band(metric_nearest_distances(sphere.view()), band);
    CHECK(nearest.in_band + nearest.outside == 600);
    CHECK(nearest.in_band == Approx(150).margin(50));
    nearest_squares += std::pow((nearest.ratio - 1) / nearest.standard_error, 2) / repeats;
    const BandComparison counts = compare_band(metric_neighbor_counts(sphere.view(), 1), band, 2 + pi);
    count_squares += std::pow((counts.ratio - 1) / counts.standard_error, 2) / repeats;
  }
  // Mean of 40 squares of about unit variance: 1 +- 0.22; distances share less than is allowed for.
  CHECK(nearest_squares > 0.3);
  CHECK(nearest_squares < 1.6);
  CHECK(count_squares > 0.45);
  CHECK(count_squares < 1.9);
}

TEST_CASE("compare_band: a band that was sampled at random is detected") {
  const double count = 4096;
  TangentArrays square = stratified_square(count, 4, 3);
  const PlanarSamples noise = random_samples(square.s1.size(), 8);
  std::vector<double> distances;
  for (std::size_t i = 0; i < square.s1.size(); ++i) {
    distances.push_back(std::abs(square.points[3 * i] - 0.5));
    // The strip about x = 0.5 is filled anew.
    if (distances[i] <= 0.1) {
      square.points[3 * i] = 0.4 + 0.2 * noise.x[i];
      square.points[3 * i + 1] = noise.y[i];
      distances[i] = std::abs(square.points[3 * i] - 0.5);
    }
  }
  const std::vector<std::uint8_t> band = seam_band(distances, 0.1);
  const BandComparison nearest = compare_band(metric_nearest_distances(square.view()), band);
  CHECK(nearest.ratio < 0.92);
  CHECK(nearest.ratio + 4 * nearest.standard_error < 1);
  CHECK(nearest.band_mean == Approx(0.5).margin(0.04));
  const BandComparison pairs = compare_band(metric_neighbor_counts(square.view(), 0.4), band);
  CHECK(pairs.ratio - 4 * pairs.standard_error > 1);
}

TEST_CASE("metric neighbors: small cases, and invalid arguments are refused") {
  TangentArrays two;
  two.add({0, 0, 0}, {0, 0, 1}, {1, 0, 0}, 0.5, 0.1);
  CHECK(metric_nearest_distances(two.view())[0] == std::numeric_limits<double>::infinity());
  two.add({0.2, 0, 0}, {0, 0, 1}, {0, 1, 0}, 0.5, 0.1);
  // 0.2 / 0.5 from the one, 0.2 / 0.1 from the other.
  CHECK(metric_nearest_distances(two.view())[0] == Approx(1.2));
  CHECK(metric_neighbor_counts(two.view(), 1.21) == std::vector<double>{1, 1});
  CHECK(metric_neighbor_counts(two.view(), 1.19) == std::vector<double>{0, 0});
  two.points[3] = 0;  // repeated points
  CHECK(metric_nearest_distances(two.view())[1] == 0);
  two.normals[5] = -1;
  CHECK(metric_nearest_distances(two.view())[1] == std::numeric_limits<double>::infinity());
  CHECK(metric_nearest_distances(TangentArrays{}.view()).empty());
  CHECK_THROWS_AS(metric_neighbor_counts(two.view(), 0), std::invalid_argument);
  two.s1.pop_back();
  CHECK_THROWS_AS(metric_nearest_distances(two.view()), std::invalid_argument);

  const double infinity = std::numeric_limits<double>::infinity();
  const std::vector<double> values = {1, 3, 2, 4, infinity, 6};
  const std::vector<std::uint8_t> band = {1, 1, 0, 0, 0, 0};
  const BandComparison b = compare_band(values, band, 1);
  CHECK(b.in_band == 2);
  CHECK(b.outside == 3);
  CHECK(b.ratio == Approx(0.5));
  // Variances of the means: 2 / 2 = 1 and 4 / 3.
  CHECK(b.standard_error == Approx(std::sqrt(1 + 0.25 * 4 / 3) / 4));
  CHECK(std::isnan(compare_band(values, std::vector<std::uint8_t>(6, 0)).ratio));
  CHECK_THROWS_AS(compare_band(values, std::vector<std::uint8_t>(5, 0)), std::invalid_argument);
  CHECK_THROWS_AS(compare_band(values, band, 0.5), std::invalid_argument);
}
