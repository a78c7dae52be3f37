#include "kernels/analyse/region_counts.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace meander {

RegionCounts region_counts(std::span<const std::uint32_t> region, std::span<const double> measure,
                           std::span<const std::uint32_t> triangle, std::uint32_t regions,
                           double min_expected) {
  if (region.size() != measure.size())
    throw std::invalid_argument("region_counts: one label and one measure a triangle");
  RegionCounts result;
  result.counts.assign(regions, 0);
  result.expected.assign(regions, 0.0);
  double total = 0;
  for (std::size_t t = 0; t < region.size(); ++t) {
    if (region[t] >= regions) throw std::invalid_argument("region_counts: a label is out of range");
    if (!(measure[t] >= 0) || !std::isfinite(measure[t]))
      throw std::invalid_argument("region_counts: measures are finite and not negative");
    result.expected[region[t]] += measure[t];
    total += measure[t];
  }
  if (!(total > 0)) throw std::invalid_argument("region_counts: the measure is zero");
  for (const std::uint32_t t : triangle) {
    if (t >= region.size())
      throw std::invalid_argument("region_counts: a sample names a triangle that is not there");
    ++result.counts[region[t]];
  }
  const double scale = static_cast<double>(triangle.size()) / total;
  for (double& expected : result.expected) expected *= scale;
  result.test = chi_square_test(result.counts, result.expected, min_expected);
  result.dispersion = result.test.degrees > 0 ? result.test.statistic / result.test.degrees
                                              : std::numeric_limits<double>::quiet_NaN();
  for (std::uint32_t r = 0; r < regions; ++r)
    if (result.expected[r] > 0)
      result.worst =
          std::max(result.worst, std::abs(static_cast<double>(result.counts[r]) - result.expected[r]) /
                                     std::sqrt(result.expected[r]));
  return result;
}

}  // namespace meander
