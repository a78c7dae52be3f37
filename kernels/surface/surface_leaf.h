// Leaves of the curve over a parametric surface, found by their position along it.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "kernels/surface/patch_tree.h"

namespace meander {

// A leaf in the curve's square.
struct SurfaceLeaf {
  double s = 0, t = 0, side = 0;
  double bound = 0;  // on the measure per unit of the square, for rejection
};

inline constexpr double bound_margin = 1.1;
// A draw is accepted with a probability near 1 on smooth surfaces. This many misses mean a leaf whose measure
// sits in a spot that the quadrature hit and hardly any draw hits.
inline constexpr std::uint32_t max_trials = 1000;

inline SurfaceLeaf leaf_of(const PatchTree& tree, std::size_t patch, const PatchNode& node) {
  const CurveTree& patches = tree.patches();
  const double side = patches.side[patch];
  return {patches.u[patch] + side * node.s, patches.v[patch] + side * node.t, side * node.side,
          bound_margin * tree.bound(patch, node)};
}

// The leaf at a position in [0, total) along the curve: half-open, and never in a patch without mass.
// O(log patches + depth).
inline SurfaceLeaf leaf_at(const PatchTree& tree, double position) {
  const std::vector<double>& sums = tree.cumulative();
  const auto above = std::upper_bound(sums.begin() + 1, sums.end(), position);
  std::size_t patch =
      std::min(static_cast<std::size_t>(above - sums.begin()) - 1, tree.patches().leaf_count() - 1);
  while (patch > 0 && !(sums[patch + 1] > sums[patch])) --patch;
  return leaf_of(tree, patch, tree.find_leaf(patch, std::max(0.0, position - sums[patch])));
}

}  // namespace meander
