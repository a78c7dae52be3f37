// Cutting a component open to a disk (docs/METHODS.md 3).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "kernels/core/cancel.h"
#include "kernels/mesh/measured_mesh.h"

namespace meander {

struct CutParameters {
  std::uint32_t extremity_seams = 4;  // seams to extremities on top of what topology needs; 0..16. More
                                      // seams: less distortion, more global overlap.
};

// A component with its cut: local numbering, vertices duplicated along the seams. One disk.
// Chart triangle t is working triangle triangle_begin + t of the PreparedMesh.
struct CutChart {
  std::uint32_t triangle_begin = 0;
  std::vector<std::uint32_t> triangles;      // 3 T chart vertices
  std::vector<std::uint32_t> opposite;       // 3 T half-edges of this chart, no_index on the boundary
  std::vector<std::uint32_t> source_vertex;  // chart vertex -> working vertex of the PreparedMesh
  std::vector<std::uint8_t> seam;  // 3 T: 1 where the half-edge is a seam (has an opposite in the uncut mesh)
  std::uint32_t boundary_edges = 0;

  std::size_t triangle_count() const { return triangles.size() / 3; }
  std::size_t vertex_count() const { return source_vertex.size(); }
};

// Tree-cotree for handles (Eppstein 2003; Erickson and Whittlesey 2005), boundary loops joined by shortest
// paths, then farthest-point extremity seams: shortest paths from the farthest vertex to everything cut so
// far, as long as it is farther away than r = sqrt(area / pi), or r / 2 when the component is closed or its
// rim is shorter than pi r. A closed surface of genus 0 first gets a path between two far vertices, which
// counts as two seams. Postconditions, checked (ItemError(internal) when broken): connected, V - E + F = 1,
// exactly one boundary loop of at least three edges, every vertex fan a half-disk or disk. Cost: O(T log T).
// Deterministic; throws timeout / RunCancelled from `cancel`.
CutChart cut_to_disk(const MeasuredMesh& surface, const Component& component, const CutParameters& parameters,
                     const CancelToken& cancel = {});

// Adds one more seam: the shortest path from `chart_vertex` (interior) to the boundary of the chart by
// MeasuredMesh::length, never through another boundary vertex. Returns false (chart unchanged) when the
// vertex is on the boundary.
bool add_seam(const MeasuredMesh& surface, CutChart& chart, std::uint32_t chart_vertex,
              const CancelToken& cancel = {});

}  // namespace meander
