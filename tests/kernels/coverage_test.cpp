#include "kernels/analyse/coverage.h"

#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "kernels/analyse/spacing.h"
#include "kernels/core/random.h"
#include "kernels/core/status.h"
#include "support/catch.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;

namespace {

Coverage coverage_on(const PolygonMesh& mesh, std::span<const double> points, std::uint64_t seed = 1) {
  const auto triangles = triangles_of(mesh);
  return coverage_of({mesh.x, mesh.y, mesh.z, triangles}, points, seed);
}

// Points of even density, stratified.
std::vector<double> samples_of(const PolygonMesh& mesh, std::uint64_t n, std::uint64_t seed) {
  const auto triangles = triangles_of(mesh);
  return area_samples({mesh.x, mesh.y, mesh.z, triangles}, n, seed);
}

// A triangular lattice of distance 1 that covers [0, width] x [0, height] and the neighborhood of both.
std::vector<double> triangular_lattice(double width, double height) {
  std::vector<double> points;
  const double row = std::sqrt(0.75);
  for (int j = -2; j * row < height + 2; ++j)
    for (int i = -2; i < width + 2; ++i) points.insert(points.end(), {i + 0.5 * (j & 1), j * row, 0.0});
  return points;
}

}  // namespace

TEST_CASE("coverage_of: the hexagonal lattice has its closed forms") {
  // Whole cells: 1 x 1 by 2 rows of sqrt(3 / 4).
  const double height = 24 * std::sqrt(0.75), area = 20 * height;
  const PolygonMesh plane = grid_plane(3, 5, 20, height);
  const std::vector<double> lattice = triangular_lattice(20, height);
  const Coverage found = coverage_on(plane, lattice);
  CHECK(found.radius == Approx(hexagonal_hole(area, 480)).epsilon(1e-3));
  CHECK(found.radius <= hexagonal_hole(area, 480) * (1 + 1e-12));
  CHECK(found.mean == Approx(hexagonal_mean_distance(area, 480)).epsilon(1e-3));
  CHECK(hexagonal_spacing(area, 480) == Approx(1).epsilon(1e-13));
  // As ratios, of the number of points given.
  const double scale = std::sqrt(static_cast<double>(lattice.size()) / 3 / 480);
  CHECK(found.hole == Approx(scale).epsilon(1e-3));
  CHECK(found.chamfer == Approx(scale).epsilon(1e-3));
}

TEST_CASE("coverage_of: one point, and points at the corners") {
  const PolygonMesh square = grid_plane(1, 1);
  const Coverage center = coverage_on(square, std::vector<double>{0.5, 0.5, 0});
  CHECK(center.radius == Approx(std::sqrt(0.5)).epsilon(1e-3));
  // (sqrt 2 + asinh 1) / 6, the mean distance of a square to its center.
  CHECK(center.mean == Approx((std::sqrt(2.0) + std::asinh(1.0)) / 6).epsilon(2e-3));
  CHECK(center.hole == Approx(std::sqrt(0.5) / hexagonal_hole(1, 1)).epsilon(1e-3));
  // Above the square: distances are those in space.
  CHECK(coverage_on(square, std::vector<double>{0, 0, 0.5}).radius == Approx(1.5).epsilon(1e-3));
  const Coverage cube_corners =
      coverage_on(cube(), std::vector<double>{1,  1,  1, -1, 1, 1,  1, -1, 1,  1,  1,  -1,
                                              -1, -1, 1, -1, 1, -1, 1, -1, -1, -1, -1, -1});
  CHECK(cube_corners.radius == Approx(std::sqrt(2.0)).epsilon(1e-3));  // the middles of the faces
}

TEST_CASE("coverage_of: no dense set of points of the surface finds a larger hole, and some come near",
          "[statistics]") {
  const PolygonMesh bent = merged(moved(cube(), 0.4, 0.3, -0.2, 0.1), icosphere(2));
  for (const PolygonMesh& mesh : {torus(40, 20), bent, grid_plane(1, 1)})
    for (const std::uint64_t n : {std::uint64_t{3}, std::uint64_t{200}}) {
      const std::vector<double> points = samples_of(mesh, n, 5);
      const Coverage found = coverage_on(mesh, points);
      const std::vector<double> distances = distances_to_samples(points, samples_of(mesh, 400000, 9));
      const double largest = *std::max_element(distances.begin(), distances.end());
      CHECK(found.radius >= largest / (1 + 1e-3));
      CHECK(found.radius <= largest * 1.02);
      double mean = 0;
      for (const double distance : distances) mean += distance / static_cast<double>(distances.size());
      CHECK(found.mean == Approx(mean).epsilon(3e-3));
    }
}

