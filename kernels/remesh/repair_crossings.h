// Taking apart the triangles of a remeshed surface that run through each other.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "kernels/core/cancel.h"
#include "kernels/mesh/prepared_mesh.h"
#include "kernels/remesh/edited_mesh.h"

namespace meander {

// A component that was remeshed.
struct RepairedPart {
  EditedMesh* mesh = nullptr;
  std::span<const std::uint32_t> moved_to;  // W vertices of the surface: what remove_vertices returns
  std::span<const std::uint8_t> on_line;    // W: 1 for those on boundaries and creases
  std::span<const Vector3> places;  // of the vertices from W on, before they were fitted; may be empty
};

// Which vertices of the surface are listed around triangles that cross.
struct CrossingSurroundings {
  double reach = 0;            // how far from the place, over the longest edge of a pair
  bool around_parted = false;  // also around pairs that could be parted
};

struct CrossingReport {
  std::uint64_t left = 0;      // pairs of triangles that cross where the surface does not
  std::uint64_t of_input = 0;  // pairs that cross where triangles of the surface do
  bool is_partial = false;     // a search ended at its bound: there may be more, and all count as of_input
  std::uint32_t added = 0;     // vertices of the surface that were taken back
  // By part, ascending, and empty if nothing is left: vertices of the surface around the pairs that
  // CrossingSurroundings names. A mesh that keeps them, with the edges between them, is the surface there.
  std::vector<std::vector<std::uint32_t>> around;
};

// Looks for pairs of triangles without a common vertex that cross. Near those that the surface has, nothing
// is done. Of the others each is tried, in a bounded number of rounds: vertices that were fitted return to
// the surface; edges are flipped, if no triangle folds over by that; and vertices of the surface return
// between the ones that are there, the one that is nearest to the middle of an edge or a triangle. Every step
// keeps the topology and makes no further crossings. Of long needles nearly all may be near each other: steps
// end when they have looked at 256 triangles for each one of the mesh (and 2^22), a search when it has looked
// at 256 pairs of boxes that meet for each triangle (and 2^24), or 2^21 for 256 neighboring ones. O(T log
// T) up to these bounds, 0.5 us a triangle of the mesh; where there are crossings also a search of the
// surface, 1 us a triangle. Deterministic for every number of threads. Throws what `cancel` throws.
CrossingReport repair_crossings(std::span<const RepairedPart> parts, const PreparedMesh& surface,
                                CrossingSurroundings surroundings, const CancelToken& cancel = {});

}  // namespace meander
