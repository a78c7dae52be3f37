// Intake: from any polygon soup to oriented 2-manifold components (docs/METHODS.md 2).
#pragma once

#include "kernels/core/cancel.h"
#include "kernels/mesh/prepared_mesh.h"

namespace meander {

// Drops bad faces (each counted in repairs), triangulates (fans when convex, ear clipping when not), welds
// vertices of equal bits (-0 = 0; adjacency only), splits edges of more than two faces and vertices of more
// than one fan, orients every component (the majority of its area keeps the file's winding) and sorts
// triangles by component.
//
// Area is unchanged by every step. A face stored twice counts twice.
// Throws ItemError: empty (no face in the file), index_out_of_range or non_finite (no face left, the commoner
// cause; also where the diagonal or the area is more than double holds), zero_area (area <= 1e-14
// diagonal^2), timeout; unsupported_format or too_large (more than 32 bits can number). Cost: O(K) time but
// for fans of many triangles, which are sorted, and concave polygons of many corners (clip_ears); about 150
// bytes a triangle. Deterministic, thread-safe.
PreparedMesh prepare_mesh(const PolygonMesh& mesh, const CancelToken& cancel = {});

// The same triangles as they are, for those who need their areas alone: in the order and with the winding of
// the file, over its vertices, without neighbours (has_topology() is false), all in one component. Repairs
// are those of faces only. Fails as prepare_mesh does. O(K), about 50 bytes a triangle and 25 a vertex.
PreparedMesh prepare_soup(const PolygonMesh& mesh, const CancelToken& cancel = {});

}  // namespace meander
