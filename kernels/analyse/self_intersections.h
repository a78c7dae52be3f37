// Triangles of a mesh that run through each other.
#pragma once

#include <cstdint>

#include "kernels/analyse/mesh_distance.h"

namespace meander {

// The pairs of triangles without a common vertex of which an edge of one crosses the inside of the other:
// signs of volumes in double, so that triangles that touch, or lie in one plane, may count or not. Vertices
// at one place are different vertices. O(T log T + pairs of boxes that overlap), parallel in fixed blocks;
// deterministic. Coordinates must be finite.
std::uint64_t self_intersections(const TriangleSpans& mesh);

}  // namespace meander
