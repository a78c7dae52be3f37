// What the laboratory measures, for the Python module; without one it says so.
#pragma once

#include <cstdint>
#include <span>

#include "kernels/core/cancel.h"
#include "kernels/mesh/polygon_mesh.h"

namespace meander {

// The error of points over random rotated boxes, relative to that of random points, as `measure boxes` prints
// it. points: 3 n finite coordinates, in those of the mesh. Throws ItemError as prepare_mesh does and
// zero_area for a surface that has no such boxes; std::runtime_error in a build without the laboratory. Cost:
// see random_boxes.
double box_error(const PolygonMesh& mesh, std::span<const double> points, std::uint32_t boxes,
                 std::uint64_t seed, const CancelToken& cancel);

}  // namespace meander
