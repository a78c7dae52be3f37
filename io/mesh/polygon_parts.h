// Internal to the mesh readers: polygons read block by block, and how the blocks become one mesh.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "kernels/core/cancel.h"
#include "kernels/mesh/count_limit.h"
#include "kernels/mesh/polygon_mesh.h"

namespace meander {

// How a reader cuts large input. The result never depends on it; tests force small blocks.
struct BlockRule {
  std::size_t parallel_from = std::size_t{4} << 20;  // bytes; smaller input is one block
  std::size_t block_bytes = std::size_t{1} << 20;    // bytes of input per block, >= 1

  std::size_t block_of(std::size_t bytes) const { return bytes < parallel_from ? bytes : block_bytes; }
};

// The polygons of one block: begin[p] .. begin[p + 1] are the corners of polygon p.
struct PolygonPart {
  std::vector<std::uint32_t> begin{0};
  std::vector<std::uint32_t> corners;

  std::size_t count() const { return begin.size() - 1; }
  // Throws ItemError(unsupported_format) when the corners are more than 32 bits can number.
  void close_polygon() {
    check_count(corners.size(), "corners");
    begin.push_back(static_cast<std::uint32_t>(corners.size()));
  }
  // A polygon that could not be read: it keeps its number and has no corners.
  void give_up_polygon() {
    corners.resize(begin.back());
    close_polygon();
  }
};

// Sets polygon_begin and corners to the polygons of all parts in order; empties the parts.
void join_polygons(std::vector<PolygonPart>& parts, PolygonMesh& mesh);
// Three corners per triangle, numbered 0, 1, 2, ...
void number_triangles(std::size_t triangles, PolygonMesh& mesh);

// Counts in the store have 32 bits.
std::uint32_t saturated(std::uint64_t count);

}  // namespace meander
