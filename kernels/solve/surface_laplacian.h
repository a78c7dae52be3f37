// The Laplacian of a whole component by its intrinsic triangulation, without a boundary condition.
#pragma once

#include <cstdint>
#include <span>

#include "kernels/core/cancel.h"
#include "kernels/mesh/prepared_mesh.h"
#include "kernels/solve/elimination_order.h"
#include "kernels/solve/intrinsic_disk.h"
#include "kernels/solve/sparse_cholesky.h"

namespace meander {

// The component by its edge lengths (working units); triangles and vertices are counted from 0. O(T).
IntrinsicSurface intrinsic_component(const PreparedMesh& mesh, const Component& component);

// Positive semi-definite cotangent Laplacian over all V vertices: A_ij = -(cot a + cot b) / 2 summed over the
// edges that join i and j, A_ii such that rows sum to 0. Entries of a vertex are in the order of the
// half-edges of its edges, the smaller of two on an edge. Edges that end where they began add nothing.
//   half_cotangent: 3 T, as in CornerGeometry
// O(T).
GraphMatrix surface_laplacian(const IntrinsicSurface& surface, std::span<const double> half_cotangent);

// Factorizes a Laplacian whose diagonal was raised to make it definite. Where rounding makes a pivot that is
// not positive (needles have cotangents of 1e12), tries again with the diagonal raised by 1e-12, 1e-9 and
// 1e-6 of itself and of its mean. Throws ItemError(internal) when that does not help either, and timeout /
// RunCanceled.
void factorize_laplacian(SparseCholesky& factor, const UnknownGraph& graph, std::span<const double> values,
                         std::span<const double> diagonal, std::span<const std::uint32_t> order,
                         const CancelToken& cancel);

}  // namespace meander
