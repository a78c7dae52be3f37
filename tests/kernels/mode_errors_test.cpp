#include "kernels/analyse/mode_errors.h"

#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "kernels/core/random.h"
#include "kernels/mesh/prepare_mesh.h"
#include "support/catch.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;

namespace {

double value_at(const PreparedMesh& mesh, const SurfaceMode& mode, std::size_t t, double b, double c) {
  const Component& component = mesh.components[mode.component];
  if (t < component.triangle_begin || t >= component.triangle_end) return 0;
  const auto at = [&](std::size_t k) {
    return mode.function[mesh.triangles[3 * t + k] - component.vertex_begin];
  };
  return (1 - b - c) * at(0) + b * at(1) + c * at(2);
}

// The integral of the squared gradient, triangle by triangle, over that of the square.
double rayleigh_quotient(const PreparedMesh& mesh, const SurfaceMode& mode) {
  double energy = 0, square = 0;
  for (std::size_t t = 0; t < mesh.triangle_count(); ++t) {
    const auto corner = [&](std::size_t k) { return mesh.position(mesh.triangles[3 * t + k]); };
    const Vector3 u = corner(1) - corner(0), v = corner(2) - corner(0);
    const double f = value_at(mesh, mode, t, 0, 0), fu = value_at(mesh, mode, t, 1, 0) - f,
                 fv = value_at(mesh, mode, t, 0, 1) - f;
    const double uu = dot(u, u), uv = dot(u, v), vv = dot(v, v), det = uu * vv - uv * uv;
    energy += mesh.area[t] * (vv * fu * fu - 2 * uv * fu * fv + uu * fv * fv) / det;
    for (const auto& [b, c] : {std::pair{0.5, 0.0}, {0.0, 0.5}, {0.5, 0.5}})
      square += mesh.area[t] / 3 * std::pow(value_at(mesh, mode, t, b, c), 2);
  }
  return energy / square;
}

SurfaceLocations random_locations(const PreparedMesh& mesh, std::size_t n, std::uint64_t seed) {
  const RandomKey key = make_random_key(seed, {});
  std::vector<double> sums;
  for (const double area : mesh.area) sums.push_back((sums.empty() ? 0 : sums.back()) + area);
  SurfaceLocations points;
  for (std::size_t i = 0; i < n; ++i) {
    const UnitPair first = random_pair(key, Stream::sequence, i),
                   second = random_pair(key, Stream::element_point, i);
    const auto found = std::upper_bound(sums.begin(), sums.end() - 1, first.first * sums.back());
    const double root = std::sqrt(second.first);
    points.triangle.push_back(static_cast<std::uint32_t>(found - sums.begin()));
    points.barycentric.insert(points.barycentric.end(), {root * (1 - second.second), root * second.second});
    points.distance.push_back(0);
  }
  return points;
}

}  // namespace

TEST_CASE("lowest_modes: of the sphere are spherical harmonics") {
  const PreparedMesh mesh = prepare_mesh(icosphere(3));
  const std::vector<SurfaceMode> modes = lowest_modes(mesh, 15);
  REQUIRE(modes.size() == 15);
  for (std::size_t m = 0; m < modes.size(); ++m) {
    INFO(m);
    const double degree = m < 3 ? 1 : m < 8 ? 2 : 3;
    CHECK(modes[m].value / (mesh.unit * mesh.unit) == Approx(degree * (degree + 1)).epsilon(0.01));
    CHECK(rayleigh_quotient(mesh, modes[m]) == Approx(modes[m].value).epsilon(0.02));
    CHECK(std::abs(modes[m].mean) < 1e-3 * std::sqrt(modes[m].variance));
  }
  // The first three are linear in the coordinates: orthogonal directions.
  std::vector<Vector3> directions;
  for (std::size_t m = 0; m < 3; ++m) {
    Vector3 sum;
    double square = 0;
    for (std::uint32_t v = 0; v < mesh.x.size(); ++v) {
      sum = sum + modes[m].function[v] * mesh.position(v);
      square += modes[m].function[v] * modes[m].function[v];
    }
    const double count = static_cast<double>(mesh.x.size()), radius = norm(mesh.position(0));
    const Vector3 direction = (3 / (radius * radius * count)) * sum;  // f = direction . p
    double rest = 0;
    for (std::uint32_t v = 0; v < mesh.x.size(); ++v)
      rest += std::pow(modes[m].function[v] - dot(direction, mesh.position(v)), 2);
    CHECK(rest < 1e-3 * square);
    for (const Vector3& other : directions)
      CHECK(std::abs(dot(direction, other)) < 0.01 * norm(direction) * norm(other));
    directions.push_back(direction);
  }
}

