#include "kernels/describe/shape_moments.h"

#include <cmath>
#include <numbers>

#include "kernels/core/status.h"
#include "support/catch.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;

namespace {

ShapeMoments moments_of(const PolygonMesh& mesh) {
  return shape_moments(mesh.x, mesh.y, mesh.z, triangles_of(mesh));
}

}  // namespace

TEST_CASE("shape moments: exact for a cube") {
  const ShapeMoments m = moments_of(cube());
  CHECK(m.area == Approx(24).epsilon(1e-14));
  CHECK(m.closed);
  CHECK(m.volume == Approx(8).epsilon(1e-14));
  CHECK(norm(m.centroid) < 1e-14);
  CHECK(norm(m.volume_centroid) < 1e-14);
  // Mean square of a coordinate: 1 on two faces, 1/3 on four.
  for (std::size_t k = 0; k < 3; ++k) {
    CHECK(m.inertia[k] == Approx(24 * 10.0 / 9).epsilon(1e-14));
    CHECK(m.inertia[3 + k] == Approx(0).margin(1e-13));
    CHECK(m.principal_moments[k] == Approx(24 * 10.0 / 9).epsilon(1e-13));
  }
  const auto basics = shape_basics(m);
  const double d = std::sqrt(12.0);
  CHECK(basics[0] == Approx(2));
  CHECK(basics[1] == Approx(8 / (d * d * d)));
  CHECK(basics[2] == Approx(std::numbers::pi / 6));
  CHECK(basics[3] == Approx(2 / d));
  CHECK(basics[6] == Approx(0).margin(1e-14));
  CHECK(basics[14] == Approx(10.0 / 9 / 12));
  CHECK(basics[15] == Approx(std::sqrt(5.0 / 3) / d));
}

TEST_CASE("shape moments: a fine sphere and torus approach the closed forms") {
  const double pi = std::numbers::pi, radius = 1.5;
  const ShapeMoments sphere = moments_of(icosphere(5, radius));
  CHECK(sphere.area == Approx(4 * pi * radius * radius).epsilon(1e-3));
  CHECK(sphere.volume == Approx(4 * pi / 3 * std::pow(radius, 3)).epsilon(2e-3));
  for (const double moment : sphere.principal_moments)
    CHECK(moment == Approx(2.0 / 3 * 4 * pi * std::pow(radius, 4)).epsilon(2e-3));
  CHECK(shape_basics(sphere)[2] == Approx(1).epsilon(1e-3));

  const double R = 1, r = 0.4, area = 4 * pi * pi * R * r;
  const ShapeMoments torus_moments = moments_of(torus(256, 128, R, r));
  CHECK(torus_moments.area == Approx(area).epsilon(1e-3));
  CHECK(torus_moments.volume == Approx(2 * pi * pi * R * r * r).epsilon(1e-3));
  CHECK(torus_moments.principal_moments[0] == Approx(area * (R * R / 2 + 1.25 * r * r)).epsilon(2e-3));
  CHECK(torus_moments.principal_moments[1] == Approx(area * (R * R / 2 + 1.25 * r * r)).epsilon(2e-3));
  CHECK(torus_moments.principal_moments[2] == Approx(area * (R * R + 1.5 * r * r)).epsilon(2e-3));
}

