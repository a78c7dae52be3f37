// Questions about rotated boxes to a tree of bounding boxes.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "kernels/analyse/box_discrepancy.h"
#include "kernels/mesh/bounds_tree.h"

namespace meander {

enum class Overlap : std::uint8_t { outside, inside, partial };

// The position of a node: `inside` and `outside` are certain, `partial` may be either. node: six doubles of
// BoundsTree.
inline Overlap overlap_of(const double* node, const RotatedBox& box) {
  const Vector3 offset = Vector3{node[0], node[1], node[2]} - box.center;
  bool inside = true;
  for (std::size_t k = 0; k < 3; ++k) {
    const Vector3& axis = box.axes[k];
    const double at = std::abs(dot(axis, offset));
    const double reach = std::abs(axis.x) * node[3] + std::abs(axis.y) * node[4] + std::abs(axis.z) * node[5];
    if (at - reach > box.half[k]) return Overlap::outside;
    inside = inside && at + reach <= box.half[k];
  }
  return inside ? Overlap::inside : Overlap::partial;
}

// Calls inside(begin, end) for runs of positions that lie wholly in the box and partial(begin, end) for runs
// of at most `leaf` positions that have to be looked at one by one. Positions of neither kind are outside.
template <class Inside, class Partial>
void visit_box(const BoundsTree& tree, const RotatedBox& box, const Inside& inside, const Partial& partial,
               std::size_t level, std::size_t node) {
  const Overlap overlap = overlap_of(tree.levels[level].data() + 6 * node, box);
  if (overlap == Overlap::outside) return;
  if (overlap == Overlap::partial && level > 0) {
    const std::size_t below = tree.levels[level - 1].size() / 6;
    for (std::size_t child = BoundsTree::fan * node; child < BoundsTree::fan * (node + 1) && child < below;
         ++child)
      visit_box(tree, box, inside, partial, level - 1, child);
    return;
  }
  std::size_t run = BoundsTree::leaf;
  for (std::size_t l = 0; l < level; ++l) run *= BoundsTree::fan;
  const std::size_t begin = node * run, end = std::min(tree.count(), begin + run);
  if (overlap == Overlap::inside)
    inside(begin, end);
  else
    partial(begin, end);
}

template <class Inside, class Partial>
void visit_box(const BoundsTree& tree, const RotatedBox& box, const Inside& inside, const Partial& partial) {
  if (tree.count() > 0) visit_box(tree, box, inside, partial, tree.levels.size() - 1, 0);
}

}  // namespace meander
