#include "kernels/remesh/link_condition.h"

namespace meander {

namespace {

bool keeps_apex(const EditedMesh& mesh, std::uint32_t h) {
  const std::uint32_t c = mesh.apex(h);
  if (mesh.opposite[next_half_edge(h)] == no_index && mesh.opposite[previous_half_edge(h)] == no_index)
    return false;
  // More than two neighbors at a boundary, of which the last has no half-edge from here; three inside.
  return mesh.has_more_outgoing(c, mesh.is_boundary_vertex(c) ? 1 : 3);
}

// Neighbors of the end of an edge, beyond which each neighbor of the other end is asked instead.
constexpr std::uint32_t many_neighbors = 64;

}  // namespace

bool LinkCondition::holds(const EditedMesh& mesh, std::uint32_t h, std::uint32_t v) {
  const std::uint32_t w = mesh.start(h) == v ? mesh.end(h) : mesh.start(h), g = mesh.opposite[h];
  if (g != no_index && mesh.is_boundary_vertex(v) && mesh.is_boundary_vertex(w)) return false;
  const bool is_hub = mesh.has_more_outgoing(w, many_neighbors);
  if (!is_hub) {
    mark_.resize(mesh.position.size(), 0);
    ++stamp_;
    mesh.for_neighbors(w, [&](std::uint32_t u, std::uint32_t) { mark_[u] = stamp_; });
  }
  std::uint32_t common = 0, twice = 0;
  mesh.for_neighbors(v, [&](std::uint32_t u, std::uint32_t) {
    if (u == w)
      ++twice;
    else
      common += is_hub ? mesh.are_neighbors(u, w) : mark_[u] == stamp_;
  });
  if (twice != 1 || common != (g == no_index ? 1u : 2u)) return false;
  if (!keeps_apex(mesh, h)) return false;
  return g == no_index || keeps_apex(mesh, g);
}

}  // namespace meander
