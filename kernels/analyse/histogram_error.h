// The error of a histogram against a known one, and how repeated values spread.
#pragma once

#include <span>
#include <vector>

namespace meander {

// With B = histogram - G for the ground truth G, both of sum 1. relative: sum |B_i| / sum G_i; largest:
// max |B_i| (both as in Quinn et al. 2013); norm: sqrt(sum B_i^2) / sum G_i.
struct HistogramError {
  double relative = 0, largest = 0, norm = 0;
};

// Compares two histograms with the same bins; `measured` has at least as many as `ground_truth`, whose sum is
// positive. O(bins).
HistogramError histogram_error(std::span<const double> measured, std::span<const double> ground_truth);

// Mean, standard deviation of one value, and standard error of the mean.
struct Spread {
  double mean = 0, deviation = 0, error = 0;
};

// The spread of independent values; a single value has no deviation and no error, an empty list all zeros.
// O(n).
Spread spread_of(const std::vector<double>& values);

// (a - b) in standard errors of the difference; not finite where neither has an error.
double gap_of(const Spread& a, const Spread& b);

}  // namespace meander
