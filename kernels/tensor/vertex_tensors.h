// Tangent planes at the vertices of a mesh, and tensors in them.
#pragma once

#include <span>
#include <vector>

#include "kernels/core/cancel.h"
#include "kernels/mesh/prepared_mesh.h"
#include "kernels/tensor/tangent_tensor.h"

namespace meander {

// A symmetric 3 x 3 tensor in file axes.
struct AmbientTensor {
  double xx = 1, xy = 0, xz = 0, yy = 1, yz = 0, zz = 1;
};

// The restriction of the tensor to a plane: (x^T A x, x^T A y, y^T A y) with the axes of the frame. Positive
// definite when A is.
TangentTensor tangent_part(const AmbientTensor& tensor, const TangentFrame& frame);

// W frames whose normals are the unit vertex normals of Max 1999, "Weights for computing vertex normals from
// facet normals" (exact where the vertices lie on a sphere). A vertex whose triangles have no area, or whose
// normals cancel, takes the mean normal of its neighbors that have one, round by round (at most 64), and (0,
// 0, 1) where there is none. O(T), parallel, deterministic for every thread count.
std::vector<TangentFrame> vertex_frames(const PreparedMesh& mesh);

// Log-Euclidean smoothing (Arsigny et al. 2006) of W values log S in W frames: each round replaces a value by
// the mean of itself and the average of its one-ring, transported, weighted by the areas on both sides of
// each edge. Values stay in the convex hull of their ring, so ratios never grow. 0..64 rounds. O(rounds T),
// parallel, deterministic. Throws timeout / RunCanceled.
void smooth_tensors(const PreparedMesh& mesh, std::span<const TangentFrame> frames,
                    std::span<TangentTensor> log_spacing, unsigned rounds, const CancelToken& cancel = {});

}  // namespace meander
