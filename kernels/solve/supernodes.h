// The structure of a sparse triangular factor, found before any number is computed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "kernels/solve/elimination_order.h"

namespace meander {

// Columns of the factor with (nearly) the same rows below them form a supernode, whose panel is dense. Both
// sparse solvers eliminate supernode by supernode: the front of one holds its own columns and all rows below,
// and what remains after elimination, its update matrix, goes to the front of its parent (Duff and Reid 1983;
// Liu 1992). The structure is that of the Cholesky factor of a matrix with a symmetric pattern.
struct Supernodes {
  static constexpr std::uint32_t none = 0xFFFFFFFFu;

  std::vector<std::uint32_t> place;    // unknown -> column of the factor
  std::vector<std::uint32_t> first;    // S + 1: first column
  std::vector<std::uint32_t> parent;   // S: supernode above, `none` at roots
  std::vector<std::size_t> row_begin;  // S + 1 offsets into rows
  std::vector<std::uint32_t> rows;     // rows of a supernode's panel, ascending, its own columns first

  std::size_t count() const { return parent.size(); }
  std::size_t columns(std::size_t s) const { return first[s + 1] - first[s]; }
  std::size_t row_count(std::size_t s) const { return row_begin[s + 1] - row_begin[s]; }
  std::size_t rows_below(std::size_t s) const { return row_count(s) - columns(s); }
  std::span<const std::uint32_t> rows_of(std::size_t s) const {
    return std::span(rows).subspan(row_begin[s], row_count(s));
  }
};

// The strictly lower triangle of a matrix by columns, in the order of elimination; unsorted, repeats stay.
struct LowerTriangle {
  std::vector<std::uint32_t> begin, row;
  std::vector<double> value;
};

// Refines `order` so that subtrees of the elimination tree, and with them supernodes, are contiguous. The
// graph must be symmetric. Returns the elimination tree in the new order too: parent > child, or none.
struct Elimination {
  std::vector<std::uint32_t> unknown;  // column of the factor -> unknown
  std::vector<std::uint32_t> place;    // unknown -> column of the factor
  std::vector<std::uint32_t> tree;
};
Elimination order_by_subtrees(const UnknownGraph& graph, std::span<const std::uint32_t> order);

// Supernodes of a matrix with this lower triangle (only its pattern is read). Columns are joined where few
// zeros come in. O(entries of the factor's structure).
Supernodes find_supernodes(const LowerTriangle& lower, Elimination elimination);

// The largest total, while supernodes are eliminated in turn, of `entries(s)` over the supernodes whose
// update matrices wait for their parents.
template <class Entries>
std::size_t most_waiting(const Supernodes& nodes, const Entries& entries) {
  std::vector<std::size_t> waiting;
  std::size_t held = 0, most = 0;
  for (std::size_t s = 0; s < nodes.count(); ++s) {
    while (!waiting.empty() && nodes.parent[waiting.back()] == s) {
      held -= entries(waiting.back());
      waiting.pop_back();
    }
    if (nodes.parent[s] == Supernodes::none) continue;
    waiting.push_back(s);
    held += entries(s);
    if (held > most) most = held;
  }
  return most;
}

}  // namespace meander
