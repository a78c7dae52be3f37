#include "kernels/describe/outward_normals.h"

#include <array>
#include <stdexcept>
#include <string>

namespace meander {

namespace {

std::array<Vector3, 3> corners_of(const PreparedMesh& mesh, std::size_t triangle) {
  const std::uint32_t* const corner = mesh.triangles.data() + 3 * triangle;
  return {mesh.position(corner[0]), mesh.position(corner[1]), mesh.position(corner[2])};
}

// Twice the area vector of a triangle.
Vector3 area_vector(const std::array<Vector3, 3>& corner) {
  return cross(corner[1] - corner[0], corner[2] - corner[0]);
}

Vector3 centroid_of(const PreparedMesh& mesh) {
  Vector3 moment;
  double area = 0;
  for (std::size_t t = 0; t < mesh.triangle_count(); ++t) {
    const std::array<Vector3, 3> corner = corners_of(mesh, t);
    moment = moment + mesh.area[t] * (corner[0] + corner[1] + corner[2]);
    area += mesh.area[t];
  }
  return area > 0 ? (1 / (3 * area)) * moment : Vector3{};
}

// Six times the volume of the tetrahedra between the triangles of the component and a point, which for a
// closed component is the same for every point.
double volume_from(const PreparedMesh& mesh, const Component& component, Vector3 point) {
  double volume = 0;
  for (std::size_t t = component.triangle_begin; t < component.triangle_end; ++t) {
    const std::array<Vector3, 3> corner = corners_of(mesh, t);
    volume += dot(area_vector(corner), corner[0] - point);
  }
  return volume;
}

}  // namespace

OutwardNormals outward_normals(const PreparedMesh& mesh, std::span<const std::uint32_t> triangle) {
  const Vector3 centroid = centroid_of(mesh);
  std::vector<double> sense(mesh.triangle_count(), 1.0);
  std::vector<bool> open(mesh.triangle_count());
  for (const Component& component : mesh.components) {
    const bool inside_out = volume_from(mesh, component, centroid) < 0;
    for (std::size_t t = component.triangle_begin; t < component.triangle_end; ++t) {
      if (inside_out) sense[t] = -1;
      open[t] = component.boundary_loops > 0;
    }
  }
  OutwardNormals result;
  result.normals.reserve(3 * triangle.size());
  std::size_t unoriented = 0;
  for (const std::uint32_t t : triangle) {
    if (t >= mesh.triangle_count())
      throw std::invalid_argument("a sample on triangle " + std::to_string(t) +
                                  ", which the mesh does not have");
    const Vector3 along = area_vector(corners_of(mesh, t));
    const double length = norm(along);
    const Vector3 normal = length > 0 ? (sense[t] / length) * along : Vector3{0, 0, 1};
    for (const double value : {normal.x, normal.y, normal.z})
      result.normals.push_back(static_cast<float>(value));
    unoriented += open[t] ? 1 : 0;
  }
  if (!triangle.empty())
    result.unoriented_share = static_cast<double>(unoriented) / static_cast<double>(triangle.size());
  return result;
}

}  // namespace meander
