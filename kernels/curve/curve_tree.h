// Adaptive Hilbert, Peano and Peano-meander trees over the unit square (docs/METHODS.md 5.3).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "kernels/core/cancel.h"
#include "kernels/curve/curve_key.h"

namespace meander {

// The leaves of an adaptive tree, in curve order: flat arrays of equal length L. A leaf is the axis-parallel
// square with lower corner (u, v) and side `side`. Consecutive leaves share a border of positive length, the
// areas of the leaves sum to one, and `key` (the key of the leaf's first finest cell, see curve_key) ascends.
struct CurveTree {
  CurveKind kind = CurveKind::hilbert;
  std::vector<double> u, v;
  std::vector<double> side;
  std::vector<std::uint64_t> key;
  std::vector<std::uint8_t> depth;
  // The orientation of the curve in the leaf: a row of the frame table of `kind`.
  std::vector<std::uint8_t> frame;

  std::size_t leaf_count() const { return u.size(); }
};

// The undivided square: one leaf.
CurveTree curve_root(CurveKind kind);

// Splits every leaf with split[i] != 0 into its 4 or 9 children, in place in curve order; other leaves stay.
// Leaves at the finest level of curve_key are never split. `parent` (optional) receives for every new leaf
// the index of the old leaf that it comes from. O(L), data-parallel, deterministic.
CurveTree refine(const CurveTree& tree, std::span<const std::uint8_t> split,
                 std::vector<std::uint32_t>* parent = nullptr);

// The children of all leaves with split[i] != 0, alone and in curve order: one level of a tree that grows
// level by level without copying finished leaves. Leaves at the finest level have no children. O(L).
CurveTree children_of(const CurveTree& tree, std::span<const std::uint8_t> split);

// One level of a growing tree: its nodes in curve order, and which of them were split. The nodes of the next
// level are children_of(nodes, split).
struct CurveLevel {
  CurveTree nodes;
  std::vector<std::uint8_t> split;
};

// Joins the levels of a tree to its leaves in curve order: the nodes of all levels that were not split. The
// first level covers the square; the split flags of the last level are zero. O(nodes).
CurveTree join_levels(std::span<const CurveLevel> levels);

struct CurveParameters {
  CurveKind kind = CurveKind::hilbert;
  // kappa: a leaf is split while its mass > total / (kappa N); 1..256
  double leaves_per_sample = 2;
  // In Hilbert levels; Peano trees stop at 2/3 of it (a factor 3 a level instead of 2).
  int max_depth = 24;
};

// Bounds the number of leaves of a tree of total mass M whose leaves are split while their mass is above m,
// over M / m. Where masses are even, a leaf has between m and a child's share of m; some leaves are smaller.
constexpr double max_leaves_per_mass(CurveKind kind) { return kind == CurveKind::hilbert ? 4 : 10; }

// Converts a depth in Hilbert levels to levels of the kind: itself, or 2/3 of it rounded down; at most
// curve_key_levels(kind).
int curve_depth(CurveKind kind, int hilbert_levels);

// Builds a tree over the masses of triangles, gathered at their UV centroids. Leaves are split, level by
// level, while their gathered mass exceeds leaf_mass, and down to min_depth (in Hilbert levels) wherever the
// mass is positive. u, v: UV centroids of the triangles in [0, 1]; mass: their masses >= 0; uv_area: their UV
// areas, or empty where every mass is a point mass. A triangle larger than a leaf counts with the leaf's
// share of its mass only, so that the centroid of a large triangle does not force deep leaves. Throws timeout
// / RunCanceled from `cancel`. O(T + L log T) time, O(T + nodes) memory.
CurveTree build_curve_tree(std::span<const double> u, std::span<const double> v, std::span<const double> mass,
                           std::span<const double> uv_area, double leaf_mass, int min_depth,
                           const CurveParameters& parameters, const CancelToken& cancel = {});

}  // namespace meander
