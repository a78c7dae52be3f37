// Tensor fields given by a formula in space, for tests.
#pragma once

#include <cmath>
#include <functional>

#include "kernels/tensor/tensor_field.h"

namespace meander::test {

// The wanted spacings at a point (file coordinates): `along` is projected into the triangle.
struct WantedSpacing {
  Vector3 along;
  double first = 1, second = 1;
};
using SpacingFormula = std::function<WantedSpacing(Vector3 point, Vector3 normal)>;

// Evaluated once per triangle, at its centroid: the same tensor at its three corners.
inline TensorField field_by_formula(const PreparedMesh& mesh, const SpacingFormula& formula) {
  TensorField field;
  field.corner.resize(mesh.triangles.size());
  for (std::uint32_t t = 0; t < mesh.triangle_count(); ++t) {
    if (!(mesh.area[t] > 0)) continue;
    const TangentFrame frame = triangle_frame(mesh, t);
    const Vector3 sum = mesh.position(mesh.triangles[3 * t]) + mesh.position(mesh.triangles[3 * t + 1]) +
                        mesh.position(mesh.triangles[3 * t + 2]);
    const WantedSpacing wanted = formula(mesh.center + mesh.unit / 3 * sum, frame.normal);
    const double x = dot(wanted.along, frame.x), y = dot(wanted.along, frame.y), length = std::hypot(x, y);
    TensorAxes axes{std::log(wanted.first), std::log(wanted.second), 1, 0};
    if (length > 0) {
      axes.x = x / length;
      axes.y = y / length;
    }
    for (std::uint32_t h = 3 * t; h < 3 * t + 3; ++h) field.corner[h] = tensor_of(axes);
  }
  return field;
}

inline SpacingFormula constant_spacing(double angle, double first, double second) {
  return [=](Vector3, Vector3) {
    return WantedSpacing{{std::cos(angle), std::sin(angle), 0}, first, second};
  };
}

}  // namespace meander::test
