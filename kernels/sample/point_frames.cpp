#include "kernels/sample/point_frames.h"

#include <array>

namespace meander {

std::vector<double> file_points(const ItemReport& report, std::span<const float> points) {
  std::vector<double> result;
  result.reserve(points.size());
  for (std::size_t i = 0; i < points.size() / 3; ++i) {
    const Vector3 at = file_point(report, points, i);
    result.insert(result.end(), {at.x, at.y, at.z});
  }
  return result;
}

std::vector<double> working_points(const ItemReport& report, std::span<const float> points,
                                   const PreparedMesh& mesh) {
  std::vector<double> working(points.size());
  // Never in coordinates of the file, which may be too small for double to distinguish the points.
  const std::array<double, 3> shift = {(report.loc[0] - mesh.center.x) / mesh.unit,
                                       (report.loc[1] - mesh.center.y) / mesh.unit,
                                       (report.loc[2] - mesh.center.z) / mesh.unit};
  const double scale = report.scale / mesh.unit;
  for (std::size_t i = 0; i + 2 < points.size(); i += 3)
    for (std::size_t k = 0; k < 3; ++k) working[i + k] = shift[k] + scale * double{points[i + k]};
  return working;
}

std::vector<double> working_points(std::span<const double> file_points, const PreparedMesh& mesh) {
  std::vector<double> working;
  working.reserve(file_points.size());
  for (std::size_t i = 0; i + 2 < file_points.size(); i += 3) {
    const Vector3 p = to_working(mesh, {file_points[i], file_points[i + 1], file_points[i + 2]});
    working.insert(working.end(), {p.x, p.y, p.z});
  }
  return working;
}

std::vector<float> stored_points(std::span<const double> working, const PreparedMesh& mesh,
                                 const OutputFrame& frame) {
  // The center less loc first: where both are far from the origin, nothing of the points is lost.
  const std::array<double, 3> shift = {(mesh.center.x - frame.loc.x) / mesh.unit,
                                       (mesh.center.y - frame.loc.y) / mesh.unit,
                                       (mesh.center.z - frame.loc.z) / mesh.unit};
  const double scale = frame.scale / mesh.unit;
  std::vector<float> stored(working.size());
  for (std::size_t i = 0; i + 2 < stored.size(); i += 3)
    for (std::size_t k = 0; k < 3; ++k)
      stored[i + k] = static_cast<float>((working[i + k] + shift[k]) / scale) + 0.0f;
  return stored;
}

}  // namespace meander
