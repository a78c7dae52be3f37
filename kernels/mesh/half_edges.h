// Adjacency of a triangle list as one array: the half-edge on the other side of each edge.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "kernels/mesh/prepared_mesh.h"

namespace meander {

// opposite[h] for 3 T half-edges: the other half-edge where exactly two triangles share an edge (whatever
// their winding), no_index else. Returns the number of edges with more than two triangles. Vertex numbers are
// below vertex_count. Lists by the smaller vertex; O(T) for bounded degree, O(T log T) at worst; 12 bytes a
// half-edge of scratch.
std::uint32_t pair_half_edges(std::span<const std::uint32_t> triangles, std::size_t vertex_count,
                              std::vector<std::uint32_t>& opposite);

// Numbers the vertex fans of an oriented triangle list: two corners get the same number when faces around a
// vertex join them. vertex[h] for the corner where half-edge h starts; numbers ascend with the first corner.
// Returns their count.
std::uint32_t number_fans(std::span<const std::uint32_t> opposite, std::vector<std::uint32_t>& vertex);

// The boundary half-edge that follows boundary half-edge h (its start is h's end). Every fan must be a
// half-disk.
std::uint32_t next_boundary_half_edge(std::span<const std::uint32_t> opposite, std::uint32_t h);

}  // namespace meander
