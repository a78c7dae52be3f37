// The exact masses of curve leaves: the slow reference of the locators.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "kernels/curve/curve_tree.h"
#include "kernels/flatten/flatten_chart.h"

namespace meander::test {

// Fragments of leaf i: triangle[begin[i]] .. triangle[begin[i + 1] - 1] (ascending) with their masses.
struct ClipTree {
  std::vector<std::size_t> begin;       // L + 1
  std::vector<std::uint32_t> triangle;  // of the chart
  std::vector<double> mass;             // of the part of the triangle in the leaf
  std::vector<double> leaf_mass;        // L

  double mass_in_leaf(std::size_t leaf, std::uint32_t t) const;
};

// Clips every triangle against the cells of a Hilbert tree (Sutherland and Hodgman 1974, in double), from the
// root down: a cell that is a leaf keeps its polygons. mass[t] is spread evenly over triangle t; triangles
// without UV area go whole into the leaf of their centroid. Overlapping and flipped triangles all count.
ClipTree clip_tree(const CurveTree& tree, const FlatChart& chart, std::span<const double> mass);

}  // namespace meander::test
