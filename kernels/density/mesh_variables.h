// The variables of formulas on a mesh.
#pragma once

#include <array>
#include <span>
#include <string_view>
#include <vector>

#include "kernels/core/cancel.h"
#include "kernels/core/expression.h"
#include "kernels/density/curvature.h"
#include "kernels/mesh/polygon_mesh.h"
#include "kernels/mesh/prepared_mesh.h"

namespace meander {

// The point, the unit normal of its triangle (as it is oriented in the prepared mesh), mean and Gaussian
// curvature (VertexCurvature: |H| in 1 / length, K in 1 / length^2), and texture coordinates. All but the
// normal are linear over triangles.
inline constexpr std::array<std::string_view, 10> mesh_variables = {"x",  "y",    "z",        "nx", "ny",
                                                                    "nz", "mean", "gaussian", "u",  "v"};
inline constexpr std::array<std::uint32_t, 10> degrees_over_triangles = {1, 1, 1, 0, 0, 0, 1, 1, 1, 1};

// Whether a formula needs the curvature of the mesh, its texture coordinates.
bool uses_curvature(const Expression& formula);
bool uses_coordinates(const Expression& formula);

// The values of mesh_variables that some formulas use.
class MeshVariables {
 public:
  // In the lengths of the file, or of the box whose longest side is 1 and whose lowest corner is the origin.
  // Refers to both meshes. Throws ItemError (missing_attribute) where a formula uses texture coordinates that
  // the file has not got. O(T) with curvature, else O(1).
  MeshVariables(const PolygonMesh& file, const PreparedMesh& mesh, std::span<const Expression> formulas,
                bool unit_box, const CancelToken& cancel);

  // The value of a formula at points of one triangle, by the weights of its corners 1 and 2. Throws ItemError
  // (missing_attribute) for a face without the texture coordinates that it uses.
  void evaluate(const Expression& formula, std::size_t triangle,
                std::span<const std::array<double, 2>> weight, std::span<double> value) const;
  // Those at the corners of the triangles [begin, end), three for each; 0 for triangles without an area.
  void evaluate_corners(const Expression& formula, std::size_t begin, std::size_t end,
                        std::span<double> value) const;

  // x, y and z of such a point.
  std::array<double, 3> place(std::size_t triangle, const std::array<double, 2>& weight) const;

 private:
  std::array<double, 3> at_corners(std::size_t variable, std::size_t triangle) const;
  double curvature(bool gaussian, std::uint32_t vertex) const;
  double coordinate(std::size_t axis, std::size_t half_edge) const;

  const PolygonMesh& file_;
  const PreparedMesh& mesh_;
  double length_ = 1;  // of the file, that is 1 in the formulas
  std::array<double, 3> origin_{};
  VertexCurvature curvature_;
};

}  // namespace meander
