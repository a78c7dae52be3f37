// Taking the vertices of the input out of a triangulation that has the samples among its vertices.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "kernels/core/cancel.h"
#include "kernels/remesh/edited_mesh.h"
#include "kernels/remesh/surface_lines.h"

namespace meander {

// Removes the vertices 0 .. W - 1 for W spacings: each moves along an edge to a neighbor, in rounds of
// vertices that are no neighbors of each other (Dobkin and Kirkpatrick 1985), and the triangles around it
// are flipped to Delaunay ones. The neighbor is the one that gives the best triangles among those that keep
// the topology (the link condition; Dey, Edelsbrunner, Guha, Nekhayev 1999, "Topology preserving edge
// contraction") and turn no normal far; what stays is tried again with less of that. A vertex that still
// stays is given fewer neighbors by flips. Vertices of lines move along them only, where lines keep to
// LineParameters (split_lines comes later, with cuts between what is left). Vertices that cannot go without
// changing the topology stay.
//   spacing: W lengths, of the samples around each vertex
//   kept: W, 1 for vertices that are to stay; or empty
// Returns W vertices, a neighbor for each that went, itself for one that stayed. Bounded rounds; O(T log (W
// / samples)) in practice, 2 us a vertex. Throws what `cancel` throws.
std::vector<std::uint32_t> remove_vertices(EditedMesh& mesh, std::span<const double> spacing,
                                           const LineParameters& lines, std::span<const std::uint8_t> kept,
                                           const CancelToken& cancel = {});

}  // namespace meander
