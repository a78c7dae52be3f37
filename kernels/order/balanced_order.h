// Balanced bisection: an order of surface elements whose strata are compact cells of equal mass, for any
// number of samples (docs/METHODS.md 6.5).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "kernels/core/cancel.h"

namespace meander {

// Elements are numbered together with their parts.
inline constexpr std::size_t most_balanced_elements = std::size_t{1} << 29;

// One element of the surface: a small piece with a mass at a point.
struct MassPoint {
  float at[3];  // its centroid, in [-1, 1]^3; over a chart (u, v, 0)
  double mass;  // >= 0
};

// An element that small cells take apart: a piece of a triangle, and the pieces that its longest edge and
// then theirs bisect it into. Halves weigh the same.
struct ElementSplit {
  std::uint8_t levels = 0;   // 0 to 2: it has 2^levels parts
  float half[3] = {};        // from its centroid to that of its first half; to the second the other way
  float quarter[2][3] = {};  // from the centroid of either half to that of its first half
};

// What else is known of the elements. `split`, `normal` and `group` may be empty.
struct ElementTraits {
  std::span<const std::uint32_t> triangle;  // by element
  std::span<const ElementSplit> split;      // by element; empty: none is taken apart
  std::span<const float> normal;            // 3 a triangle, unit: tells the two sides of a thin plate apart
  std::span<const std::uint32_t> group;     // by triangle: all elements of one group come before the next
};

// E' entries in the order of the path: elements and parts of split ones. What a cut divides has an entry on
// either side, each with its share of the mass; E' is at most n - 1 more than all parts.
struct BalancedOrder {
  std::vector<std::uint32_t> element;  // E'
  std::vector<std::uint8_t> part;      // E': 1 the whole, 2 and 3 its halves, 4 to 7 their halves
  std::vector<double> cumulative;      // E' + 1: mass before each entry; the last is the total
};

// Orders the elements so that the k-th of n equal shares of the mass is one compact cell. A node that holds
// s of the n shares is cut across the largest extent of its elements' centroids at floor(s / 2) / s of its
// mass, down to cells of one share. The path takes the half first that makes it shorter, seen from where it
// comes from and where it goes on to, and the elements of a cell follow the direction in which it passes. A
// node that is a thin stack of sheets is cut between sheets instead: by the side that they face, then by
// height. Nodes of at most 16 shares take their elements by halves, those of at most 8 by all parts; what a
// cut above has divided stays whole. Masses are added as integers (2^-61 of the power of two above the
// total), so every cut is exact and no sum depends on its order; ties are broken by the place in the list of
// the node. Pure, the same for every thread count. O(E log n), about 5 ns an element and level, and three
// levels more for its parts; 100 bytes an element and 190 a sample, most of them at the peak, and 37 an
// entry. Throws std::invalid_argument when n is 0 or no element has mass, or for more than 2^29 elements.
BalancedOrder balanced_order(std::span<const MassPoint> elements, std::uint32_t n,
                             const ElementTraits& traits = {}, const CancelToken& cancel = {});

}  // namespace meander
