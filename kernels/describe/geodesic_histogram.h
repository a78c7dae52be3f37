// Histogram of geodesic distances between the samples of a model.
#pragma once

#include <cstdint>
#include <vector>

#include "kernels/describe/distance_histogram.h"
#include "kernels/describe/heat_geodesics.h"

namespace meander {

struct GeodesicHistogramParameters {
  std::uint32_t bins = 32;     // 8..1024
  std::uint32_t sources = 64;  // the first samples; 0 or more than there are: all
  HistogramScale scale = HistogramScale::largest;
};

struct GeodesicHistogram {
  std::vector<float> share;       // `bins` shares of the counted pairs; all 0 when no pair counts
  double mean = 0, largest = 0;   // distance over the counted pairs, file units
  double upper = 0;               // upper end of the last bin, file units
  std::uint64_t pairs = 0;        // counted pairs of a source and another sample of its component
  double disconnected_share = 0;  // pairs on different components, not counted, among all pairs
};

// Counts distances from the first `sources` samples (a stratified subset, because samples are in progressive
// order) to all other samples. A distance d lies in bin min(bins - 1, floor(bins d / upper)). Up to 2^25
// distances are kept (256 MiB); more are computed twice. Cost: HeatGeodesics::to_points. Deterministic for
// every thread count. Throws std::invalid_argument for parameters out of range, and as
// HeatGeodesics::to_points.
GeodesicHistogram geodesic_histogram(const HeatGeodesics& geodesics, PointsOnMesh samples,
                                     const GeodesicHistogramParameters& parameters = {},
                                     const CancelToken& cancel = {});

}  // namespace meander
