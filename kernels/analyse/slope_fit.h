// Rates: the numbers of points of Quinn et al. 2013 and the least-squares line through errors in log-log.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace meander {

// error = exp(intercept) x count^slope
struct SlopeFit {
  double slope = 0;
  double intercept = 0;       // natural logarithm of the error at count 1
  double standard_error = 0;  // of the slope, from the residuals; NaN for two points

  double at(double count) const;  // the error on the line, count > 0
};

// Least-squares line through (log count, log error). Needs at least two different counts, all numbers
// positive and finite; else std::invalid_argument. O(n). Pure.
SlopeFit fit_slope(std::span<const double> counts, std::span<const double> errors);

// The survey's protocol: 2^l and 1.5 x 2^l for l = 1, 2, ... from `least` to `most`, both included if they
// are such numbers, ascending. survey_counts(1572864) are 2, 3, 4, 6, ..., 1048576, 1572864.
std::vector<std::uint32_t> survey_counts(std::uint32_t most, std::uint32_t least = 2);

}  // namespace meander
