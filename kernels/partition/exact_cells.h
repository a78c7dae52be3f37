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

// Cuts triangles of even mass (traits.exact) into n cells, and gives each its point of the net, or keeps its
// polygons. None where there are more than may be kept. `traits` has neither splits nor groups; `total` > 0
// is the sum of the masses. Pure, the same for every thread count. About 80 ns a clip, of which a cell takes
// 2 (large triangles) to 9 (6 triangles a cell); 750 bytes an element, 1,200 from 4,096 cells
// on, and 64 a kept polygon.
std::optional<ExactCells> cut_exactly(std::span<const MassPoint> elements, double total, std::uint32_t n,
                                      const ElementTraits& traits, const CancelToken& cancel);

}  // namespace meander
