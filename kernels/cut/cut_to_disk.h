// Cutting a component open to a disk (docs/METHODS.md 3).
#pragma once

#include <cstdint>
#include <vector>

#include "kernels/core/cancel.h"
#include "kernels/mesh/measured_mesh.h"

namespace meander {

struct CutParameters {
  // Seams to extremities on top of those that topology needs; 0..16. More seams give less distortion and more
  // global overlap.
  std::uint32_t extremity_seams = 4;
};

// A component with its cut, one disk: local numbering, vertices duplicated along the seams. Chart triangle t
// is working triangle triangle_begin + t of the PreparedMesh.
struct CutChart {
  std::uint32_t triangle_begin = 0;
  std::vector<std::uint32_t> triangles;      // 3 T chart vertices
  std::vector<std::uint32_t> opposite;       // 3 T half-edges of this chart, no_index on the boundary
  std::vector<std::uint32_t> source_vertex;  // chart vertex -> working vertex of the PreparedMesh
  std::vector<std::uint8_t> seam;            // 3 T: 1 at seams (interior edges of the uncut mesh)
  std::uint32_t boundary_edges = 0;

  std::size_t triangle_count() const { return triangles.size() / 3; }
  std::size_t vertex_count() const { return source_vertex.size(); }
};

// Cuts a component to a disk: tree-cotree for handles (Eppstein 2003; Erickson and Whittlesey 2005), boundary
// loops joined by shortest paths, then farthest-point extremity seams. These are shortest paths from the
// farthest vertex to everything cut so far, as long as it is farther away than r = sqrt(area / pi), or r / 2
// when the component is closed or its rim is shorter than pi r. A closed surface of genus 0 first gets a path
// between two far vertices, which counts as two seams. Postconditions, checked (ItemError(internal) when
// broken): connected, V - E + F = 1, exactly one boundary loop of at least three edges, every vertex fan a
// half-disk or disk. Deterministic; throws timeout / RunCanceled from `cancel`. O(T log T).
CutChart cut_to_disk(const MeasuredMesh& surface, const Component& component, const CutParameters& parameters,
                     const CancelToken& cancel = {});

// Adds one more seam: the shortest path by MeasuredMesh::length from the interior vertex `chart_vertex` to
// the boundary of the chart, never through another boundary vertex. Returns false (chart unchanged) when the
// vertex is on the boundary. O(T log T).
bool add_seam(const MeasuredMesh& surface, CutChart& chart, std::uint32_t chart_vertex,
              const CancelToken& cancel = {});

}  // namespace meander
