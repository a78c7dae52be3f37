// Balanced bisection: an order of surface elements whose strata are compact cells of equal mass, for any
// number of samples (docs/METHODS.md 6.5).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "kernels/core/cancel.h"

namespace meander {

// One element of the surface: a small piece with a mass at a point.
struct MassPoint {
  float at[3];            // its centroid, in [-1, 1]^3; over a chart (u, v, 0)
  std::uint32_t element;  // its number, which names it in the result
  double mass;            // >= 0
};

// What else is known of the elements. `normal` and `group` may be empty.
struct ElementTraits {
  std::span<const std::uint32_t> triangle;  // by element number
  std::span<const float> normal;            // 3 a triangle, unit: tells the two sides of a thin plate apart
  std::span<const std::uint32_t> group;     // by triangle: all elements of one group come before the next
};

// E' entries in the order of the path. An element that a cut divides has an entry on either side, each with
// its share of the mass; E' <= E + n - 1.
struct BalancedOrder {
  std::vector<std::uint32_t> element;  // E' numbers of elements
  std::vector<double> cumulative;      // E' + 1: mass before each entry; the last is the total
};

// Orders the elements so that the k-th of n equal shares of the mass is one compact cell. A node that holds
// s of the n shares is cut across the largest extent of its elements' centroids at floor(s / 2) / s of its
// mass, down to cells of one share. The path takes the half first that makes it shorter, seen from where it
// comes from and where it goes on to, and the elements of a cell follow the direction in which it passes. A
// node that is a thin stack of sheets is cut between sheets instead: by the side that they face, then by
// height. Masses are added as integers (2^-61 of the total), so every cut is exact and no sum depends on its
// order; ties are broken by the order of the input. Pure, the same for every thread count. O(E log n), about
// 6 ns an element and level; 60 bytes an element and 60 a sample. Throws std::invalid_argument when n is 0 or
// no element has mass.
// The elements are taken over, so that their memory is free while the tree is built.
BalancedOrder balanced_order(std::vector<MassPoint>&& elements, std::uint32_t n,
                             const ElementTraits& traits = {}, const CancelToken& cancel = {});

}  // namespace meander
