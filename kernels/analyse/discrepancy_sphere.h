// Discrepancies on the unit sphere: spherical caps and spherical triangles (docs/METHODS.md 13.2).
#pragma once

#include <span>

#include "kernels/analyse/discrepancy_shapes.h"
#include "kernels/analyse/point_index.h"

namespace meander {

// For each of parameters.shapes uniformly random axes the exact supremum over heights of
// |#{a . p <= h}/N - (1 + h)/2| (a cap and its complement have the same). x, y, z: N >= 1 unit vectors (else
// std::invalid_argument). O(N) an axis, about 8 ns a point: N = 1,572,864 and 200 axes take 2.5 s of one
// core; do not ask for 2^14 axes there. Axis i is Lambert's map (angle 2 pi u, height 1 - 2 v) of the i-th
// pair.
ShapeDiscrepancy cap_discrepancy(std::span<const double> x, std::span<const double> y,
                                 std::span<const double> z, const ShapeParameters& parameters = {});

// Triangles of great arcs between three uniformly random points; area by Van Oosterom and Strackee 1983.
// points: build_point_index(x, y, z) of unit vectors. About 0.1 us x sqrt(N) a
// triangle; corners by the same map.
ShapeDiscrepancy spherical_triangle_discrepancy(const PointIndex<3>& points,
                                                const ShapeParameters& parameters = {});

}  // namespace meander
