#include "kernels/analyse/point_location.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "kernels/core/random.h"
#include "support/catch.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;

namespace {

const EmbreeDevice& device() {
  static const EmbreeDevice instance;
  return instance;
}

Vector3 position(const PolygonMesh& mesh, std::uint32_t v) { return {mesh.x[v], mesh.y[v], mesh.z[v]}; }

// The smallest value of a convex function on [0, 1], by ternary search.
template <class Function>
double least(const Function& function) {
  double low = 0, high = 1;
  for (int i = 0; i < 80; ++i) {
    const double s = low + (high - low) / 3, t = high - (high - low) / 3;
    const bool left = function(s) < function(t);
    (left ? high : low) = left ? t : s;
  }
  return function(0.5 * (low + high));
}

// The slow way: the distance is convex in the two weights.
double distance_by_search(Vector3 p, Vector3 a, Vector3 b, Vector3 c) {
  return least([&](double v) {
    return least([&](double u) { return distance(p, a + ((1 - v) * u) * (b - a) + v * (c - a)); });
  });
}

std::vector<Vector3> random_points(std::size_t count, double size, std::uint64_t seed) {
  const RandomKey key = make_random_key(seed, {});
  std::vector<Vector3> points;
  for (std::size_t i = 0; i < count; ++i) {
    const UnitPair u = random_pair(key, Stream::sequence, i), v = random_pair(key, Stream::sequence, i, 1);
    points.push_back({size * (2 * u.first - 1), size * (2 * u.second - 1), size * (2 * v.first - 1)});
  }
  return points;
}

}  // namespace

TEST_CASE("SurfaceLocator: one triangle, all regions, against a search") {
  const PolygonMesh mesh = polygon_mesh({0, 0, 0, 2, 0.3, 0.1, 0.4, 1.1, -0.5}, {{0, 1, 2}});
  const SurfaceLocator surface(device(), mesh.x, mesh.y, mesh.z, triangles_of(mesh));
  const Vector3 a = position(mesh, 0), b = position(mesh, 1), c = position(mesh, 2);
  for (const Vector3 p : random_points(150, 3, 1)) {
    const SurfacePoint found = surface.nearest(p);
    CHECK(found.distance == Approx(distance_by_search(p, a, b, c)).epsilon(1e-9));
    CHECK(distance(p, found.point) == Approx(found.distance).epsilon(1e-13));
    CHECK(found.triangle == 0);
    CHECK(found.weight1 >= 0);
    CHECK(found.weight2 >= 0);
    CHECK(found.weight1 + found.weight2 <= 1 + 1e-15);
    const Vector3 q = a + found.weight1 * (b - a) + found.weight2 * (c - a);
    CHECK(distance(q, found.point) < 1e-14);
  }
}

TEST_CASE("SurfaceLocator: the same as searching every triangle") {
  for (const PolygonMesh& mesh :
       {torus(24, 15), two_sided_plate(6, 1e-9), moved(icosphere(2), 1e-3, 100, -50, 7),
        moved(torus(15, 10), 1e25, 1e27, 0, 0)}) {
    const std::vector<std::uint32_t> triangles = triangles_of(mesh);
    const SurfaceLocator surface(device(), mesh.x, mesh.y, mesh.z, triangles);
    // Each triangle as a mesh of its own.
    Vector3 low = position(mesh, 0), high = low;
    for (std::uint32_t v = 0; v < mesh.x.size(); ++v) {
      const Vector3 p = position(mesh, v);
      low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
      high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
    }
    const Vector3 center = 0.5 * (low + high);
    const double size = distance(low, high);
    std::vector<Vector3> queries;
    for (const Vector3 p : random_points(12, size, 3)) queries.push_back(center + p);
    for (std::uint32_t v = 0; v < mesh.x.size(); v += 29) queries.push_back(position(mesh, v));
    std::vector<double> best(queries.size(), std::numeric_limits<double>::infinity());
    for (std::size_t t = 0; t < triangles.size(); t += 3) {
      const SurfaceLocator one(device(), mesh.x, mesh.y, mesh.z, std::span(triangles).subspan(t, 3));
      for (std::size_t q = 0; q < queries.size(); ++q)
        best[q] = std::min(best[q], one.nearest(queries[q]).distance);
    }
    const double offset = norm(center);
    for (std::size_t q = 0; q < queries.size(); ++q)
      CHECK(surface.nearest(queries[q]).distance ==
            Approx(best[q]).epsilon(1e-13).margin(1e-15 * (size + offset)));
  }
}

TEST_CASE("SurfaceLocator: a sphere from inside, outside, far away and its center") {
  const PolygonMesh sphere = icosphere(4);
  const SurfaceLocator surface(device(), sphere.x, sphere.y, sphere.z, triangles_of(sphere));
  // Edges are below 0.083: the polyhedron lies up to 1.2e-3 (h^2 / 6) inside.
  for (const Vector3 p : random_points(200, 2, 5)) {
    const double exact = std::abs(norm(p) - 1);
    CHECK(surface.nearest(p).distance == Approx(exact).margin(1.3e-3));
  }
  CHECK(surface.nearest({0, 0, 0}).distance == Approx(1).margin(1.3e-3));
  for (const double far : {1e3, 1e9, 1e16, 1e30}) {
    const SurfacePoint found = surface.nearest({far, far, 0});
    CHECK(found.distance == Approx(std::sqrt(2.0) * far - 1).epsilon(1e-5));
    CHECK(std::abs(found.point.z) < 1);
  }
}