TEST_CASE("lowest_modes: of few vertices, and of components together") {
  // By dense matrices; tetrahedron: three functions, all that there are.
  const PreparedMesh tetrahedral = prepare_mesh(tetrahedron());
  const std::vector<SurfaceMode> three = lowest_modes(tetrahedral, 30);
  REQUIRE(three.size() == 3);
  for (const SurfaceMode& mode : three) {
    double sum = 0, square = 0;
    for (const double f : mode.function) sum += f, square += f * f;
    CHECK(std::abs(sum) < 1e-9 * std::sqrt(square));
  }
  // Spheres of radius 2 and 1: l (l + 1) / 4, three times .5 and five times 1.5, then three times 2.
  PolygonMesh large = icosphere(3, 2);
  for (double& x : large.x) x += 5;
  const PreparedMesh mesh = prepare_mesh(merged(large, icosphere(3)));
  REQUIRE(mesh.components.size() == 2);
  const std::vector<SurfaceMode> modes = lowest_modes(mesh, 13);
  REQUIRE(modes.size() == 13);
  const double expected[] = {0, 0, .5, .5, .5, 1.5, 1.5, 1.5, 1.5, 1.5, 2, 2, 2};
  for (std::size_t m = 0; m < 13; ++m) {
    INFO(m);
    CHECK(modes[m].value / (mesh.unit * mesh.unit) == Approx(expected[m]).epsilon(0.01));
    const bool is_large = mesh.components[modes[m].component].area > 0.5 * mesh.total_area;
    CHECK(is_large == (m == 0 || (m > 1 && m < 10)));
  }
  CHECK(modes[0].mean == Approx(0.8).epsilon(1e-3));
  CHECK(modes[0].variance == Approx(0.16).epsilon(1e-3));
}

TEST_CASE("mode_error_ratio: linear functions are exact in the middles of equal triangles") {
  const PreparedMesh mesh = prepare_mesh(grid_plane(20, 15, 2, 1));
  const std::vector<SurfaceMode> modes = lowest_modes(mesh, 30);
  SurfaceLocations middles;
  for (std::uint32_t t = 0; t < mesh.triangle_count(); ++t) {
    middles.triangle.push_back(t);
    middles.barycentric.insert(middles.barycentric.end(), {1.0 / 3, 1.0 / 3});
    middles.distance.push_back(0);
  }
  CHECK(mode_error_ratio(mesh, modes, middles) < 1e-10);
}

TEST_CASE("mode_error_ratio: random points score one, and any number of threads the same") {
  PolygonMesh ball = icosphere(3);
  for (double& x : ball.x) x += 3;
  const PreparedMesh mesh = prepare_mesh(merged(torus(30, 16), ball));
  const std::vector<SurfaceMode> modes = lowest_modes(mesh, 30);
  double mean_square = 0;
  constexpr int sets = 60;
  for (int seed = 0; seed < sets; ++seed)
    mean_square +=
        std::pow(mode_error_ratio(mesh, modes, random_locations(mesh, 500, 7 + static_cast<unsigned>(seed))),
                 2) /
        sets;
  // The deviation of the mean of 60 x 30 squares is at most some 4 %.
  CHECK(mean_square == Approx(1).epsilon(0.15));
  const SurfaceLocations points = random_locations(mesh, 500, 3);
  const double whole = mode_error_ratio(mesh, modes, points);
  double alone = 0;
  oneapi::tbb::task_arena(1).execute([&] { alone = mode_error_ratio(mesh, lowest_modes(mesh, 30), points); });
  CHECK(whole == alone);
  // By the functions themselves.
  double squares = 0;
  for (const SurfaceMode& mode : modes) {
    double sum = 0;
    for (std::size_t i = 0; i < 500; ++i)
      sum +=
          value_at(mesh, mode, points.triangle[i], points.barycentric[2 * i], points.barycentric[2 * i + 1]);
    squares += std::pow(sum / 500 - mode.mean, 2) * 500 / mode.variance / static_cast<double>(modes.size());
  }
  CHECK(whole == Approx(std::sqrt(squares)).epsilon(1e-10));
}

TEST_CASE("mode_error_ratio: all points on one of two components") {
  PolygonMesh ball = icosphere(2);
  for (double& x : ball.x) x += 5;
  const PreparedMesh mesh = prepare_mesh(merged(icosphere(2), ball));
  const std::vector<SurfaceMode> modes = lowest_modes(mesh, 2);
  REQUIRE(modes.size() == 2);
  SurfaceLocations points;
  for (std::uint32_t i = 0; i < 100; ++i) {
    points.triangle.push_back(mesh.components[0].triangle_begin + i);
    points.barycentric.insert(points.barycentric.end(), {0.25, 0.5});
    points.distance.push_back(0);
  }
  // Shares of 1 and 0 where half is due: .5 / sqrt(.25 / 100).
  CHECK(mode_error_ratio(mesh, modes, points) == Approx(10).epsilon(1e-9));
  CHECK_THROWS_AS(mode_error_ratio(mesh, modes, {}), std::invalid_argument);
  CHECK_THROWS_AS(mode_error_ratio(mesh, {}, points), std::invalid_argument);
}
