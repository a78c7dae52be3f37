// The tree of cuts above the cells of balanced bisection.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace meander {

// Where a node is cut.
struct TreeCut {
  static constexpr std::uint8_t between_parts = 3;
  std::uint32_t low_leaves = 0;
  std::uint8_t axis = 0;  // that the halves lie along, the lower one first; or between sheets or groups
};

// By node, depth first: the low half of node i is node i + 1; 2 c - 1 nodes with c leaves make up a half, so
// the other one is node i + 2 c.
struct CutTree {
  std::vector<TreeCut> cut;                  // leaves have none
  std::vector<std::array<float, 3>> center;  // of the mass

  explicit CutTree(std::uint32_t leaves) : cut(2 * std::size_t{leaves}), center(2 * std::size_t{leaves}) {}

  static std::size_t low(std::size_t node) { return node + 1; }
  std::size_t high(std::size_t node) const { return high(node, cut[node].low_leaves); }
  static std::size_t high(std::size_t node, std::uint32_t low_leaves) {
    return node + 2 * std::size_t{low_leaves};
  }
  // A node of so many leaves whose halves are there.
  void join(std::size_t node, std::uint32_t leaves, const TreeCut& at) {
    cut[node] = at;
    const float share = static_cast<float>(at.low_leaves) / static_cast<float>(leaves);
    for (std::size_t k = 0; k < 3; ++k)
      center[node][k] = share * center[low(node)][k] + (1 - share) * center[high(node)][k];
  }
};

}  // namespace meander
