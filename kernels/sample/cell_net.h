// Where in their cells the samples of the sequence `shifted` lie: a digital net over the tree of balanced
// bisection, under one random shift (docs/METHODS.md 7.7).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "kernels/partition/balanced_order.h"
#include "kernels/partition/net_digits.h"

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

// Where the sample of the cell of that rank lies, in any unit.
using SamplePlace = std::function<std::array<float, 3>(std::uint32_t rank)>;

// order[i] = rank of the cell of the i-th sample of the file. Where cells are 2^k, the first 2^j ranks have
// one in each of 2^j nodes of the tree, and which one follows from the digits of the net. Nodes that are not
// cut in halves are bisected anew for it, by the places of their samples, into halves of equal numbers (of an
// odd one, up to one): the first 2^j ranks have one in each of 2^j such parts. Between sheets and between
// groups samples are taken in proportion. Given where the samples lie, over all keys every one is the first
// equally often. Pure. O(n log n), 40 bytes a cell.
std::vector<std::uint32_t> cell_net_order(const BalancedCells& cells, RandomKey key,
                                          const SamplePlace& place);

}  // namespace meander
