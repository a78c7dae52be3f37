// The balanced order: an equal-mass k-d tree over surface elements, whose leaves are compact cells of equal
// mass for any number of samples (docs/METHODS.md 6.5).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "kernels/core/cancel.h"
#include "kernels/core/random.h"
#include "kernels/core/vector3.h"
#include "kernels/partition/clipped_pieces.h"
#include "kernels/partition/cut_history.h"
#include "kernels/partition/cut_tree.h"
#include "kernels/partition/net_digits.h"

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
  std::uint8_t levels = 0;   // 1 or 2: it has 2^levels parts; 0: it stays whole
  float half[3] = {};        // from its centroid to that of its first half; to the second the other way
  float quarter[2][3] = {};  // from the centroid of either half to that of its first half
};

// Elements that are triangles of even mass, out of which cells are cut exactly (docs/METHODS.md 6.5).
struct ExactTriangles {
  std::function<std::array<Vector3, 3>(std::uint32_t element)> corners;  // `at` is their centroid
  RandomKey key;
  std::uint64_t first_cell = 0;  // the number of cell 0 among those of the key
  // 0: every cell gets its point of the net (docs/METHODS.md 7.7). Otherwise every cell keeps the polygons
  // that it is made of, and there are no cells where that takes more polygons than this.
  std::uint64_t max_polygons = 0;
};

// The elements that are taken apart; all others stay whole.
struct ElementSplits {
  std::span<const std::uint32_t> element;  // their numbers, ascending
  std::span<const ElementSplit> split;     // of each
  bool empty() const { return element.empty(); }
};

// What else is known of the elements. `splits`, `normal` and `group` may be empty.
struct ElementTraits {
  std::span<const std::uint32_t> triangle;  // by element
  ElementSplits splits;
  std::span<const float> normal;         // 3 a triangle, unit: tells the two sides of a thin plate apart
  std::span<const std::uint32_t> group;  // by triangle: all elements of one group come before the next
};

// An element, a part of a split one, or, where a cut divides it, a share of the mass of either.
struct CellEntry {
  float at[3];         // its centroid
  std::uint32_t name;  // element and part
  std::uint64_t mass;  // in units
  std::uint32_t element() const { return name >> 3; }
  std::uint32_t part() const { return name & 7; }  // 1 the whole, 2 and 3 its halves, 4 to 7 their halves
};

// One of the n cells: entries of a block, and the direction in which the path passes it.
struct Cell {
  std::uint32_t block, entries;
  std::size_t first;
  std::array<float, 3> direction;  // 0: the entries are in order
  std::uint32_t leaf;              // its number in the tree
  CutHistory history;
};

// The convex polygons that the entries of a block are, by the weights of corners 1 and 2 of their triangles.
struct CellPolygons {
  std::vector<std::uint32_t> end;  // by entry: where its corners end, which begin where those before end
  std::vector<std::array<float, 2>> corner;
  std::span<const std::array<float, 2>> operator[](std::size_t entry) const {
    const std::uint32_t begin = entry > 0 ? end[entry - 1] : 0;
    return std::span(corner).subspan(begin, end[entry] - begin);
  }
};

// The cells in the order of the path. At most n - 1 more entries than all parts.
struct BalancedCells {
  std::vector<Cell> cell;                     // n
  std::vector<std::vector<CellEntry>> block;  // some empty
  std::vector<CellPoint> point;               // n in place of entries, where net points were asked for;
                                              // their names are elements
  std::vector<CellPolygons> polygon;          // of each block, where exact cells keep theirs; else none
  // Cuts by node of the tree, depth first: a node is followed by the 2 c - 1 nodes of its low half, which has
  // c leaves, then by those of its high half. Leaves have no cut.
  std::vector<TreeCut> cut;
  std::array<double, 2> unit{};  // of masses: factors, as their product may be out of range
  std::span<const CellEntry> entries(const Cell& c) const {
    return std::span(block[c.block]).subspan(c.first, c.entries);
  }
  double mass(const CellEntry& entry) const { return static_cast<double>(entry.mass) * unit[0] * unit[1]; }
};

// Orders the elements by an equal-mass k-d tree of n leaves, so that the k-th of n equal shares of the mass
// is one compact cell.
//
// - A node of s shares is cut across the largest extent of its elements' centroids, with lower_leaves(s) of
//   them below the cut. A node that is a thin stack of sheets is cut between the sheets instead: by the side
//   that they face, then by height.
// - The path visits the children in the order that makes it shorter, given the nodes before and after it. The
//   elements of a cell follow the direction in which the path passes it.
// - Nodes of at most 64 shares divide split elements into halves, nodes of at most 16 shares into all their
//   parts. An element that a cut has already divided is not split again.
// - Masses are integers (2^-61 of the power of two above the total): cuts are exact, and sums do not depend
//   on their order. The place in the node's list breaks ties.
//
// `shares`: 0 stands for n. Otherwise at least n, below 2^32: the mass has this many equal shares, and cell k
// of the tree holds those from floor(k shares / n) to floor((k + 1) shares / n).
//
// Pure; the same for every thread count. O(E log n); frees the elements once they have been read. Throws
// std::invalid_argument for n = 0, elements without mass, more than 2^29 elements, or traits of other
// elements.
BalancedCells balanced_order(std::vector<MassPoint> elements, std::uint32_t n,
                             const ElementTraits& traits = {}, const CancelToken& cancel = {},
                             std::uint64_t shares = 0);

// The same order with exact cells: triangles are clipped at the planes of the cuts, and cells are of equal
// mass to 2^-12. Returns nullopt where cells would keep more than max_polygons. Throws what balanced_order
// throws, and std::invalid_argument for traits with splits or groups.
std::optional<BalancedCells> exact_order(std::span<const MassPoint> elements, std::uint32_t n,
                                         const ElementTraits& traits, const ExactTriangles& exact,
                                         const CancelToken& cancel = {});

// The entry that holds `share` (in [0, 1]) of a cell's mass along the direction of the path, never one
// without mass; entries follow each other by their centroids, those in one place by number. `scratch` is
// overwritten. Pure. O(P) for P entries.
const CellEntry& entry_at(const BalancedCells& cells, const Cell& cell, double share,
                          std::vector<std::uint64_t>& scratch);
// All of them in that order: numbers in `cells.entries(cell)`. O(P log P).
void order_entries(const BalancedCells& cells, const Cell& cell, std::vector<std::uint32_t>& order);

}  // namespace meander
