#include "kernels/analyse/slope_fit.h"

#include <cmath>
#include <numbers>
#include <stdexcept>
#include <vector>

#include "support/catch.h"

using namespace meander;

TEST_CASE("fit_slope: lines, residuals by hand, and invalid input is refused") {
  std::vector<double> counts, errors;
  for (const std::uint32_t n : survey_counts(3072)) {
    counts.push_back(n);
    errors.push_back(0.7 * std::pow(n, -0.75));
  }
  SlopeFit fit = fit_slope(counts, errors);
  CHECK(fit.slope == Approx(-0.75));
  CHECK(std::exp(fit.intercept) == Approx(0.7));
  CHECK(fit.at(1000) == Approx(0.7 * std::pow(1000, -0.75)));
  CHECK(fit.standard_error < 1e-12);
  // Logarithms (0, 0), (1, 1), (2, 0): slope 0, intercept 1/3, squares 2/3, error sqrt(2/3 / 1 / 2).
  const double e = std::numbers::e;
  fit = fit_slope(std::vector{1.0, e, e * e}, std::vector{1.0, e, 1.0});
  CHECK(fit.slope == Approx(0).margin(1e-15));
  CHECK(fit.intercept == Approx(1 / 3.0));
  CHECK(fit.standard_error == Approx(std::sqrt(1 / 3.0)));
  CHECK(std::isnan(fit_slope(std::vector{1.0, 2.0}, std::vector{1.0, 0.5}).standard_error));
  CHECK_THROWS_AS(fit_slope(std::vector{1.0}, std::vector{1.0}), std::invalid_argument);
  CHECK_THROWS_AS(fit_slope(std::vector{2.0, 2.0}, std::vector{1.0, 2.0}), std::invalid_argument);
  CHECK_THROWS_AS(fit_slope(std::vector{1.0, 2.0}, std::vector{0.0, 2.0}), std::invalid_argument);
}

TEST_CASE("survey_counts: 2^l and 1.5 x 2^l") {
  CHECK(survey_counts(16) == std::vector<std::uint32_t>{2, 3, 4, 6, 8, 12, 16});
  CHECK(survey_counts(100, 16) == std::vector<std::uint32_t>{16, 24, 32, 48, 64, 96});
  const std::vector<std::uint32_t> all = survey_counts(1572864);
  CHECK(all.size() == 40);
  CHECK(all.back() == 1572864);
  CHECK(survey_counts(1).empty());
}