TEST_CASE("coverage_of: the same for any number of threads, motion and triangulation, and scales") {
  const PolygonMesh mesh = torus(60, 30);
  const std::vector<double> points = samples_of(mesh, 500, 3);
  const Coverage found = coverage_on(mesh, points);
  Coverage alone;
  oneapi::tbb::task_arena(1).execute([&] { alone = coverage_on(mesh, points); });
  CHECK(found.radius == alone.radius);
  CHECK(found.mean == alone.mean);
  CHECK(found.hole == alone.hole);
  CHECK(found.chamfer == alone.chamfer);

  const Coverage other = coverage_on(mesh, points, 2);
  CHECK(other.radius == Approx(found.radius).epsilon(1e-3));
  CHECK(other.mean == Approx(found.mean).epsilon(2e-3));
  CHECK(other.mean != found.mean);

  const PolygonMesh larger = moved(mesh, 100, 5, 7, -3);
  PolygonMesh vertices;  // the points as a mesh, to move them alike
  for (std::size_t i = 0; i < points.size(); i += 3) {
    vertices.x.push_back(points[i]);
    vertices.y.push_back(points[i + 1]);
    vertices.z.push_back(points[i + 2]);
  }
  vertices = moved(vertices, 100, 5, 7, -3);
  std::vector<double> moved_points;
  for (std::size_t i = 0; i < vertices.x.size(); ++i)
    moved_points.insert(moved_points.end(), {vertices.x[i], vertices.y[i], vertices.z[i]});
  const Coverage scaled = coverage_on(larger, moved_points);
  CHECK(scaled.radius == Approx(100 * found.radius).epsilon(1e-3));
  CHECK(scaled.hole == Approx(found.hole).epsilon(1e-3));
  CHECK(scaled.chamfer == Approx(found.chamfer).epsilon(2e-3));

  const std::vector<double> flat = samples_of(grid_plane(1, 1), 300, 4);
  CHECK(coverage_on(grid_plane(1, 1), flat).radius ==
        Approx(coverage_on(grid_plane(37, 11), flat).radius).epsilon(1e-3));
}

TEST_CASE("coverage_of: needles, and what cannot be measured") {
  // A needle of a million times its width, sampled at one end.
  const PolygonMesh needle = polygon_mesh({0, 0, 0, 1, 0, 0, 1, 1e-6, 0}, {{0, 1, 2}});
  CHECK(coverage_on(needle, std::vector<double>{0, 0, 0}).radius == Approx(1).epsilon(1e-3));
  const PolygonMesh line = polygon_mesh({0, 0, 0, 1, 0, 0, 2, 0, 0}, {{0, 1, 2}});
  CHECK_THROWS_AS(coverage_on(line, std::vector<double>{0, 0, 0}), ItemError);
  CHECK_THROWS_AS(coverage_on(cube(), std::vector<double>{}), std::invalid_argument);
  CHECK_THROWS_AS(coverage_on(cube(), std::vector<double>{0, 0}), std::invalid_argument);
  CHECK_THROWS_AS(coverage_on(cube(), std::vector<double>{0, 0, NAN}), std::invalid_argument);
}

TEST_CASE("hexagonal_mean_distance: equals the mean over a hexagon") {
  // The nearest of the lattice's points over a cell of it, 1 by sqrt(3) with points at its corners and
  // middle.
  constexpr int side = 2000;
  double sum = 0, most = 0;
  for (int i = 0; i < side; ++i)
    for (int j = 0; j < side; ++j) {
      const double x = (i + 0.5) / side, y = std::sqrt(3.0) * (j + 0.5) / side;
      const double corner = std::hypot(std::min(x, 1 - x), std::min(y, std::sqrt(3.0) - y));
      const double distance = std::min(corner, std::hypot(x - 0.5, y - std::sqrt(0.75)));
      sum += distance / side / side;
      most = std::max(most, distance);
    }
  // Two points on an area of sqrt(3).
  CHECK(hexagonal_mean_distance(std::sqrt(3.0), 2) == Approx(sum).epsilon(1e-6));
  CHECK(hexagonal_hole(std::sqrt(3.0), 2) == Approx(most).epsilon(1e-3));
}
