// The error of a histogram against a known one.
#pragma once

#include <span>

namespace meander {

// With B = histogram - G for the ground truth G, both of sum 1. relative: sum |B_i| / sum G_i; largest:
// max |B_i| (both as in Quinn et al. 2013); norm: sqrt(sum B_i^2) / sum G_i.
struct HistogramError {
  double relative = 0, largest = 0, norm = 0;
};

// Compares two histograms with the same bins; `measured` has at least as many as `ground_truth`, whose sum is
// positive. O(bins).
HistogramError histogram_error(std::span<const double> measured, std::span<const double> ground_truth);

}  // namespace meander
