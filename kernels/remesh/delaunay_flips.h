// Edge flips towards Delaunay triangles in space.
#pragma once

#include <cstdint>
#include <vector>

#include "kernels/remesh/edited_mesh.h"

namespace meander {

// Whether the edge is no line and turning it keeps a 2-manifold without two edges between the same vertices,
// whatever that does to the shape.
bool can_flip_in_topology(const EditedMesh& mesh, std::uint32_t h);

// Whether turning the edge keeps a 2-manifold without two edges between the same vertices and without folding
// the two triangles over: neither new normal turns more than about 75 degrees from the normal of the
// quadrilateral, and the edge gets no sharper than 60 degrees unless it was sharper before.
bool can_flip(const EditedMesh& mesh, std::uint32_t h);

// The largest cosine of an angle of a triangle: that of its least angle. 1 without area.
double least_angle_cosine(Vector3 a, Vector3 b, Vector3 c);

// Whether the angles opposite to the edge are more than pi in all.
bool is_longer_diagonal(const EditedMesh& mesh, std::uint32_t h);

// Flips the edges in `edges` and those that become wrong thereby, last first, until none is left or
// `most_flips` were made. Lines (EditedMesh::is_line) stay. In space the flips need not end by themselves.
// Returns the flips. `edges` is scratch afterwards.
std::uint32_t flip_to_delaunay(EditedMesh& mesh, std::vector<std::uint32_t>& edges, std::uint32_t most_flips);

// The same for all edges. O(T).
std::uint32_t flip_all_to_delaunay(EditedMesh& mesh);

}  // namespace meander
