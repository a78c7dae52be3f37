#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "kernels/analyse/discrepancy_anisotropic.h"
#include "kernels/analyse/point_index.h"
#include "kernels/analyse/slope_fit.h"
#include "support/catch.h"
#include "tests/support/metric_samples.h"

using namespace meander;
using namespace meander::test;

namespace {

AnisotropicDiscrepancyParameters with_shapes(std::uint32_t shapes, std::uint32_t windows) {
  AnisotropicDiscrepancyParameters parameters;
  parameters.shapes.shapes = shapes;
  parameters.shapes.stable_rise = 0;
  parameters.windows = windows;
  return parameters;
}

struct Rate {
  std::array<double, 3> slope{}, constant{};  // disks, boxes, triangles; constant: mean of D n^exponent
};

// Numbers of points in the window are about those of ratio 1, so that the curves lie over one another.
template <class Samples>
Rate rate_of(TangentTensor tensor, double ratio, double most, double exponent, int runs,
             const Samples& samples) {
  std::vector<double> points;
  std::array<std::vector<double>, 3> errors;
  for (double n = 64; n < 1.01 * most; n *= 4) {
    std::array<double, 4> mean{};
    for (int run = 0; run < runs; ++run) {
      const PlanarSamples set = samples(n * ratio, static_cast<std::uint64_t>(run));
      const AnisotropicDiscrepancy d = anisotropic_discrepancy(set.x, set.y, tensor, with_shapes(512, 4));
      const std::array<double, 4> values = {d.disks, d.boxes, d.triangles, d.points};
      for (std::size_t k = 0; k < 4; ++k) mean[k] += values[k] / runs;
    }
    points.push_back(mean[3]);
    for (std::size_t k = 0; k < 3; ++k) errors[k].push_back(mean[k]);
  }
  Rate rate;
  for (std::size_t k = 0; k < 3; ++k) {
    rate.slope[k] = fit_slope(points, errors[k]).slope;
    for (std::size_t i = 0; i < points.size(); ++i)
      rate.constant[k] += errors[k][i] * std::pow(points[i], exponent) / static_cast<double>(points.size());
  }
  return rate;
}

}  // namespace

TEST_CASE("count_in_disk: equals a loop over the points") {
  const PlanarSamples set = random_samples(5000, 3);
  const PointIndex<2> index = build_point_index(set.x, set.y);
  const RandomKey key = make_random_key(4, {});
  std::size_t sum = 0;
  for (std::uint64_t k = 0; k < 300; ++k) {
    const UnitPair c = random_pair(key, Stream::test_shapes, k);
    // Some through a point, exactly.
    double radius = 0.7 * random_pair(key, Stream::test_shapes, k, 1).first;
    if (k % 3 == 0) radius = std::hypot(set.x[k] - c.first, set.y[k] - c.second);
    std::size_t expected = 0;
    for (std::size_t i = 0; i < set.x.size(); ++i) {
      const double dx = set.x[i] - c.first, dy = set.y[i] - c.second;
      expected += dx * dx + dy * dy <= radius * radius;
    }
    CHECK(count_in_disk(index, {c.first, c.second}, radius) == expected);
    sum += expected;
  }
  CHECK(sum > 10000);
  CHECK(count_in_disk(build_point_index({}, {}), {0.5, 0.5}, 1) == 0);
}

TEST_CASE("anisotropic_discrepancy: an affine image under its tensor is the isotropic case") {
  const PlanarSamples set = jittered_samples(2000, {}, 0.4, 5);
  for (const std::uint32_t windows : {1u, 3u}) {
    AnisotropicDiscrepancyParameters parameters = with_shapes(600, windows);
    const AnisotropicDiscrepancy plain = anisotropic_discrepancy(set.x, set.y, {}, parameters);
    CHECK(plain.window_share == Approx(std::numbers::pi / 4));
    CHECK(plain.points == Approx(set.x.size() * std::numbers::pi / 4).epsilon(0.02));
    CHECK(plain.windows == 1);  // it touches all sides
    for (const double ratio : {2.0, 8.0}) {
      const TangentTensor log_s = log_spacing(ratio, 0.7), s = exponential(log_s);
      PlanarSamples image = set;
      for (std::size_t i = 0; i < set.x.size(); ++i) {
        image.x[i] = 3 + s.xx * set.x[i] + s.xy * set.y[i];
        image.y[i] = -5 + s.xy * set.x[i] + s.yy * set.y[i];
      }
      parameters.domain = {{3, -5}, {s.xx, s.xy}, {s.xy, s.yy}};
      // The scale of the tensor does not matter.
      const AnisotropicDiscrepancy seen =
          anisotropic_discrepancy(image.x, image.y, log_s + TangentTensor{1.5, 0, 1.5}, parameters);
      CHECK(seen.points == plain.points);
      CHECK(seen.window_share == Approx(plain.window_share));
      CHECK(seen.disks == Approx(plain.disks).epsilon(1e-9));
      CHECK(seen.boxes == Approx(plain.boxes).epsilon(1e-9));
      CHECK(seen.triangles == Approx(plain.triangles).epsilon(1e-9));
    }
  }
}

