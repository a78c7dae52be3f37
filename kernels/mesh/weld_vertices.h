// Vertices of equal position.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "kernels/mesh/polygon_mesh.h"

namespace meander {

// For every vertex that is used the lowest used one with the bits of its position (-0 = 0), no_index for
// others; positions of used vertices must be finite. Counts in repairs the vertices that are replaced. O(V),
// at most 8 bytes a vertex of scratch, and 20 for each that may be equal to another. Parallel where vertices
// are many.
std::vector<std::uint32_t> weld_vertices(const PolygonMesh& mesh, std::span<const std::uint8_t> used,
                                         RepairCounts& repairs);

}  // namespace meander
