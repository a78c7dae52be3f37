// Curvature tensors at the vertices of a mesh, and the spacings that follow them.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "kernels/core/cancel.h"
#include "kernels/mesh/prepared_mesh.h"
#include "kernels/tensor/tangent_tensor.h"

namespace meander {

// The second fundamental form at the W working vertices in the given frames (those of vertex_frames), 1 /
// working unit: eigenvalues are the principal curvatures, positive where the surface bends away from its
// normal (a sphere seen from outside).
//
// Finite differences of vertex normals along edges (Rusinkiewicz 2004, "Estimating curvatures and their
// derivatives on triangle meshes"), but with one least-squares fit per vertex over all edges of its triangles
// (weights: mixed area over squared edge lengths) in place of a fit per triangle, so that needles and slivers
// do not degrade it. Safeguards:
// - Normals on the boundary are one-sided: edges that touch it are used only where there are no others.
// - Boundary vertices, and vertices whose edges do not span their plane, take the transported mean of their
//   neighbors that have a value, round by round (at most 64).
// - Curvatures within the rounding error of float32 coordinates are set to zero.
// The error is O(h^2) on regular meshes of edge length h, and bounded (a few percent) on irregular ones,
// whose vertex normals are off by O(h). O(T), parallel, deterministic.
std::vector<TangentTensor> curvature_tensors(const PreparedMesh& mesh, std::span<const TangentFrame> frames,
                                             const CancelToken& cancel = {});

struct CurvatureFieldParameters {
  // True: the density 1 / (s1 s2) follows the curvature; false: s1 s2 = 1, only shapes vary.
  bool adaptive = false;
  double max_ratio = 8;    // s1 / s2 is clamped to it; 1..64
  double epsilon = 0.02;   // added to curvatures, 1 / diagonal: smaller ones count as flat; 1e-6..1e3
  double quantile = 0.99;  // adaptive: share of the area at whose curvature larger ones are capped; (0, 1]
  unsigned smoothing = 3;  // rounds of smooth_tensors; 0..64
};

// Returns one sentence for each value out of its range.
std::vector<std::string> validate(const CurvatureFieldParameters& parameters);

// log S at the W working vertices in the given frames: s_k = (|kappa_k| + epsilon)^(-1/2), so that the
// primary direction is that of least absolute curvature; s1 is limited to max_ratio s2. The tensors are
// smoothed before this step and the field after it; where s1 / s2 < 1.05 (umbilics, flat parts) the field is
// made isotropic. It depends on neither scale nor position, and is not normalized (normalize_spacings does
// that). O(T + W log W), deterministic for every thread count. Throws timeout / RunCanceled; parameters are
// taken as valid.
std::vector<TangentTensor> curvature_field(const PreparedMesh& mesh, std::span<const TangentFrame> frames,
                                           const CurvatureFieldParameters& parameters,
                                           const CancelToken& cancel = {});

}  // namespace meander
