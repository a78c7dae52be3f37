// Whether an edge can be contracted without changing the topology.
#pragma once

#include <cstdint>
#include <vector>

#include "kernels/remesh/edited_mesh.h"

namespace meander {

// Scratch of one thread; it grows with the vertices.
class LinkCondition {
 public:
  // Whether v may move along the edge of h to its other end: the two have no neighbors in common but the
  // apexes of the edge, and an apex keeps three edges inside, two at the boundary (Dey, Edelsbrunner, Guha,
  // Nekhayev 1999). O(edges around the two).
  bool holds(const EditedMesh& mesh, std::uint32_t h, std::uint32_t v);

 private:
  std::vector<std::uint32_t> mark_;
  std::uint32_t stamp_ = 0;
};

}  // namespace meander
