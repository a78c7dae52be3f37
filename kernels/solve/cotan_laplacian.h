// The cotangent Laplacian of a disk with fixed boundary values.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "kernels/solve/intrinsic_disk.h"
#include "kernels/solve/sparse_cholesky.h"

namespace meander {

// A = positive semi-definite cotangent Laplacian over all V vertices: A_ij = -(cot a + cot b) / 2. Only edge
// weights are stored; A_II is assembled for the factorization.
class DirichletLaplacian {
 public:
  // Factorizes A_II by sparse Cholesky, with work out of `budget`. half_cotangent: 3 T as in CornerGeometry,
  // freed before the factorization; on_boundary: V flags. O(V^1.5). Throws timeout / RunCanceled.
  DirichletLaplacian(const IntrinsicDisk& disk, std::vector<double> half_cotangent,
                     std::span<const std::uint8_t> on_boundary, const CancelToken& cancel,
                     WorkBudget* budget = nullptr);

  // False when the factorization met a pivot that is not positive (rounding), or the budget did not suffice;
  // solve() must not be called then.
  bool factorized() const { return factorized_; }

  // x_I = A_II^-1 (b_I - A_IB x_B) for V values: boundary entries of x are read, interior ones written.
  // O(factor).
  void solve(std::span<const double> b, std::span<double> x) const;
  // x_I = -A_II^-1 A_IB x_B, and the same for y, in one pass over the factor.
  void extend_harmonically(std::span<double> x, std::span<double> y) const;
  // (A x) at boundary vertices, 0 elsewhere: V values.
  std::vector<double> apply_at_boundary(std::span<const double> x) const;

  // Interior vertices in the order of elimination, for IntrinsicDisk::elimination of a similar disk.
  std::vector<std::uint32_t> elimination() const;

 private:
  // An edge between an interior and a boundary vertex, or along the boundary.
  struct RimEdge {
    std::uint32_t from, to;  // `to` lies on the boundary
    double weight;
  };
  void number_unknowns(std::span<const std::uint8_t> on_boundary);
  GraphMatrix interior_matrix(std::span<const double> half_cotangent);
  void find_order(const UnknownGraph& graph);
  void add_rim(std::span<const double> x, std::span<double> right) const;

  const IntrinsicDisk& disk_;
  std::vector<std::uint32_t> unknown_;  // V: index among the interior vertices, no_index on the boundary
  std::vector<std::uint32_t> vertex_;   // interior vertices
  std::vector<std::uint32_t> order_;    // unknowns in the order of elimination
  std::vector<RimEdge> rim_;
  SparseCholesky cholesky_;
  bool factorized_ = false;
};

}  // namespace meander
