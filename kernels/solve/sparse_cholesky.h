// Sparse Cholesky factorization for symmetric positive definite matrices with the graph of a mesh.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <vector>

#include "kernels/core/cancel.h"
#include "kernels/core/portable_functions.h"
#include "kernels/core/work_budget.h"
#include "kernels/solve/elimination_order.h"
#include "kernels/solve/supernodes.h"

namespace meander {

// Upper bound of the entries of the factor of a planar mesh under minimum degree.
inline double most_factor_entries(double vertices) {
  return 2.0 * vertices * std::max(4.0, portable::log2(vertices + 1));
}

// Calls solve<Count>() for a number of right-hand sides that are solved for together: count = 1, 2, 4, 8 or
// 16, otherwise throws std::invalid_argument.
template <class Solve>
void at_width(std::size_t count, const Solve& solve) {
  switch (count) {
    case 1:
      return solve.template operator()<1>();
    case 2:
      return solve.template operator()<2>();
    case 4:
      return solve.template operator()<4>();
    case 8:
      return solve.template operator()<8>();
    case 16:
      return solve.template operator()<16>();
    default:
      throw std::invalid_argument("solve_many: count must be 1, 2, 4, 8 or 16");
  }
}

// A = L L^T by supernodes, multifrontal (Duff and Reid 1983; Liu 1992). Everything is sequential and
// deterministic. Memory: the factor, the lower triangle of A and the stack of update matrices, which for a
// mesh is a third of the factor.
class SparseCholesky {
 public:
  // `values` beside graph.neighbors holds the entries off the diagonal (repeats are added, no vertex is its
  // own neighbor), `diagonal` those on it. The elimination order starts from `order` and is refined so that
  // supernodes are contiguous. O(n^1.5) for planar graphs. Throws timeout / RunCanceled.
  void factorize(const UnknownGraph& graph, std::span<const double> values, std::span<const double> diagonal,
                 std::span<const std::uint32_t> order, const CancelToken& cancel = {});
  // The same; the memory of `matrix` is freed before the factor is made. The work, known from the structure,
  // is taken out of `budget` first; where it does not suffice, no factor is made.
  void factorize(GraphMatrix&& matrix, std::span<const std::uint32_t> order, const CancelToken& cancel = {},
                 WorkBudget* budget = nullptr);

  // False when a pivot was not positive (the matrix is not positive definite, up to rounding) or the budget
  // did not suffice.
  bool succeeded() const { return succeeded_; }
  std::size_t factor_entries() const { return panel_.size(); }

  // x = A^-1 b in place, for one or two right-hand sides at once. O(factor_entries()).
  void solve(std::span<double> b) const;
  void solve(std::span<double> b, std::span<double> c) const;
  // The same for `count` right-hand sides stored side by side: entry i of number c at b[i * count + c]. count
  // = 1, 2, 4, 8 or 16, otherwise std::invalid_argument. Each solution is, bit for bit, that of solve(b).
  // Many at once are cheaper, because the factor is read once.
  void solve_many(std::span<double> b, std::size_t count) const;

 private:
  struct Permuted {
    LowerTriangle lower;
    std::vector<double> diagonal;
  };
  Permuted analyse(const UnknownGraph& graph, std::span<const double> values,
                   std::span<const double> diagonal, std::span<const std::uint32_t> order);
  void factorize(const Permuted& matrix, const CancelToken& cancel);
  template <int Count>
  void solve_permuted(double* x) const;
  template <int Count>
  void solve_rows(double* x) const;
  template <int Count>
  void solve_interleaved(std::span<double> b) const;

  Supernodes nodes_;
  std::vector<std::size_t> panel_begin_;  // supernodes + 1 offsets into panel_
  std::vector<double> panel_;             // rows x columns of every supernode, by columns
  bool succeeded_ = false;
};

}  // namespace meander
