// The field of requested sample spacings on a mesh that anisotropic sampling follows (docs/METHODS.md 9).
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "kernels/mesh/prepared_mesh.h"
#include "kernels/tensor/tangent_tensor.h"

namespace meander {

// log S at the corners of every triangle, in that triangle's own frame, linear over the triangle. Fields
// given at vertices are transported into the planes of their triangles; fields given on faces are stored
// three times. Metric, density, singularities and combing work inside a triangle's plane.
struct TensorField {
  std::vector<TangentTensor> corner;  // 3 T; all zero (S = 1) on triangles without area

  std::size_t triangle_count() const { return corner.size() / 3; }
  TangentTensor mean(std::size_t triangle) const {
    return (1.0 / 3) * (corner[3 * triangle] + corner[3 * triangle + 1] + corner[3 * triangle + 2]);
  }
};

// The frame of a triangle: x along the edge from corner 0 to corner 1, normal by the right-hand rule. A
// triangle without area gets the standard axes.
TangentFrame triangle_frame(const PreparedMesh& mesh, std::uint32_t triangle);

// log S at weights b (b[0] + b[1] + b[2] = 1) of a triangle, in its frame.
TangentTensor interpolate(const TensorField& field, std::uint32_t triangle, const std::array<double, 3>& b);

// Transports log S, given at the W working vertices in frames whose normals are tangent-plane normals of the
// surface, to the triangles (minimal rotation). Frames and values: W each. O(T), parallel.
TensorField field_from_vertices(const PreparedMesh& mesh, std::span<const TangentFrame> frames,
                                std::span<const TangentTensor> log_spacing);

// Adds one constant to both eigenvalues everywhere so that the integral of 1 / (s1 s2) over the surface
// equals the surface's area: the mean density is 1, whatever the units of the input. Returns the factor that
// both spacings were multiplied by. O(T).
double normalize_spacings(const PreparedMesh& mesh, TensorField& field);

// 1 / (s1 s2) at the corners of every triangle: 3 T numbers > 0. O(T), parallel.
std::vector<double> tensor_density(const TensorField& field);

// Length in spacings of every half-edge: sqrt(e^T (G_i + G_j) / 2 e) from its two ends, averaged over both
// sides of the edge (those of triangles with area), so that both half-edges agree. 3 T, in working units over
// the field's spacings. O(T).
std::vector<double> metric_edge_lengths(const PreparedMesh& mesh, const TensorField& field);

}  // namespace meander
