// Welding of vertices at equal positions.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "kernels/mesh/polygon_mesh.h"

namespace meander {

// For every used vertex, the smallest used vertex with the bits of its position (-0 = 0); no_index for unused
// vertices. Positions of used vertices must be finite. Counts in repairs the vertices that are replaced.
// O(V); parallel for many vertices.
std::vector<std::uint32_t> weld_vertices(const PolygonMesh& mesh, std::span<const std::uint8_t> used,
                                         RepairCounts& repairs);

}  // namespace meander
