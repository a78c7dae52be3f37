// Histogram of geodesic distances between the samples of a model.
#pragma once

#include <cstdint>
#include <vector>

#include "kernels/describe/heat_geodesics.h"

namespace meander {

// What the upper end of the last bin is: the largest distance counted (as in the survey), or three times the
// mean distance (Osada et al. 2002; what lies further is counted in the last bin).
enum class GeodesicScale : std::uint8_t { largest, mean };

struct GeodesicHistogramParameters {
  std::uint32_t bins = 32;     // 8..1024
  std::uint32_t sources = 64;  // the first so many samples; 0 or more than there are: all
  GeodesicScale scale = GeodesicScale::largest;
};

struct GeodesicHistogram {
  std::vector<float> share;       // `bins` shares of the counted pairs; all 0 when no pair counts
  double mean = 0, largest = 0;   // distance over the counted pairs, file units
  double upper = 0;               // upper end of the last bin, file units
  std::uint64_t pairs = 0;        // counted: source and another sample, on one component
  double disconnected_share = 0;  // of all such pairs, those on different components: left out
};

// Distances from the first `sources` samples (a stratified subset, samples being in progressive order) to all
// other samples. A distance d lies in bin min(bins - 1, floor(bins d / upper)). Up to 2^25 distances are kept
// (256 MiB); beyond that they are computed twice. Cost: HeatGeodesics::to_points. Deterministic for every
// thread count. Throws std::invalid_argument for parameters out of range; as HeatGeodesics::to_points.
GeodesicHistogram geodesic_histogram(const HeatGeodesics& geodesics, PointsOnMesh samples,
                                     const GeodesicHistogramParameters& parameters = {},
                                     const CancelToken& cancel = {});

}  // namespace meander
