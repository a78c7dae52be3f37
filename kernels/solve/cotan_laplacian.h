// The cotangent Laplacian of a disk with its boundary values fixed.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "kernels/solve/intrinsic_disk.h"
#include "kernels/solve/sparse_cholesky.h"

namespace meander {

// A = positive semi-definite cotangent Laplacian over all vertices: A_ij = -(cot a + cot b) / 2. Only edge
// weights are stored; A_II is assembled for the factorisation.
class DirichletLaplacian {
 public:
  // Half cotangents per half-edge as in CornerGeometry, given back before the factorisation. `on_boundary`
  // per vertex. Factorises A_II by sparse Cholesky, with work out of `budget`. O(V^1.5). Throws timeout /
  // RunCancelled.
  DirichletLaplacian(const IntrinsicDisk& disk, std::vector<double> half_cotangent,
                     std::span<const std::uint8_t> on_boundary, const CancelToken& cancel,
                     WorkBudget* budget = nullptr);

  // False when the factorisation met a pivot that is not positive (rounding), or the budget did not suffice:
  // solve() must not be called.
  bool factorised() const { return factorised_; }

  // x_I = A_II^-1 (b_I - A_IB x_B): V values in, boundary entries of x are read, interior ones written.
  void solve(std::span<const double> b, std::span<double> x) const;
  // Both x_I = -A_II^-1 A_IB x_B and the same for y, in one pass over the factor.
  void extend_harmonically(std::span<double> x, std::span<double> y) const;
  // (A x) at boundary vertices, 0 elsewhere: V values.
  std::vector<double> apply_at_boundary(std::span<const double> x) const;

  // Interior vertices in the order of elimination, for IntrinsicDisk::elimination of a like disk.
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
  std::vector<std::uint32_t> unknown_;  // V: number among the interior vertices, no_index on the boundary
  std::vector<std::uint32_t> vertex_;   // interior vertices
  std::vector<std::uint32_t> order_;    // unknowns in the order of elimination
  std::vector<RimEdge> rim_;
  SparseCholesky cholesky_;
  bool factorised_ = false;
};

}  // namespace meander
