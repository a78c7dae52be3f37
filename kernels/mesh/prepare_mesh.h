// Intake: from any polygon soup to oriented 2-manifold components (docs/METHODS.md 2).
#pragma once

#include <algorithm>

#include "kernels/core/cancel.h"
#include "kernels/mesh/prepared_mesh.h"

namespace meander {

// Prepares any polygon soup. It drops bad faces (each counted in repairs), triangulates (fans when convex,
// ear clipping when not), welds vertices of equal bits (-0 = 0; adjacency only), splits edges of more than
// two faces and vertices of more than one fan, orients every component (the majority of its area keeps the
// file's winding) and sorts triangles by component.
//
// Area is unchanged by every step. A face stored twice counts twice.
//
// Throws ItemError: empty (no face in the file); index_out_of_range or non_finite (no face left, by the more
// frequent cause; non_finite also where the diagonal or the area overflows double); zero_area (area <= 1e-14
// diagonal^2); timeout; unsupported_format or too_large (more than 32 bits can number). O(K) time, except for
// fans of many triangles, which are sorted, and concave polygons of many corners (clip_ears). Deterministic,
// thread-safe.
PreparedMesh prepare_mesh(const PolygonMesh& mesh, const CancelToken& cancel = {});

// Prepares the triangles for callers that need their areas alone: in the order and with the winding of the
// file, over its vertices, without neighbors (has_topology() is false), all in one component. Only faces are
// repaired. Throws as prepare_mesh. O(K).
PreparedMesh prepare_soup(const PolygonMesh& mesh, const CancelToken& cancel = {});

// Upper bounds of bytes beside the file: while the mesh is prepared, and of what is left while a sampler
// frees its neighbors.
struct PreparedBytes {
  double peak = 0, held = 0;
};
constexpr PreparedBytes prepared_bytes(double triangles, double vertices, bool topology) {
  // Half-edges, slots, positions of half a vertex, areas, scratch.
  constexpr double bytes_per_triangle = 150;
  // Without topology: corners, slots, polygon, area, mass; and the working position of every vertex.
  constexpr double bytes_per_soup_triangle = 54, bytes_per_soup_vertex = 30;
  // A vertex of the file may be several: one more a triangle, though never more than three of each.
  constexpr double bytes_per_held_triangle = 56, bytes_per_held_vertex = 24;
  const double soup = triangles * bytes_per_soup_triangle + vertices * bytes_per_soup_vertex;
  if (!topology) return {soup, soup};
  return {triangles * bytes_per_triangle,
          triangles * bytes_per_held_triangle +
              std::min(3 * triangles, vertices + triangles) * bytes_per_held_vertex};
}

}  // namespace meander