TEST_CASE("SurfaceLocator: ties go to the lowest triangle, vertices are exact") {
  const PolygonMesh mesh = icosphere(2);
  const std::vector<std::uint32_t> triangles = triangles_of(mesh);
  const SurfaceLocator surface(device(), mesh.x, mesh.y, mesh.z, triangles);
  for (std::uint32_t v = 0; v < mesh.x.size(); ++v) {
    const SurfacePoint found = surface.nearest(position(mesh, v));
    CHECK(found.distance == 0);
    const auto first = std::find(triangles.begin(), triangles.end(), v);
    CHECK(found.triangle == static_cast<std::uint32_t>((first - triangles.begin()) / 3));
  }
  // The same triangle many times over.
  const PolygonMesh stack = polygon_mesh({0, 0, 0, 1, 0, 0, 0, 1, 0}, {{0, 1, 2}});
  std::vector<std::uint32_t> many;
  for (int i = 0; i < 1000; ++i) many.insert(many.end(), {0, 1, 2});
  const SurfaceLocator pile(device(), stack.x, stack.y, stack.z, many);
  CHECK(pile.nearest({0.2, 0.3, 0.4}).triangle == 0);
  CHECK(pile.nearest({0.2, 0.3, 0.4}).distance == Approx(0.4));
}

TEST_CASE("SurfaceLocator: triangles without area are segments and points") {
  const PolygonMesh needle = polygon_mesh({0, 0, 0, 1, 0, 0, 3, 0, 0}, {{0, 1, 2}});
  const SurfaceLocator segment(device(), needle.x, needle.y, needle.z, triangles_of(needle));
  CHECK(segment.nearest({2, 3, 0}).distance == Approx(3));
  CHECK(segment.nearest({-3, 4, 0}).distance == Approx(5));
  CHECK(segment.nearest({6, 4, 0}).distance == Approx(5));
  const std::vector<std::uint32_t> repeated{1, 1, 1};
  const SurfaceLocator point(device(), needle.x, needle.y, needle.z, repeated);
  CHECK(point.nearest({1, 3, 4}).distance == Approx(5));
  // A sliver: 1e-9 wide.
  const PolygonMesh sliver = polygon_mesh({0, 0, 0, 1, 0, 0, 0.5, 1e-9, 0}, {{0, 1, 2}});
  const SurfaceLocator thin(device(), sliver.x, sliver.y, sliver.z, triangles_of(sliver));
  for (const double at : {0.1, 0.49, 0.7}) {
    CHECK(thin.nearest({at, 0.2, 0}).distance == Approx(0.2).margin(2e-9));
    CHECK(thin.nearest({at, 0, 0.2}).distance == Approx(0.2).epsilon(1e-12));
  }
}

TEST_CASE("locate_points: the answers of nearest, and invalid arguments are refused") {
  const PolygonMesh mesh = torus(20, 12);
  const SurfaceLocator surface(device(), mesh.x, mesh.y, mesh.z, triangles_of(mesh));
  std::vector<double> points;
  for (const Vector3 p : random_points(20000, 1.5, 9)) points.insert(points.end(), {p.x, p.y, p.z});
  const SurfaceLocations found = locate_points(surface, points);  // enough to run in parallel
  REQUIRE(found.triangle.size() == 20000);
  for (std::size_t i = 0; i < 20000; i += 37) {
    const SurfacePoint one = surface.nearest({points[3 * i], points[3 * i + 1], points[3 * i + 2]});
    CHECK(found.triangle[i] == one.triangle);
    CHECK(found.distance[i] == one.distance);
    CHECK(found.barycentric[2 * i] == one.weight1);
    CHECK(found.barycentric[2 * i + 1] == one.weight2);
  }
  CHECK(locate_points(surface, {}).distance.empty());
  CHECK_THROWS_AS(locate_points(surface, std::vector<double>{1, 2}), std::invalid_argument);
  CHECK_THROWS_AS(locate_points(surface, std::vector<double>{1, 2, std::nan("")}), std::invalid_argument);
  const std::vector<double> x{0, 1, 0}, y{0, 0, 1}, z{0, std::nan(""), 0};
  const std::vector<std::uint32_t> none, beyond{0, 1, 3}, whole{0, 1, 2}, part{0, 1};
  CHECK_THROWS_AS(SurfaceLocator(device(), x, y, y, none), std::invalid_argument);
  CHECK_THROWS_AS(SurfaceLocator(device(), x, y, y, beyond), std::invalid_argument);
  CHECK_THROWS_AS(SurfaceLocator(device(), x, y, y, part), std::invalid_argument);
  CHECK_THROWS_AS(SurfaceLocator(device(), x, y, z, whole), std::invalid_argument);
}
