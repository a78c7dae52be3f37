// The corners around every vertex of a mesh.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "kernels/mesh/prepared_mesh.h"

namespace meander {

// The half-edges that start at each working vertex, ascending. O(T).
struct VertexCorners {
  std::vector<std::uint32_t> begin, corners;

  explicit VertexCorners(const PreparedMesh& mesh);
  std::span<const std::uint32_t> of(std::size_t vertex) const {
    return {corners.data() + begin[vertex], corners.data() + begin[vertex + 1]};
  }
};

inline VertexCorners::VertexCorners(const PreparedMesh& mesh)
    : begin(mesh.vertex_count() + 1, 0), corners(mesh.triangles.size()) {
  for (const std::uint32_t v : mesh.triangles) ++begin[v + 1];
  for (std::size_t v = 1; v < begin.size(); ++v) begin[v] += begin[v - 1];
  std::vector<std::uint32_t> at(begin.begin(), begin.end() - 1);
  for (std::uint32_t h = 0; h < mesh.triangles.size(); ++h) corners[at[mesh.triangles[h]]++] = h;
}

}  // namespace meander
