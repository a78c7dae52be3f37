// Items in space sorted along the 3-D Hilbert curve, with a tree of bounding boxes over runs of them.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace meander {

// n items along the curve: position p holds item order[p]. Level 0 has one node per `leaf` positions, each
// higher level one node per `fan` nodes below; a node is six doubles, the center and the half-extent of the
// axis-parallel box around its items.
struct BoundsTree {
  static constexpr std::size_t leaf = 16;
  static constexpr std::size_t fan = 4;
  std::vector<std::uint32_t> order;
  std::vector<std::vector<double>> levels;

  std::size_t count() const { return order.size(); }
};

// Builds the tree. low, high: 3 n corners of the items' own boxes (the same span twice for points); finite, n
// < 2^32. O(n log n). Deterministic.
BoundsTree build_bounds_tree(std::span<const double> low, std::span<const double> high);

// Calls visit(item) for the items of all leaves whose box meets the box from low to high, until it returns
// false; some of these items lie outside of the box. low, high: three numbers each. Returns false when it was
// stopped. O(log n + visited items).
template <class Visit>
bool visit_near(const BoundsTree& tree, const double* low, const double* high, const Visit& visit,
                std::size_t level, std::size_t node) {
  const double* of = tree.levels[level].data() + 6 * node;
  // The center and half-extent of the node are rounded.
  for (std::size_t k = 0; k < 3; ++k) {
    const double reach = of[3 + k] + 1e-15 * (std::abs(of[k]) + of[3 + k]);
    if (of[k] - reach > high[k] || of[k] + reach < low[k]) return true;
  }
  if (level > 0) {
    const std::size_t below = tree.levels[level - 1].size() / 6;
    for (std::size_t child = BoundsTree::fan * node; child < BoundsTree::fan * (node + 1) && child < below;
         ++child)
      if (!visit_near(tree, low, high, visit, level - 1, child)) return false;
    return true;
  }
  const std::size_t end = std::min(tree.count(), BoundsTree::leaf * (node + 1));
  for (std::size_t p = BoundsTree::leaf * node; p < end; ++p)
    if (!visit(tree.order[p])) return false;
  return true;
}

template <class Visit>
bool visit_near(const BoundsTree& tree, const double* low, const double* high, const Visit& visit) {
  return tree.count() == 0 || visit_near(tree, low, high, visit, tree.levels.size() - 1, 0);
}

}  // namespace meander
