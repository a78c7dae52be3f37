// Neighbors of samples in the metric of their spacings, and whether a band around seams differs from the
// rest.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "kernels/analyse/tangent_samples.h"

namespace meander {

// The metric length between two samples, in spacings: (|S^-1 v| + |S'^-1 v'|) / 2 with the geodesic vectors v
// and v' from either sample to the other (geodesic_length() in the projected direction). Pairs whose unit
// normals have a cosine below this are not neighbors (other sheets, folds).
inline constexpr double neighbor_normal_cosine = 0.2;

// The metric length from each sample to the nearest other one; infinite if there is none. Random samples on a
// nearly flat surface: 1/2 on average (the area per sample is 1 in these units); stratified ones more. Exact
// for that length: k-d tree, with balls that grow to twice the best length times s1. O(N log N x ratio),
// parallel, deterministic. Throws like prepare_tangent_samples.
std::vector<double> metric_nearest_distances(const TangentSamples& samples);

// Number of other samples within a metric length of `radius` > 0 spacings, per sample: pi radius^2 on average
// for random samples, less for stratified ones with radius ~ 1.
std::vector<double> metric_neighbor_counts(const TangentSamples& samples, double radius);

// Mean of a value over the samples of a band against the mean over the others.
struct BandComparison {
  std::uint64_t in_band = 0, outside = 0;
  double band_mean = 0, outside_mean = 0;
  double ratio = 0;           // band_mean / outside_mean; NaN when either has fewer than two samples
  double standard_error = 0;  // of the ratio
};
// values: one per sample (metric_nearest_distances, metric_neighbor_counts), infinite ones are left out;
// in_band: nonzero for samples of the band. The error is first-order; `shared` values are taken to be worth
// one independent value. For independent samples that is 2 for nearest distances and 2 + the mean for counts:
// neighbors have both in common, and the number of samples that happen to lie in the band moves all counts
// there. Stratified samples vary less, so that the error is too large for them. Throws std::invalid_argument
// when lengths differ or shared < 1.
BandComparison compare_band(std::span<const double> values, std::span<const std::uint8_t> in_band,
                            double shared = 2);

// Samples at most `width` from the seams; distances: to the nearest seam, per sample, any unit (divide by the
// spacing for a band that is as wide as the samples are apart).
std::vector<std::uint8_t> seam_band(std::span<const double> distances, double width);

}  // namespace meander
