#include "kernels/analyse/self_intersections.h"

#include "kernels/remesh/crossing_triangles.h"

namespace meander {

std::uint64_t self_intersections(const TriangleSpans& mesh) {
  const std::size_t count = mesh.triangles.size() / 3;
  const auto vertices = [&](std::size_t t) {
    return TriangleVertices{mesh.triangles[3 * t], mesh.triangles[3 * t + 1], mesh.triangles[3 * t + 2]};
  };
  const auto at = [&](std::uint32_t v) { return Vector3{mesh.x[v], mesh.y[v], mesh.z[v]}; };
  const auto corners = [&](std::size_t t) {
    const TriangleVertices v = vertices(t);
    return TriangleCorners{at(v[0]), at(v[1]), at(v[2])};
  };
  const auto box = [&](std::size_t t) { return box_of(corners(t)); };
  const auto cross = [&](std::size_t t, std::size_t u) {
    return !share_a_vertex(vertices(t), vertices(u)) && triangles_cross(corners(t), corners(u));
  };
  return crossing_pairs(BoxSearch(count, box), count, 0, {}, box, cross, [] {}).count;
}

}  // namespace meander
