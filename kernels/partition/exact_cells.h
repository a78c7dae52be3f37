// Cells of balanced bisection that are cut exactly out of triangles, and their samples (docs/METHODS.md 6.5,
// "Exact cells", and 7.7).
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "kernels/core/cancel.h"
#include "kernels/partition/balanced_order.h"
#include "kernels/partition/clipped_pieces.h"
#include "kernels/partition/cut_history.h"
#include "kernels/partition/cut_tree.h"

namespace meander {

// The entries of a cell.
struct EntryRange {
  std::uint32_t block = 0, count = 0;
  std::size_t first = 0;
};

struct ExactCells {
  CutTree tree;
  std::vector<CutHistory> history;            // by cell, in the order of the tree
  std::vector<CellPoint> point;               // likewise, or none where polygons are kept:
  std::vector<EntryRange> entries;            // likewise
  std::vector<std::vector<CellEntry>> block;  // by first cell, some empty
  std::vector<CellPolygons> polygon;          // likewise
};

// Cuts triangles of even mass into n cells, and gives each its point of the net, or its polygons
// (exact_order). Returns nullopt where there are more than max_polygons. `traits` has neither splits nor
// groups; `total` > 0 is the sum of the masses. Pure; the same for every thread count. O(E log n + n) clips.
std::optional<ExactCells> cut_exactly(std::span<const MassPoint> elements, double total, std::uint32_t n,
                                      const ElementTraits& traits, const ExactTriangles& exact,
                                      const CancelToken& cancel);

}  // namespace meander
