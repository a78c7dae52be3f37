// Do regions of a surface hold as many samples as their share of the measure?
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "kernels/analyse/chi_square.h"

namespace meander {

struct RegionCounts {
  std::vector<std::uint64_t> counts;  // samples per region
  std::vector<double> expected;       // samples x share of the measure
  ChiSquare test;
  // statistic / degrees: 1 for independent samples (standard deviation sqrt(2 / degrees)); well below 1 for
  // stratified ones, whose counts vary only through strata cut by a region's border: their p-value is near 1,
  // and only a small one says anything. NaN without degrees.
  double dispersion = 0;
  double worst = 0;  // largest |count - expected| / sqrt(expected) over the regions of expected > 0
};

// region: label per triangle, below `regions` (segments, charts, patches); measure: per triangle (the
// integral of the density, >= 0); triangle: the triangle of every sample. Regions that expect fewer than
// min_expected samples are merged with the next in the order of labels. O(T + N). Throws
// std::invalid_argument when lengths differ, a label or triangle is out of range, or measures are negative,
// not finite or all zero.
RegionCounts region_counts(std::span<const std::uint32_t> region, std::span<const double> measure,
                           std::span<const std::uint32_t> triangle, std::uint32_t regions,
                           double min_expected = 5);

}  // namespace meander
