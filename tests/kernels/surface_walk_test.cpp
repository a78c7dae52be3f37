#include "kernels/mesh/surface_walk.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "kernels/core/random.h"
#include "kernels/mesh/prepare_mesh.h"
#include "support/catch.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;

namespace {

// A square in the plane z = 0 whose vertices inside are moved at random.
PolygonMesh irregular_square(std::uint32_t n) {
  PolygonMesh mesh = grid_plane(n, n);
  const auto [left, right] = std::minmax_element(mesh.x.begin(), mesh.x.end());
  const auto [low, high] = std::minmax_element(mesh.y.begin(), mesh.y.end());
  const std::array<double, 4> border = {*left, *right, *low, *high};
  for (std::size_t v = 0; v < mesh.x.size(); ++v) {
    if (mesh.x[v] == border[0] || mesh.x[v] == border[1] || mesh.y[v] == border[2] || mesh.y[v] == border[3])
      continue;
    const UnitPair random = random_pair(make_random_key(3, {}), Stream::element_point, v);
    mesh.x[v] += 0.6 / n * (random.first - 0.5);
    mesh.y[v] += 0.6 / n * (random.second - 0.5);
  }
  return mesh;
}

bool is_inside(const SurfacePlace& place) {
  return place.b1 >= 0 && place.b2 >= 0 && place.b1 + place.b2 <= 1 + 1e-12;
}

SurfacePlace random_place(const PreparedMesh& mesh, std::uint64_t i) {
  const UnitPair first = random_pair(make_random_key(1, {}), Stream::element_point, i, 0),
                 second = random_pair(make_random_key(1, {}), Stream::element_point, i, 1);
  SurfacePlace place{static_cast<std::uint32_t>(first.first * static_cast<double>(mesh.triangle_count())),
                     first.second, second.first};
  if (place.b1 + place.b2 > 1) place = {place.triangle, 1 - place.b1, 1 - place.b2};
  return place;
}
Vector3 random_way(std::uint64_t i, double length) {
  const UnitPair random = random_pair(make_random_key(2, {}), Stream::element_point, i);
  const double angle = 2 * std::numbers::pi * random.first;
  return {length * random.second * std::cos(angle), length * random.second * std::sin(angle), 0};
}

}  // namespace

TEST_CASE("walk_on_surface: in a plane ways end where vectors do, whatever the triangles") {
  const PreparedMesh mesh = prepare_mesh(irregular_square(24));
  const double half = 0.5 / mesh.unit;
  int inside = 0;
  for (std::uint64_t i = 0; i < 2000; ++i) {
    const SurfacePlace from = random_place(mesh, i);
    const Vector3 way = random_way(i, 0.6 * half), start = position_of(mesh, from);
    const SurfacePlace to = walk_on_surface(mesh, from, way + Vector3{0, 0, 0.3});
    const Vector3 end = position_of(mesh, to), wanted = start + way;
    REQUIRE(is_inside(to));
    if (std::max(std::abs(wanted.x), std::abs(wanted.y)) > half) {
      // The border ends the way across it, not the way along it, as far as that stays in one triangle.
      CHECK(std::max(std::abs(end.x), std::abs(end.y)) == Approx(half));
      continue;
    }
    ++inside;
    CHECK(distance(end, wanted) < 1e-12);
  }
  CHECK(inside > 1000);
}

TEST_CASE("walk_on_surface: at a border the rest of the way goes along it") {
  const PreparedMesh mesh = prepare_mesh(grid_plane(1, 1));
  const double half = 0.5 / mesh.unit;
  for (std::uint32_t t = 0; t < 2; ++t) {
    const SurfacePlace from{t, 1.0 / 3, 1.0 / 3};
    const Vector3 start = position_of(mesh, from);
    // Away from the diagonal, which the other triangle lies beyond.
    const double out = start.y > 0 ? 1 : -1;
    const Vector3 end = position_of(mesh, walk_on_surface(mesh, from, {0.05 * half, out * 2 * half, 0}));
    CHECK(end.y == Approx(out * half));
    CHECK(end.x == Approx(start.x + 0.05 * half));
  }
}

TEST_CASE("walk_on_surface: ways on a prism are those on its unfolded sides, and lead back") {
  // A closed ring of 12 sides, 2 triangles each.
  constexpr std::uint32_t sides = 12;
  std::vector<double> xyz;
  std::vector<std::vector<std::uint32_t>> faces;
  for (std::uint32_t k = 0; k < sides; ++k) {
    const double angle = 2 * std::numbers::pi * k / sides;
    for (const double z : {-1.0, 1.0}) xyz.insert(xyz.end(), {std::cos(angle), std::sin(angle), z});
    const std::uint32_t a = 2 * k, b = 2 * ((k + 1) % sides);
    faces.push_back({a, b, b + 1});
    faces.push_back({a, b + 1, a + 1});
  }
  const PreparedMesh mesh = prepare_mesh(polygon_mesh(xyz, faces));
  const double side = 2 * std::sin(std::numbers::pi / sides);
  // How far round a point lies, in file units.
  const auto round = [&](const Vector3& p) {
    double angle = std::atan2(p.y, p.x);
    if (angle < 0) angle += 2 * std::numbers::pi;
    const double step = 2 * std::numbers::pi / sides, k = std::floor(angle / step);
    const Vector3 corner = {std::cos(k * step), std::sin(k * step), 0};
    return k * side + std::hypot(p.x * mesh.unit - corner.x, p.y * mesh.unit - corner.y);
  };
  for (std::uint64_t i = 0; i < 500; ++i) {
    const SurfacePlace from = random_place(mesh, i);
    const Vector3 start = position_of(mesh, from), normal = triangle_normal(mesh, from.triangle);
    if (std::abs(start.z * mesh.unit) > 0.5) continue;
    const Vector3 along = cross({0, 0, 1}, normal);  // round the axis, of length 1
    const double far = 3.7 * side, up = 0.4;
    const SurfacePlace to =
        walk_on_surface(mesh, from, (far / mesh.unit) * along + Vector3{0, 0, up / mesh.unit});
    const Vector3 end = position_of(mesh, to);
    CHECK(end.z * mesh.unit == Approx(start.z * mesh.unit + up));
    const double gone = std::fmod(round(end) - round(start) + sides * side, sides * side);
    CHECK(gone == Approx(far).epsilon(1e-9));
    const Vector3 there = cross({0, 0, 1}, triangle_normal(mesh, to.triangle));
    const Vector3 back = position_of(
        mesh, walk_on_surface(mesh, to, (-far / mesh.unit) * there + Vector3{0, 0, -up / mesh.unit}));
    CHECK(distance(back, start) < 1e-10);
  }
}

TEST_CASE("walk_on_surface: ends on the surface, no farther than it is long, on needles and at corners") {
  for (const PolygonMesh& file : {cube(), tetrahedron(), torus(40, 7, 1, 0.02), moebius_strip(30)}) {
    const PreparedMesh mesh = prepare_mesh(file);
    for (std::uint64_t i = 0; i < 500; ++i) {
      SurfacePlace from = random_place(mesh, i);
      if (i % 5 == 0) from = {from.triangle, i % 2 == 0 ? 1.0 : 0.0, 0.0};  // a corner
      const Vector3 way = random_way(i, 1), start = position_of(mesh, from);
      const SurfacePlace to = walk_on_surface(mesh, from, way);
      REQUIRE(is_inside(to));
      CHECK(distance(position_of(mesh, to), start) <= norm(way) * (1 + 1e-9));
    }
  }
}
