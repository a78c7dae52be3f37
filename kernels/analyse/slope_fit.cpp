#include "kernels/analyse/slope_fit.h"

#include <cmath>
#include <limits>
#include <stdexcept>

namespace meander {

double SlopeFit::at(double count) const { return std::exp(intercept + slope * std::log(count)); }

SlopeFit fit_slope(std::span<const double> counts, std::span<const double> errors) {
  const std::size_t n = counts.size();
  if (n < 2 || errors.size() != n)
    throw std::invalid_argument("fit_slope needs at least two counts and as many errors");
  double mean_x = 0, mean_y = 0;
  for (std::size_t i = 0; i < n; ++i) {
    if (!(counts[i] > 0 && errors[i] > 0 && std::isfinite(counts[i]) && std::isfinite(errors[i])))
      throw std::invalid_argument("fit_slope needs positive numbers");
    mean_x += std::log(counts[i]);
    mean_y += std::log(errors[i]);
  }
  const auto points = static_cast<double>(n);
  mean_x /= points;
  mean_y /= points;
  double xx = 0, xy = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const double dx = std::log(counts[i]) - mean_x;
    xx += dx * dx;
    xy += dx * (std::log(errors[i]) - mean_y);
  }
  if (!(xx > 0)) throw std::invalid_argument("fit_slope needs two different counts");
  SlopeFit fit;
  fit.slope = xy / xx;
  fit.intercept = mean_y - fit.slope * mean_x;
  double squares = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const double residual = std::log(errors[i]) - (fit.intercept + fit.slope * std::log(counts[i]));
    squares += residual * residual;
  }
  fit.standard_error =
      n > 2 ? std::sqrt(squares / (points - 2) / xx) : std::numeric_limits<double>::quiet_NaN();
  return fit;
}

std::vector<std::uint32_t> survey_counts(std::uint32_t most, std::uint32_t least) {
  std::vector<std::uint32_t> counts;
  for (std::uint64_t power = 2; power <= most; power *= 2)
    for (const std::uint64_t count : {power, power + power / 2})
      if (count >= least && count <= most) counts.push_back(static_cast<std::uint32_t>(count));
  return counts;
}

}  // namespace meander
