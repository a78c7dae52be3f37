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

// Gives vertices that are not `known` a value from their neighbors that were known before each of at most 64
// rounds: add(sum, vertex, neighbor) for each of these, then set(sum, vertex), which returns false where the
// sum gives no value. Returns the vertices that are left. O(rounds x unknown).
template <class Sum, class Add, class Set>
std::vector<std::uint32_t> fill_from_neighbors(const PreparedMesh& mesh, const VertexCorners& around,
                                               std::vector<std::uint8_t>& known, const Add& add,
                                               const Set& set) {
  std::vector<std::uint32_t> unknown;
  for (std::uint32_t v = 0; v < known.size(); ++v)
    if (known[v] == 0) unknown.push_back(v);
  std::vector<Sum> sums;
  for (int round = 0; round < 64 && !unknown.empty(); ++round) {
    sums.assign(unknown.size(), {});
    for (std::size_t i = 0; i < unknown.size(); ++i)
      for (const std::uint32_t h : around.of(unknown[i]))
        for (const std::uint32_t other : {next_half_edge(h), previous_half_edge(h)})
          if (const std::uint32_t w = mesh.triangles[other]; known[w] != 0) add(sums[i], unknown[i], w);
    std::size_t left = 0;
    for (std::size_t i = 0; i < unknown.size(); ++i) {
      const std::uint32_t v = unknown[i];
      if (set(sums[i], v))
        known[v] = 1;
      else
        unknown[left++] = v;
    }
    if (left == unknown.size()) break;
    unknown.resize(left);
  }
  return unknown;
}

}  // namespace meander
