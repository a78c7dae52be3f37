// How far a surface is from the samples on it: the largest hole and the mean (docs/METHODS.md 13.7).
#pragma once

#include <cstdint>
#include <span>

#include "kernels/analyse/mesh_distance.h"

namespace meander {

// Straight distances from the points of a surface to the nearest sample.
struct Coverage {
  double radius = 0;   // the largest, to within 0.1 %
  double mean = 0;     // over the area: the Chamfer distance from the surface to the samples
  double hole = 0;     // radius / hexagonal_hole: 1 is the optimum of the plane
  double chamfer = 0;  // mean / hexagonal_mean_distance: 1 is the optimum of the plane
};

// surface: of finite positions, with area > 0. points: 3 n coordinates, finite, n >= 1, in the units of the
// surface. seed: of the 20 n reference points (20,000 at least) that the mean is taken over; its error is
// some 1 / 1000. The radius does not depend on them but for its tolerance: triangles are halved until none
// can hold a larger distance (a distance is convex, so that its maximum on a piece is at a corner); triangles
// of no area count. 8 to 25 us a point and 1 us a triangle; pure in the arguments, the same for any number
// of threads. Throws std::invalid_argument for points that are none or not finite, ItemError(zero_area)
// without area.
Coverage coverage_of(const TriangleSpans& surface, std::span<const double> points, std::uint64_t seed);

}  // namespace meander
