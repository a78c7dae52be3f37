#include "kernels/sample/point_frames.h"

#include <array>

namespace meander {

std::vector<double> working_points(const ItemReport& report, std::span<const float> points,
                                   const PreparedMesh& mesh) {
  std::vector<double> working;
  working.reserve(points.size());
  for (std::size_t i = 0; i < points.size() / 3; ++i) {
    const Vector3 p = to_working(mesh, file_point(report, points, i));
    working.insert(working.end(), {p.x, p.y, p.z});
  }
  return working;
}

std::vector<float> stored_points(std::span<const double> working, const PreparedMesh& mesh,
                                 const OutputFrame& frame) {
  // The centre less loc first: where both are far from the origin, nothing of the points is lost.
  const std::array<double, 3> shift = {mesh.centre.x - frame.loc.x, mesh.centre.y - frame.loc.y,
                                       mesh.centre.z - frame.loc.z};
  std::vector<float> stored(working.size());
  for (std::size_t i = 0; i < stored.size(); ++i)
    stored[i] = static_cast<float>((mesh.unit * working[i] + shift[i % 3]) / frame.scale) + 0.0f;
  return stored;
}

}  // namespace meander
