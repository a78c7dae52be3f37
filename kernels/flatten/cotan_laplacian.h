// The cotangent Laplacian of a disk with its boundary values fixed.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "kernels/flatten/intrinsic_disk.h"

namespace meander {

// A = positive semi-definite cotangent Laplacian over all vertices: A_ij = -(cot a + cot b) / 2. Only edge
// weights are stored; A_II is assembled for the factorisation.
class DirichletLaplacian {
 public:
  // Half cotangents per half-edge as in CornerGeometry. `on_boundary` per vertex. Factorises A_II (sparse
  // Cholesky, approximate minimum degree ordering). O(V^1.5). Throws timeout / RunCancelled.
  DirichletLaplacian(const IntrinsicDisk& disk, std::span<const double> half_cotangent,
                     std::span<const std::uint8_t> on_boundary, const CancelToken& cancel);
  ~DirichletLaplacian();
  DirichletLaplacian(const DirichletLaplacian&) = delete;
  DirichletLaplacian& operator=(const DirichletLaplacian&) = delete;

  // False when the factorisation met a pivot that is not positive (rounding): solve() must not be called.
  bool factorised() const { return factorised_; }
  std::size_t interior_count() const { return interior_count_; }

  // x_I = A_II^-1 (b_I - A_IB x_B): V values in, boundary entries of x are read, interior ones written.
  void solve(std::span<const double> b, std::span<double> x) const;
  // (A x) at boundary vertices, 0 elsewhere: V values.
  std::vector<double> apply_at_boundary(std::span<const double> x) const;

 private:
  struct Factor;
  const IntrinsicDisk& disk_;
  std::vector<double> weight_;           // 3 T: (cot a + cot b) / 2 of the edge at its smaller half-edge
  std::vector<std::uint32_t> interior_;  // V: number among the interior vertices, no_index on the boundary
  std::size_t interior_count_ = 0;
  bool factorised_ = false;
  std::unique_ptr<Factor> factor_;
};

}  // namespace meander
