// Tensor fields that follow a direction in space.
#pragma once

#include <cmath>
#include <functional>

#include "kernels/tensor/tensor_field.h"

namespace meander::test {

// s1 / s2 = ratio and s1 s2 = 1 on every triangle, e1 along the projection of direction(centroid); s1 = s2
// where that vanishes.
inline TensorField field_along(const PreparedMesh& mesh, const std::function<Vector3(Vector3)>& direction,
                               double ratio) {
  TensorField field;
  field.corner.resize(mesh.triangles.size());
  for (std::uint32_t t = 0; t < mesh.triangle_count(); ++t) {
    if (!(mesh.area[t] > 0)) continue;
    const TangentFrame frame = triangle_frame(mesh, t);
    const Vector3 centroid =
        (1.0 / 3) * (mesh.position(mesh.triangles[3 * t]) + mesh.position(mesh.triangles[3 * t + 1]) +
                     mesh.position(mesh.triangles[3 * t + 2]));
    const Vector3 d = direction(centroid);
    const double x = dot(d, frame.x), y = dot(d, frame.y), length = std::hypot(x, y);
    if (!(length > 1e-9)) continue;
    const double half = 0.5 * std::log(ratio);
    const TangentTensor value = tensor_of({half, -half, x / length, y / length});
    for (std::uint32_t k = 0; k < 3; ++k) field.corner[3 * t + k] = value;
  }
  return field;
}
inline TensorField field_along(const PreparedMesh& mesh, Vector3 direction, double ratio) {
  return field_along(
      mesh, [=](Vector3) { return direction; }, ratio);
}
// S = 1.
inline TensorField round_field(const PreparedMesh& mesh) {
  TensorField field;
  field.corner.resize(mesh.triangles.size());
  return field;
}

}  // namespace meander::test
