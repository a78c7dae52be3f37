// Histograms of the distances between two uniform random points of surfaces where they are known: what
// sampled histograms are compared with.
#pragma once

#include <cstdint>
#include <vector>

namespace meander {

// The unit sphere: `bins` shares of sum 1 in equal bins of [0, 2], where distances have the density d / 2.
// Exact. O(bins).
std::vector<double> sphere_distance_shares(std::uint32_t bins);

// The torus around the z axis whose tube of radius `tube` in (0, 1] runs round the unit circle, in equal bins
// of [0, 2 + 2 tube]. Error below 1e-6 for tubes up to 1/2. O(1e6 bins).
std::vector<double> torus_distance_shares(std::uint32_t bins, double tube);

}  // namespace meander
