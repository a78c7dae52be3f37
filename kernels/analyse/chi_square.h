// Goodness of fit of counts by Pearson's chi-square.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace meander {

// Q(a, x) = Gamma(a, x) / Gamma(a), the regularized upper incomplete gamma function; a > 0, x >= 0. Relative
// error about 1e-12 while a <= 1e6. Series for x < a + 1, else Lentz's continued fraction (Abramowitz and
// Stegun 1964, 6.5.29 and 6.5.31; Press et al. 2007, "Numerical Recipes", 6.2). O(sqrt(a) + 30). Pure.
// Throws std::invalid_argument outside the ranges.
double upper_gamma(double a, double x);

// Probability that a chi-square variable of `degrees` degrees of freedom is at least `statistic`. Pure.
double chi_square_p_value(double statistic, double degrees);

struct ChiSquare {
  double statistic = 0;
  double degrees = 0;     // cells - 1
  double p_value = 1;     // small: the counts do not follow the expectation
  std::size_t cells = 0;  // after merging
};

// Pearson's test of counts against expectations. `expected` need not sum to the total count: it is scaled.
// Neighboring cells (in the order given) are merged until each expects at least min_expected; a remainder
// at the end joins the last cell, so that no count is lost. With fewer than two cells the p-value is 1. A
// count in a cell that expects nothing, with no neighbor to merge with, cannot happen by this rule. The
// p-value is exact (asymptotically) for independent draws, and only too large for stratified ones, whose
// counts vary less. O(cells). Throws std::invalid_argument when the lengths differ or an expectation is
// negative or not finite.
ChiSquare chi_square_test(std::span<const std::uint64_t> counts, std::span<const double> expected,
                          double min_expected = 5);

}  // namespace meander