TEST_CASE("anisotropic_discrepancy: windows fill the square as far as an ellipse can") {
  const PlanarSamples set = random_samples(20000, 8);
  for (const double ratio : {1.0, 3.0, 8.0}) {
    const AnisotropicDiscrepancy along =
        anisotropic_discrepancy(set.x, set.y, log_spacing(ratio, 0), with_shapes(64, 8));
    CHECK(along.window_share == Approx(std::numbers::pi / 4 / ratio));
    // On the diagonal the half-extents are sqrt((s1^2 + s2^2) / 2).
    const AnisotropicDiscrepancy diagonal =
        anisotropic_discrepancy(set.x, set.y, log_spacing(ratio, std::numbers::pi / 4), with_shapes(64, 8));
    CHECK(diagonal.window_share == Approx(std::numbers::pi / 2 / (ratio + 1 / ratio)));
    // Were a window partly outside, it would lack points.
    const double expected = 20000 * diagonal.window_share;
    CHECK(diagonal.points == Approx(expected).margin(4 * std::sqrt(expected / 8)));
  }
}

TEST_CASE("anisotropic_discrepancy: a shape that all points crowd into is found") {
  PlanarSamples set = random_samples(1000, 8);
  for (double& x : set.x) x = 0.4 + 0.2 * x;  // a strip of the square
  const AnisotropicDiscrepancy d = anisotropic_discrepancy(set.x, set.y, {}, with_shapes(2000, 1));
  CHECK(d.boxes > 0.5);
  CHECK(d.disks > 0.25);
}

TEST_CASE("anisotropic_discrepancy: random points have one rate and constant", "[statistics]") {
  Rate isotropic;
  for (const double ratio : {1.0, 4.0}) {
    const TangentTensor tensor = log_spacing(ratio, 0.6);
    const Rate rate = rate_of(tensor, ratio, 4096, 0.5, 6, [](double n, std::uint64_t run) {
      return random_samples(static_cast<std::size_t>(n), 7 + run);
    });
    if (ratio == 1) isotropic = rate;
    for (std::size_t k = 0; k < 3; ++k) {
      INFO("ratio " << ratio << " kind " << k);
      CHECK(rate.slope[k] == Approx(-0.5).margin(0.12));
      CHECK(rate.constant[k] == Approx(isotropic.constant[k]).epsilon(0.25));
    }
  }
}

TEST_CASE("anisotropic_discrepancy: one rate and constant for every ratio", "[slow]") {
  Rate random, strata;
  for (const double ratio : {1.0, 2.0, 4.0, 8.0}) {
    const TangentTensor tensor = log_spacing(ratio, 0.6);
    const Rate of_random = rate_of(tensor, ratio, 4096, 0.5, 24, [](double n, std::uint64_t run) {
      return random_samples(static_cast<std::size_t>(n), 7 + run);
    });
    const Rate of_strata = rate_of(tensor, ratio, 16384, 0.72, 12, [&](double n, std::uint64_t run) {
      return jittered_samples(n, tensor, 0.3 + static_cast<double>(run), 7 + run);
    });
    if (ratio == 1) {
      random = of_random;
      strata = of_strata;
    }
    // Strata of another metric are worse, which the constant shows.
    const Rate wrong = rate_of(tensor, ratio, 4096, 0.72, 6, [&](double n, std::uint64_t run) {
      return jittered_samples(n, log_spacing(ratio, 0.6 + std::numbers::pi / 2), 0.3, 7 + run);
    });
    for (std::size_t k = 0; k < 3; ++k) {
      INFO("ratio " << ratio << " kind " << k);
      CHECK(of_random.slope[k] == Approx(-0.5).margin(0.05));
      CHECK(of_random.constant[k] == Approx(random.constant[k]).epsilon(0.12));
      CHECK(of_strata.slope[k] == Approx(-0.72).margin(0.05));
      CHECK(of_strata.constant[k] == Approx(strata.constant[k]).epsilon(0.1));
      if (ratio > 2) CHECK(wrong.constant[k] > 1.3 * strata.constant[k]);
    }
  }
}

TEST_CASE("anisotropic_discrepancy: invalid arguments are refused") {
  const std::vector<double> one = {0.5}, two = {0.1, 0.2};
  const double nan = std::numeric_limits<double>::quiet_NaN();
  AnisotropicDiscrepancyParameters parameters = with_shapes(16, 1);
  CHECK_THROWS_AS(anisotropic_discrepancy({}, {}, {}, parameters), std::invalid_argument);
  CHECK_THROWS_AS(anisotropic_discrepancy(one, two, {}, parameters), std::invalid_argument);
  CHECK_THROWS_AS(anisotropic_discrepancy(one, std::vector<double>{nan}, {}, parameters),
                  std::invalid_argument);
  CHECK_THROWS_AS(anisotropic_discrepancy(one, one, {nan, 0, 0}, parameters), std::invalid_argument);
  CHECK_THROWS_AS(anisotropic_discrepancy(one, one, {900, 0, -900}, parameters), std::invalid_argument);
  parameters.windows = 0;
  CHECK_THROWS_AS(anisotropic_discrepancy(one, one, {}, parameters), std::invalid_argument);
  parameters.windows = 1;
  parameters.domain.b = {2, 0};
  CHECK_THROWS_AS(anisotropic_discrepancy(one, one, {}, parameters), std::invalid_argument);
  // No point in the window: nothing measured.
  parameters = with_shapes(16, 1);
  const std::vector<double> corner = {0.001};
  CHECK(anisotropic_discrepancy(corner, corner, {}, parameters).windows == 0);
}
