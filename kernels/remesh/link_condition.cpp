#include "kernels/remesh/link_condition.h"

namespace meander {

namespace {

bool keeps_apex(const EditedMesh& mesh, std::uint32_t h) {
  const std::uint32_t c = mesh.apex(h);
  if (mesh.opposite[next_half_edge(h)] == no_index && mesh.opposite[previous_half_edge(h)] == no_index)
    return false;
  std::uint32_t neighbours = 0;
  mesh.for_neighbours(c, [&](std::uint32_t, std::uint32_t) { ++neighbours; });
  return neighbours > (mesh.is_boundary_vertex(c) ? 2u : 3u);
}

}  // namespace

bool LinkCondition::holds(const EditedMesh& mesh, std::uint32_t h, std::uint32_t v) {
  const std::uint32_t w = mesh.start(h) == v ? mesh.end(h) : mesh.start(h), g = mesh.opposite[h];
  if (g != no_index && mesh.is_boundary_vertex(v) && mesh.is_boundary_vertex(w)) return false;
  mark_.resize(mesh.position.size(), 0);
  ++stamp_;
  mesh.for_neighbours(w, [&](std::uint32_t u, std::uint32_t) { mark_[u] = stamp_; });
  std::uint32_t common = 0, twice = 0;
  mesh.for_neighbours(v, [&](std::uint32_t u, std::uint32_t) {
    common += mark_[u] == stamp_;
    twice += u == w;
  });
  if (twice != 1 || common != (g == no_index ? 1u : 2u)) return false;
  if (!keeps_apex(mesh, h)) return false;
  return g == no_index || keeps_apex(mesh, g);
}

}  // namespace meander
