#include "kernels/mesh/surface_walk.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace meander {

namespace {

constexpr int max_edges = 256;

// A triangle as a walk sees it: its corners, and two of its sides.
struct Floor {
  std::array<Vector3, 3> corner;
  Vector3 first, second;       // from corner 0 to corners 1 and 2
  double a = 0, b = 0, c = 0;  // their products: first^2, first second, second^2
  double squared_area = 0;     // of the parallelogram

  Floor(const PreparedMesh& mesh, std::uint32_t triangle) {
    for (std::size_t k = 0; k < 3; ++k)
      corner[k] = mesh.position(mesh.triangles[3 * std::size_t{triangle} + k]);
    first = corner[1] - corner[0];
    second = corner[2] - corner[0];
    a = dot(first, first);
    b = dot(first, second);
    c = dot(second, second);
    squared_area = a * c - b * b;
  }
  bool is_flat() const { return squared_area > 0; }

  // Changes of the three weights along a way.
  std::array<double, 3> weights_of(const Vector3& way) const {
    const double p = dot(first, way), q = dot(second, way);
    const double w1 = (c * p - b * q) / squared_area, w2 = (a * q - b * p) / squared_area;
    return {-w1 - w2, w1, w2};
  }
};

}  // namespace

Vector3 position_of(const PreparedMesh& mesh, const SurfacePlace& place) {
  const std::uint32_t* const corner = &mesh.triangles[3 * std::size_t{place.triangle}];
  return (1 - place.b1 - place.b2) * mesh.position(corner[0]) + place.b1 * mesh.position(corner[1]) +
         place.b2 * mesh.position(corner[2]);
}

Vector3 triangle_normal(const PreparedMesh& mesh, std::uint32_t triangle) {
  const std::uint32_t* const corner = &mesh.triangles[3 * std::size_t{triangle}];
  const Vector3 a = mesh.position(corner[0]);
  const Vector3 normal = cross(mesh.position(corner[1]) - a, mesh.position(corner[2]) - a);
  const double length = norm(normal);
  return length > 0 ? (1 / length) * normal : Vector3{};
}

SurfacePlace walk_on_surface(const PreparedMesh& mesh, SurfacePlace place, Vector3 way) {
  Floor floor(mesh, place.triangle);
  if (!floor.is_flat()) return place;
  std::array<double, 3> weight = {1 - place.b1 - place.b2, place.b1, place.b2};
  for (double& w : weight) w = std::max(w, 0.0);
  const Vector3 up = cross(floor.first, floor.second);
  way = way - (dot(way, up) / floor.squared_area) * up;
  for (int edges = 0; edges <= max_edges; ++edges) {
    const std::array<double, 3> change = floor.weights_of(way);
    // The corner whose weight reaches 0 first, and after which part of the way.
    std::size_t corner = 3;
    double part = 1;
    for (std::size_t k = 0; k < 3; ++k)
      if (change[k] < 0 && weight[k] < -change[k] * part) {
        part = weight[k] / -change[k];
        corner = k;
      }
    for (std::size_t k = 0; k < 3; ++k) weight[k] = std::max(weight[k] + part * change[k], 0.0);
    if (corner == 3 || edges == max_edges) break;
    weight[corner] = 0;
    way = (1 - part) * way;
    // The edge opposite to that corner.
    const std::size_t from = (corner + 1) % 3, to = (corner + 2) % 3;
    const auto half_edge = static_cast<std::uint32_t>(3 * place.triangle + from);
    const std::uint32_t across = mesh.opposite[half_edge];
    const Vector3 edge = floor.corner[to] - floor.corner[from];
    const double squared = dot(edge, edge), along = dot(way, edge) / squared;
    if (across == no_index) {
      const double step = std::clamp(along, -weight[to], weight[from]);
      weight[from] -= step;
      weight[to] += step;
      break;
    }
    const Floor next(mesh, across / 3);
    if (!next.is_flat()) break;
    // Weights of the ends of the edge, which runs the other way there.
    const double rest = std::sqrt(std::max(dot(way, way) - along * along * squared, 0.0));
    const std::size_t there = across % 3;
    std::array<double, 3> moved{};
    moved[there] = weight[to];
    moved[(there + 1) % 3] = weight[from];
    const Vector3 inward = next.corner[(there + 2) % 3] - next.corner[there];
    const Vector3 side = inward - (dot(inward, edge) / squared) * edge;
    const double length = norm(side);
    if (!(length > 0)) break;
    way = along * edge + (rest / length) * side;
    weight = moved;
    place.triangle = across / 3;
    floor = next;
  }
  const double sum = weight[0] + weight[1] + weight[2];
  place.b1 = weight[1] / sum;
  place.b2 = weight[2] / sum;
  return place;
}

}  // namespace meander
