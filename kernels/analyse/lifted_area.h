// Areas of the smooth surface that vertex normals describe (docs/METHODS.md 11), triangle by triangle.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace meander {

// The area of every triangle lifted by lift_samples, T numbers in squared units of the positions. x, y, z: V
// finite positions; triangles: 3 T vertex numbers; normals: 9 T of crease_normals. Extrapolated from 2 x 2
// and 4 x 4 parts of the triangle: the error is O(h^4) of the area for h = edge x curvature. O(T), 2 us a
// triangle; parallel, deterministic. Throws std::invalid_argument when lengths do not fit.
std::vector<double> lifted_areas(std::span<const double> x, std::span<const double> y,
                                 std::span<const double> z, std::span<const std::uint32_t> triangles,
                                 std::span<const double> normals);

}  // namespace meander
