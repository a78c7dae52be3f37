// Histogram of the distances between all pairs of weighted points.
#pragma once

#include <span>

#include "kernels/describe/distance_histogram.h"

namespace meander {

// distance_histogram with pairs weighted w_i w_j, in double, for ground truths (mesh vertices weighted by
// their area, docs/METHODS.md 12.1). points: 3 n; weights: n, >= 0, finite, two of them positive; points of
// weight 0 count nowhere. The mean is weighted too. `instructions` must be automatic or scalar. O(n^2),
// parallel in fixed blocks: the same bytes for every thread count. Throws std::invalid_argument as above.
DistanceHistogram weighted_distance_histogram(std::span<const double> points, std::span<const double> weights,
                                              const DistanceHistogramParameters& parameters = {});

}  // namespace meander
