// Where in their cells the samples of the sequence `shifted` lie: a digital net over the tree of balanced
// bisection, under one random shift (docs/METHODS.md 7.7).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "kernels/order/balanced_order.h"
#include "kernels/order/net_digits.h"

namespace meander {

// Arrays of one thread, reused from cell to cell.
struct CellNetScratch {
  std::vector<std::uint64_t> mass;  // by entry: what is left of it
  std::vector<std::uint64_t> row;   // entries by a coordinate
};

// The entry that the sample of the cell lies in. Two digits of the net say which quarter of the cell's mass
// along its largest extent; along the second largest, the share of that quarter has two digits of the net and
// then those of `choice` in [0, 1). Over all shifts and choices every entry is selected with the probability
// of its share of the mass. Returns a reference into `cells`. Pure. O(P) expected for P entries.
const CellEntry& entry_in_net(const BalancedCells& cells, const Cell& cell, const DigitalShift& shift,
                              double choice, CellNetScratch& scratch);

// order[i] = rank of the cell of the i-th sample of the file: a permutation whose first 2^k ranks have one in
// each of 2^k nodes of the tree (ranges of its leaves, where sheets are not parted in halves), as
// progressive_order has in blocks of ranks; but which leaf stands for a node follows from the digits of the
// net instead of one mask for all. Over all keys every cell is the first one equally often, independently of
// where its sample lies. Pure. O(n log n), 100 bytes a cell.
std::vector<std::uint32_t> cell_net_order(const BalancedCells& cells, RandomKey key);

}  // namespace meander
