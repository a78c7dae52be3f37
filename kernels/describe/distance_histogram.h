// Histogram of the Euclidean distances between all pairs of points: the D2 of Osada et al. 2002 ("Shape
// distributions"), taken over every pair instead of random ones.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "kernels/core/cancel.h"
#include "kernels/core/instruction_set.h"

namespace meander {

// The scale that the range of the bins is tied to; larger distances count in the last bin.
enum class HistogramScale : std::uint8_t {
  largest,  // the largest distance (Quinn et al.): bins on [0, largest]
  mean,     // the mean distance (Osada et al. 2002): bins on [0, 3 mean]
};

struct DistanceHistogramParameters {
  std::uint32_t bins = 32;  // 8..1024
  HistogramScale scale = HistogramScale::largest;
  // > 0: bins on [0, range] in units of the points, whatever the scale; 0: the scale decides.
  double range = 0;
  InstructionSet instructions = InstructionSet::automatic;
};

// The range of the bins over the mean distance, for HistogramScale::mean.
inline constexpr double histogram_range_per_mean = 3;

// Throws std::invalid_argument for bins or range out of range, or instructions that the processor does not
// have.
void check_histogram_parameters(const DistanceHistogramParameters& parameters);

struct DistanceHistogram {
  std::vector<double> shares;         // bins; sum 1
  std::vector<std::uint64_t> counts;  // bins; sum pairs. Empty for weighted histograms
  double scale = 0;                   // largest or mean distance, as asked for, units of the points
  double range = 0;                   // the bins are equal parts of [0, range]
  std::uint64_t pairs = 0;            // n (n - 1) / 2
};

// Counts the distances of all pairs. points: 3 n coordinates, finite, n >= 2 (a row of /points), in any
// order: any permutation gives the same bytes. Distances above the range count in the last bin; a distance
// within float rounding (1e-7 relative) of an edge may fall on either side. Points that all coincide give
// scale 0 and everything in bin 0.
//
// Distances are float32 with one rounding per operation, the sum behind the mean is of integers (distances in
// units of 2^-23 of the power of two above the box's longest side), counts are integers: nothing depends on
// instructions, threads or order. O(n^2), parallel; bench/describe_bench.cpp measures it. Throws
// std::invalid_argument for fewer than two points, numbers that are not finite, bins or range out of range,
// or instructions that the processor does not have; RunCanceled and ItemError(timeout) from `cancel`.
DistanceHistogram distance_histogram(std::span<const float> points,
                                     const DistanceHistogramParameters& parameters = {},
                                     const CancelToken& cancel = {});

}  // namespace meander
