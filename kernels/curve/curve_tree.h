// Adaptive Hilbert, Peano and Peano-meander trees over the unit square (ALGORITHMS sections 4.1 and 4.2).
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "kernels/core/cancel.h"
#include "kernels/curve/curve_key.h"

namespace meander {

// The leaves of an adaptive tree, in curve order: flat arrays of equal length L. A leaf is the axis-parallel
// square with lower corner (u, v) and side `side`; consecutive leaves share a border of positive length, the
// leaf areas sum to one, and `key` (the key of the leaf's first finest cell, see curve_key) ascends.
struct CurveTree {
  CurveKind kind = CurveKind::hilbert;
  std::vector<double> u, v;
  std::vector<double> side;
  std::vector<std::uint64_t> key;
  std::vector<std::uint8_t> depth;
  std::vector<std::uint8_t>
      frame;  // orientation of the curve in the leaf, an index into the table of the kind

  std::size_t leaf_count() const { return u.size(); }
};

// The undivided square: one leaf.
CurveTree curve_root(CurveKind kind);

// Splits every leaf with split[i] != 0 into its 4 or 9 children, in place in curve order; others stay. Leaves
// at the finest level of curve_key are never split. `parent` (optional) receives for every new leaf the
// number of the old leaf it comes from. O(L) data-parallel, deterministic.
CurveTree refine(const CurveTree& tree, std::span<const std::uint8_t> split,
                 std::vector<std::uint32_t>* parent = nullptr);

struct CurveParameters {
  CurveKind kind = CurveKind::hilbert;
  double leaves_per_sample = 2;  // kappa: a leaf is split while its mass > total / (kappa N); 1..256
  int max_depth = 24;  // of Hilbert levels; Peano trees stop at 2/3 of it (a factor 3 a level instead of 2)
};

// The tree of build_curve: the masses of the triangles gathered at their UV centroids; leaves are split,
// level by level, while their gathered mass exceeds leaf_mass, and down to min_depth where there is any mass
// at all. u, v: UV centroids of the triangles; mass: their masses. O(T log T + L).
CurveTree build_curve_tree(std::span<const double> u, std::span<const double> v, std::span<const double> mass,
                           double leaf_mass, int min_depth, const CurveParameters& parameters,
                           const CancelToken& cancel = {});

}  // namespace meander
