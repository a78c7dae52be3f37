// The planar sets that are made by elimination or iteration (used by planar_points).
#pragma once

#include <cstdint>

#include "kernels/core/random.h"
#include "kernels/pointset/plain_points.h"

namespace meander {

// Poisson disk set of exactly `count` points by weighted sample elimination (Yuksel 2015, "Sample Elimination
// for Generating Poisson Disk Sample Sets") of 5 x count random points, with his parameters alpha 8, beta
// 0.65, gamma 1.5. The square is not periodic: points may be slightly denser at its border. O(N log N); pure.
PlanarPoints poisson_disk_points(std::uint32_t count, RandomKey key);

// Lloyd's iteration (Lloyd 1982): each point moves to the centroid of its Voronoi cell in the unit square,
// cells by clipping at the bisectors of near points. O(N) an iteration; pure, parallel.
PlanarPoints centroidal_points(PlanarPoints start, std::uint32_t iterations);

}  // namespace meander
