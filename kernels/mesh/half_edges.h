// Adjacency of a triangle list as one array: the half-edge on the other side of each edge.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "kernels/mesh/prepared_mesh.h"

namespace meander {

// What pair_half_edges sees of a mesh besides.
struct FanSurvey {
  bool consistent = true;  // the two triangles of every edge run along it in opposite directions
  // One for every vertex: 1 where faces join all its corners, so that they are one fan; 0: perhaps not.
  std::vector<std::uint8_t> one_fan;
};

// opposite[h] for 3 T half-edges: the other half-edge where exactly two triangles share an edge (whatever
// their winding), no_index else. Returns the number of edges with more than two triangles. Vertex numbers are
// below vertex_count; the three of a triangle differ. By the corners at every vertex; O(T) for bounded
// degree, O(T log T) at worst; 12 bytes a half-edge of scratch.
std::uint32_t pair_half_edges(std::span<const std::uint32_t> triangles, std::size_t vertex_count,
                              std::vector<std::uint32_t>& opposite, FanSurvey* survey = nullptr);

// Calls visit(corner) for the corners of the fan of corner h, h first, until visit says false in both
// directions: it has to where it was before.
template <class Visit>
void for_fan(std::span<const std::uint32_t> opposite, std::uint32_t h, const Visit& visit) {
  for (std::uint32_t at = h; at != no_index && visit(at);)
    at = opposite[previous_half_edge(at)];  // one way round, until the start or a boundary
  for (std::uint32_t at = opposite[h]; at != no_index; at = opposite[at]) {
    at = next_half_edge(at);  // and the other way
    if (!visit(at)) break;
  }
}

// Numbers the vertex fans of an oriented triangle list: two corners get the same number when faces around a
// vertex join them. vertex[h] for the corner where half-edge h starts; numbers ascend with the first corner.
// Returns their count.
std::uint32_t number_fans(std::span<const std::uint32_t> opposite, std::vector<std::uint32_t>& vertex);

// The boundary half-edge that follows boundary half-edge h (its start is h's end). Every fan must be a
// half-disk.
std::uint32_t next_boundary_half_edge(std::span<const std::uint32_t> opposite, std::uint32_t h);

}  // namespace meander