TEST_CASE("shape moments: a triangle agrees with its subdivision") {
  // Sums over many small triangles of one face: point masses at their centroids converge to the integrals.
  const Vector3 a{0.2, 0.1, 3}, b{1.5, -0.3, 2}, c{0.4, 2, 2.5};
  const int n = 256;
  double area = 0;
  Vector3 mean;
  std::array<double, 6> second{};
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < 2 * (n - i) - 1; ++j) {
      const double shift = j % 2 == 0 ? 1.0 / 3 : 2.0 / 3;
      const double u = (i + shift) / n, v = (j / 2 + shift) / n;
      const Vector3 p = (1 - u - v) * a + u * b + v * c;
      const double weight = triangle_area(a, b, c) / (n * n);
      area += weight;
      mean = mean + weight * p;
      const std::array<double, 6> products{p.x * p.x, p.y * p.y, p.z * p.z, p.x * p.y, p.x * p.z, p.y * p.z};
      for (std::size_t k = 0; k < 6; ++k) second[k] += weight * products[k];
    }
  mean = (1 / area) * mean;
  const std::vector<double> x{a.x, b.x, c.x}, y{a.y, b.y, c.y}, z{a.z, b.z, c.z};
  const ShapeMoments m = shape_moments(x, y, z, std::vector<std::uint32_t>{0, 1, 2});
  CHECK(m.area == Approx(area));
  CHECK(distance(m.centroid, mean) < 1e-10);
  CHECK(m.inertia[0] ==
        Approx(second[1] + second[2] - area * (mean.y * mean.y + mean.z * mean.z)).epsilon(1e-4));
  CHECK(m.inertia[3] == Approx(area * mean.x * mean.y - second[3]).epsilon(1e-4));
  CHECK(m.inertia[5] == Approx(area * mean.y * mean.z - second[5]).epsilon(1e-4));
  CHECK_FALSE(m.closed);
  CHECK(std::isnan(m.volume));
  CHECK(std::isnan(shape_basics(m)[9]));
}

TEST_CASE("shape moments: move with the mesh") {
  const PolygonMesh mesh = merged(cube(), moved(tetrahedron(), 0.7, 4, 1, 0.5));
  const ShapeMoments before = moments_of(mesh), after = moments_of(moved(mesh, 3, 100, -50, 20));
  CHECK(after.area == Approx(9 * before.area));
  CHECK(after.volume == Approx(27 * before.volume));
  for (std::size_t k = 0; k < 3; ++k) {
    CHECK(after.principal_moments[k] == Approx(81 * before.principal_moments[k]));
    CHECK(norm(before.principal_axes[k]) == Approx(1));
    // I a = m a
    const auto& t = before.inertia;
    const Vector3 axis = before.principal_axes[k];
    const Vector3 turned{t[0] * axis.x + t[3] * axis.y + t[4] * axis.z,
                         t[3] * axis.x + t[1] * axis.y + t[5] * axis.z,
                         t[4] * axis.x + t[5] * axis.y + t[2] * axis.z};
    CHECK(norm(turned - before.principal_moments[k] * axis) < 1e-11 * before.principal_moments[2]);
  }
  CHECK(dot(cross(before.principal_axes[0], before.principal_axes[1]), before.principal_axes[2]) ==
        Approx(1));
  CHECK(distance(after.centroid, after.volume_centroid) ==
        Approx(3 * distance(before.centroid, before.volume_centroid)));
  // Scale and place alone leave all the basics as they are.
  PolygonMesh scaled = mesh;
  for (auto* coordinates : {&scaled.x, &scaled.y, &scaled.z})
    for (double& value : *coordinates) value = 1e60 * (value + 2);
  const auto basics = shape_basics(before), same = shape_basics(moments_of(scaled));
  for (std::size_t k = 0; k < shape_basics_count; ++k) CHECK(same[k] == Approx(basics[k]).margin(1e-13));
}

TEST_CASE("shape moments: only closed, oriented meshes have a volume") {
  CHECK_FALSE(moments_of(grid_plane(3, 3)).closed);
  const PolygonMesh mesh = cube();
  std::vector<std::uint32_t> triangles = triangles_of(mesh);
  std::swap(triangles[0], triangles[1]);
  CHECK(std::isnan(shape_moments(mesh.x, mesh.y, mesh.z, triangles).volume));
  triangles = triangles_of(mesh);
  for (std::size_t t = 0; t < triangles.size(); t += 3) std::swap(triangles[t], triangles[t + 1]);
  CHECK(shape_moments(mesh.x, mesh.y, mesh.z, triangles).volume == Approx(-8));
  CHECK_THROWS_AS(shape_moments(mesh.x, mesh.y, mesh.z, {}), ItemError);
  CHECK_THROWS_AS(shape_moments(mesh.x, mesh.y, mesh.z, std::vector<std::uint32_t>{1, 1, 2}), ItemError);
}
