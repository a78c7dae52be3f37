#include "kernels/analyse/integration_error.h"

#include <cmath>
#include <stdexcept>
#include <string>

#include "kernels/core/random.h"
#include "support/catch.h"

using namespace meander;

namespace {

// Midpoint rule on a fine grid: mean and variance of f under the density.
struct Moments {
  double mean = 0, variance = 0, measure = 0;
};
Moments midpoint_moments(const Integrand& f, int side) {
  double sum = 0, squares = 0, weights = 0;
  for (int i = 0; i < side; ++i)
    for (int j = 0; j < side; ++j) {
      const double x = (i + 0.5) / side, y = (j + 0.5) / side, w = f.density(x, y), v = f.value(x, y);
      sum += w * v;
      squares += w * v * v;
      weights += w;
    }
  const double mean = sum / weights;
  return {mean, squares / weights - mean * mean, weights / (static_cast<double>(side) * side)};
}

}  // namespace

TEST_CASE("standard_integrands: closed forms agree with fine quadrature") {
  CHECK(standard_integrands().size() == 5);
  for (const Integrand& f : standard_integrands()) {
    CAPTURE(std::string(f.name));
    const Moments moments = midpoint_moments(f, 1000);
    // Smooth ones err by a few 1e-6, indicators by the share of cells on the border x a small factor.
    const double tolerance = f.name == "disc" || f.name == "half-plane" ? 1e-4 : 1e-5;
    CHECK(moments.mean == Approx(f.mean).epsilon(tolerance));
    CHECK(moments.variance == Approx(f.variance).epsilon(tolerance));
    CHECK(moments.measure == Approx(f.density_integral).epsilon(tolerance));
  }
}

TEST_CASE("integration_error: random points err by sqrt(variance / n)") {
  for (const Integrand& f : standard_integrands()) {
    CAPTURE(std::string(f.name));
    constexpr std::size_t n = 500, sets = 200;
    double squares = 0, weighted_squares = 0, weighted_variance = 0;
    std::vector<double> values(n), density(n);
    for (std::size_t s = 0; s < sets; ++s) {
      const RandomKey key = make_random_key(s, {});
      for (std::size_t i = 0; i < n; ++i) {
        UnitPair u = random_pair(key, Stream::sequence, i);
        if (f.density_integral < 1) u = {std::cbrt(u.first), std::cbrt(u.second)};  // x^2 y^2 by inversion
        values[i] = f.value(u.first, u.second);
        density[i] = f.density(u.first, u.second);
      }
      const double error = integration_error(values, f.mean);
      squares += error * error / sets;
      // The integral of f phi itself by the weights: values f phi.
      for (std::size_t i = 0; i < n; ++i) values[i] *= density[i];
      const double weighted =
          weighted_integration_error(values, density, f.density_integral, f.density_integral * f.mean);
      weighted_squares += weighted * weighted / sets;
      weighted_variance = f.density_integral * f.density_integral * f.variance;
    }
    // The mean of 200 squared errors has a relative deviation of sqrt(2 / 200) = 0.1.
    CHECK(squares * n == Approx(f.variance).epsilon(0.35));
    CHECK(weighted_squares * n == Approx(weighted_variance).epsilon(0.35));
  }
}

TEST_CASE("weighted_integration_error: 1 integrates to the area of the domain") {
  // Samples of density 2 x on [0, 1] (times anything in y): x = sqrt(u).
  std::vector<double> values, density;
  constexpr int n = 4000;
  for (int i = 0; i < n; ++i) {
    const double x = std::sqrt((i + 0.5) / n);
    values.push_back(x * x);
    density.push_back(6 * x);
  }
  CHECK(weighted_integration_error(values, density, 3, 1.0 / 3) < 1e-5);
  CHECK(weighted_integration_error(values, density, 6, 1.0 / 3) == Approx(1.0 / 3).epsilon(1e-4));
}

TEST_CASE("prefix_integration_errors: each equals the error of its prefix") {
  std::vector<double> values;
  for (std::uint64_t i = 0; i < 9000; ++i)
    values.push_back(random_pair(make_random_key(3, {}), Stream::sequence, i).first);
  const std::vector<std::uint64_t> counts{1, 2, 2, 100, 5000, 9000};
  const auto errors = prefix_integration_errors(values, counts, 0.5);
  REQUIRE(errors.size() == counts.size());
  for (std::size_t i = 0; i < counts.size(); ++i)
    CHECK(errors[i] == Approx(integration_error(std::span(values).first(counts[i]), 0.5)).margin(1e-14));
}

TEST_CASE("integration_error: invalid arguments are refused") {
  const std::vector<double> none, one{1}, two{1, 2}, zero{0};
  CHECK_THROWS_AS(integration_error(none, 0), std::invalid_argument);
  CHECK_THROWS_AS(weighted_integration_error(one, two, 1, 0), std::invalid_argument);
  CHECK_THROWS_AS(weighted_integration_error(one, zero, 1, 0), std::invalid_argument);
  const std::vector<std::uint64_t> zero_count{0}, descending{2, 1}, beyond{3};
  CHECK_THROWS_AS(prefix_integration_errors(two, zero_count, 0), std::invalid_argument);
  CHECK_THROWS_AS(prefix_integration_errors(two, descending, 0), std::invalid_argument);
  CHECK_THROWS_AS(prefix_integration_errors(two, beyond, 0), std::invalid_argument);
}

TEST_CASE(
    "mean_estimate: the mean of uniform samples, else self-normalized, whatever the scale of the density") {
  const std::vector<double> values{1, 2, 6};
  CHECK(mean_estimate(values) == 3);
  for (const double factor : {1.0, 0.25}) {
    const std::vector<double> density{factor * 1, factor * 2, factor * 4};
    CHECK(mean_estimate(values, density) == Approx((1 + 2 / 2.0 + 6 / 4.0) / (1 + 1 / 2.0 + 1 / 4.0)));
  }
  CHECK_THROWS_AS(mean_estimate({}), std::invalid_argument);
  CHECK_THROWS_AS(mean_estimate(values, std::vector<double>{1, 2}), std::invalid_argument);
  CHECK_THROWS_AS(mean_estimate(values, std::vector<double>{1, 0, 2}), std::invalid_argument);
}

TEST_CASE("summarize_errors: root mean square, max, and deviation about the mean") {
  const ErrorSummary summary = summarize_errors(std::vector<double>{-3, 1, 2});
  CHECK(summary.rms == Approx(std::sqrt(14.0 / 3)));
  CHECK(summary.largest == 3);
  CHECK(summary.standard_deviation == Approx(std::sqrt(7.0)));
  CHECK(summarize_errors(std::vector<double>{-2}).standard_deviation == 0);
  CHECK_THROWS_AS(summarize_errors({}), std::invalid_argument);
}
