// Sparse LU factorization for diagonally dominant matrices with the graph of a mesh.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "kernels/core/cancel.h"
#include "kernels/core/work_budget.h"
#include "kernels/solve/supernodes.h"

namespace meander {

// A = L U by supernodes, multifrontal, without pivoting: stable for matrices whose rows or columns are
// diagonally dominant, such as mean-value equations (Golub and Van Loan 2013, section 4.1). The pattern must
// be symmetric, the values need not be. Sequential and deterministic. Memory: twice that of a Cholesky
// factor.
class SparseLu {
 public:
  // Frees the memory of `matrix` before the factors are made. The work, known from the structure, is taken
  // out of `budget` first. Returns false when a pivot is 0 or not finite, or the budget does not suffice;
  // solve() must not be called then. O(n^1.5) for planar graphs. Throws timeout / RunCanceled.
  bool factorize(GraphMatrix&& matrix, std::span<const std::uint32_t> order, const CancelToken& cancel = {},
                 WorkBudget* budget = nullptr);

  // x = A^-1 b in place, for two right-hand sides at once.
  void solve(std::span<double> b, std::span<double> c) const;

 private:
  struct Triangles {
    std::vector<double> diagonal;
    LowerTriangle lower, upper;  // `upper` is transposed: the rows of A above the diagonal
  };
  Triangles analyse(const GraphMatrix& matrix, std::span<const std::uint32_t> order);

  Supernodes nodes_;
  std::vector<std::size_t> left_begin_, right_begin_;  // supernodes + 1 offsets
  // rows x columns of every supernode, by columns: L, with the diagonal block of U above.
  std::vector<double> left_;
  // (rows below) x columns, by columns: U to the right of the block, transposed.
  std::vector<double> right_;
};

}  // namespace meander
