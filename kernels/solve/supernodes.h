// The structure of a sparse triangular factor, found before any value is computed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "kernels/solve/elimination_order.h"

namespace meander {

// Columns of the factor with (nearly) the same rows below them form a supernode, whose panel is dense. Both
// sparse solvers eliminate supernode by supernode: the front of one holds its own columns and all rows below.
// Its rest after elimination, the update matrix, goes to the front of its parent (Duff and Reid 1983; Liu
// 1992). The structure is that of the Cholesky factor of a matrix with a symmetric pattern.
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
  // Multiplications and additions of an LU factorization of the panels; Cholesky needs half of them.
  std::uint64_t elimination_work() const;
};

// Units of WorkBudget for ordering, structure and assembly of each unknown of a mesh matrix. The
// factorization itself takes elimination_work().
inline constexpr std::uint64_t work_per_unknown = 1024;

// The strictly lower triangle of a matrix by columns, in the order of elimination; unsorted, repeats stay.
struct LowerTriangle {
  std::vector<std::uint32_t> begin, row;
  std::vector<double> value;
};

// Refines `order` so that subtrees of the elimination tree, and with them supernodes, are contiguous. The
// graph must be symmetric. Also returns the elimination tree in the new order: parent > child, or none. O(n +
// edges) up to a logarithm.
struct Elimination {
  std::vector<std::uint32_t> unknown;  // column of the factor -> unknown
  std::vector<std::uint32_t> place;    // unknown -> column of the factor
  std::vector<std::uint32_t> tree;
};
Elimination order_by_subtrees(const UnknownGraph& graph, std::span<const std::uint32_t> order);

// The supernodes of a matrix with this lower triangle, of which only the pattern is read. Columns are joined
// where that adds few zeros. O(entries of the factor's structure).
Supernodes find_supernodes(const LowerTriangle& lower, Elimination elimination);

// The largest total of `entries(s)` over the supernodes whose update matrices wait for their parents, while
// supernodes are eliminated in turn.
template <class Entries>
std::size_t max_waiting(const Supernodes& nodes, const Entries& entries) {
  std::vector<std::size_t> waiting;
  std::size_t held = 0, max = 0;
  for (std::size_t s = 0; s < nodes.count(); ++s) {
    while (!waiting.empty() && nodes.parent[waiting.back()] == s) {
      held -= entries(waiting.back());
      waiting.pop_back();
    }
    if (nodes.parent[s] == Supernodes::none) continue;
    waiting.push_back(s);
    held += entries(s);
    if (held > max) max = held;
  }
  return max;
}

// The update matrices of eliminated supernodes that their parents have not yet taken: a stack with the last
// one on top. `entries(s)` is the size of the update matrix of s.
template <class Entries>
class WaitingUpdates {
 public:
  WaitingUpdates(const Supernodes& nodes, const Entries& entries)
      : nodes_(nodes), entries_(entries), local_(nodes.place.size(), 0) {
    stack_.reserve(max_waiting(nodes, entries));
  }

  // Returns the rows of the front of s; place() gives their positions in it from now on.
  std::span<const std::uint32_t> begin_front(std::size_t s) {
    const std::span<const std::uint32_t> rows = nodes_.rows_of(s);
    for (std::size_t i = 0; i < rows.size(); ++i) local_[rows[i]] = static_cast<std::uint32_t>(i);
    return rows;
  }
  std::uint32_t place(std::uint32_t row) const { return local_[row]; }

  // Calls add(places, update) for the update matrix of every child of s and removes it; places: the positions
  // of its rows in the front.
  template <class Add>
  void take(std::size_t s, const Add& add) {
    while (!waiting_.empty() && nodes_.parent[waiting_.back()] == s) {
      const std::uint32_t child = waiting_.back();
      waiting_.pop_back();
      const std::span<const std::uint32_t> below = nodes_.rows_of(child).subspan(nodes_.columns(child));
      places_.resize(below.size());
      for (std::size_t i = 0; i < below.size(); ++i) places_[i] = local_[below[i]];
      const std::size_t begin = stack_.size() - entries_(child);
      add(std::span<const std::uint32_t>(places_), stack_.data() + begin);
      stack_.resize(begin);
    }
  }

  // Begins the update matrix of s, to which append() adds columns; false at roots, which have none.
  bool put(std::uint32_t s) {
    if (nodes_.parent[s] == Supernodes::none) return false;
    waiting_.push_back(s);
    return true;
  }
  void append(const double* begin, const double* end) { stack_.insert(stack_.end(), begin, end); }

 private:
  const Supernodes& nodes_;
  const Entries& entries_;
  std::vector<double> stack_;
  std::vector<std::uint32_t> local_;    // row -> position in the front
  std::vector<std::uint32_t> waiting_;  // supernodes whose update matrices are on the stack
  std::vector<std::uint32_t> places_;
};

}  // namespace meander
