// Adjacency of a triangle list as one array: the half-edge on the other side of each edge.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "kernels/mesh/prepared_mesh.h"

namespace meander {

// Properties of a mesh that pair_half_edges finds on its way.
struct FanSurvey {
  bool consistent = true;  // the two triangles of every edge run along it in opposite directions
  // For every vertex 1 where faces join all its corners to one fan; 0 where they may not.
  std::vector<std::uint8_t> one_fan;
};

// Sets opposite[h] for 3 T half-edges: the other half-edge where exactly two triangles share an edge
// (whatever their winding), no_index elsewhere. Returns the number of edges with more than two triangles.
// Vertex numbers are below vertex_count, and the three of a triangle differ. Compares the corners at every
// vertex: O(T) for bounded degree, O(T log T) at worst.
std::uint32_t pair_half_edges(std::span<const std::uint32_t> triangles, std::size_t vertex_count,
                              std::vector<std::uint32_t>& opposite, FanSurvey* survey = nullptr);

// Calls visit(corner) for the corners of the fan of corner h, h first: one way around until visit returns
// false or the boundary is reached, then the other way likewise. visit must return false at corners that it
// has seen.
template <class Visit>
void for_fan(std::span<const std::uint32_t> opposite, std::uint32_t h, const Visit& visit) {
  for (std::uint32_t at = h; at != no_index && visit(at);) at = opposite[previous_half_edge(at)];
  for (std::uint32_t at = opposite[h]; at != no_index; at = opposite[at]) {
    at = next_half_edge(at);
    if (!visit(at)) break;
  }
}

// Numbers the vertex fans of an oriented triangle list: two corners get the same number when faces around a
// vertex join them. Sets vertex[h] for the corner where half-edge h starts; numbers ascend with the first
// corner. Returns the number of fans. O(T).
std::uint32_t number_fans(std::span<const std::uint32_t> opposite, std::vector<std::uint32_t>& vertex);

// Flags the vertices of the triangles at the ends of boundary half-edges. O(T).
std::vector<std::uint8_t> boundary_vertices(std::span<const std::uint32_t> triangles,
                                            std::span<const std::uint32_t> opposite,
                                            std::size_t vertex_count);

// The boundary half-edge that follows boundary half-edge h: it starts where h ends. Every fan must be a
// half-disk. O(degree).
std::uint32_t next_boundary_half_edge(std::span<const std::uint32_t> opposite, std::uint32_t h);

}  // namespace meander
