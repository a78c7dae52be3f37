#include "kernels/query/winding_number.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>

#include "kernels/core/random.h"
#include "kernels/mesh/prepare_mesh.h"
#include "kernels/query/nearest_triangle.h"
#include "kernels/query/segment_crossings.h"
#include "support/catch.h"
#include "support/query_meshes.h"
#include "support/test_meshes.h"
#include "support/threads.h"

using namespace meander;
using namespace meander::test;

namespace {

TriangleTree tree_over(const PreparedMesh& mesh) {
  return build_triangle_tree(mesh.x, mesh.y, mesh.z, mesh.triangles);
}

double exact_at(const PreparedMesh& mesh, std::span<const double> points, std::size_t i) {
  return exact_winding_number(mesh.x, mesh.y, mesh.z, mesh.triangles,
                              {points[3 * i], points[3 * i + 1], points[3 * i + 2]});
}

// A third of the points in the box and around it, the others beside the surface, a third of them closely.
std::vector<double> winding_points(const PreparedMesh& mesh, std::size_t count, std::uint64_t seed) {
  const RandomKey key = make_random_key(seed, {});
  std::vector<double> points;
  for (std::size_t i = 0; i < count; ++i) {
    const UnitPair u = random_pair(key, Stream::sequence, i), v = random_pair(key, Stream::sequence, i, 1);
    const Vector3 in_box{2.4 * u.first - 1.2, 2.4 * u.second - 1.2, 2.4 * v.first - 1.2};
    const auto t = static_cast<std::size_t>(v.second * static_cast<double>(mesh.triangle_count()));
    const Vector3 beside = mesh.centroid(t) + (i % 3 == 1 ? 0.1 : 1e-3) * in_box;
    const Vector3 p = i % 3 == 0 ? in_box : beside;
    points.insert(points.end(), {p.x, p.y, p.z});
  }
  return points;
}

// Triangles that share nothing, of corners up to `size` apart.
PolygonMesh random_soup(std::size_t triangles, double size) {
  const RandomKey key = make_random_key(3, {});
  std::vector<double> xyz;
  std::vector<std::vector<std::uint32_t>> faces;
  for (std::size_t t = 0; t < triangles; ++t) {
    const UnitPair at = random_pair(key, Stream::sequence, t), z = random_pair(key, Stream::sequence, t, 1);
    for (std::uint32_t k = 0; k < 3; ++k) {
      const UnitPair u = random_pair(key, Stream::sequence, t, 2 + k),
                     v = random_pair(key, Stream::sequence, t, 5 + k);
      xyz.insert(xyz.end(),
                 {at.first + size * u.first, at.second + size * u.second, z.first + size * v.first});
    }
    const auto first = static_cast<std::uint32_t>(3 * t);
    faces.push_back({first, first + 1, first + 2});
  }
  return polygon_mesh(xyz, faces);
}

}  // namespace

TEST_CASE("exact_winding_number: whole numbers of closed surfaces, a share of the sphere of a square") {
  for (const bool inward : {false, true}) {
    const PreparedMesh mesh = prepare_mesh(inward ? inside_out(icosphere(2)) : icosphere(2));
    const auto at = [&](Vector3 p) {
      return exact_winding_number(mesh.x, mesh.y, mesh.z, mesh.triangles, p);
    };
    CHECK(at({0, 0, 0}) == Approx(inward ? -1 : 1));
    CHECK(at({0.1, 0.35, -0.3}) == Approx(inward ? -1 : 1));
    CHECK(at({0.9, 0.9, 0.9}) == Approx(0).margin(1e-12));
  }
  const PolygonMesh square = grid_plane(3, 3);
  const PreparedMesh mesh = prepare_mesh(square);
  const double side = mesh.unit;  // file units a working unit
  for (const double h : {0.02, 0.3, 2.0}) {
    // Seen from the height d above the middle of a square of the side a: 4 atan(a^2 / (2 d sqrt(4 d^2 + 2
    // a^2))).
    const double a = 1 / side;
    const double angle = 4 * std::atan(a * a / (2 * h * std::sqrt(4 * h * h + 2 * a * a)));
    const double above = exact_winding_number(mesh.x, mesh.y, mesh.z, mesh.triangles, {0, 0, h});
    CHECK(std::abs(above) == Approx(angle / (16 * std::atan(1.0))));
    CHECK(exact_winding_number(mesh.x, mesh.y, mesh.z, mesh.triangles, {0, 0, -h}) == Approx(-above));
  }
}

TEST_CASE("winding_numbers: errors stay within their bound, of closed surfaces, sheets and soups") {
  for (const PolygonMesh& mesh : {cube(), icosphere(4), torus(60, 30), grid_plane(40, 40), moebius_strip(400),
                                  random_soup(3000, 0.05), random_soup(400, 0.7)}) {
    const PreparedMesh prepared = prepare_mesh(mesh);
    const TriangleTree tree = tree_over(prepared);
    const std::vector<double> points = winding_points(prepared, 600, 5);
    std::vector<double> exact;
    double largest = 0;
    for (std::size_t i = 0; i < points.size() / 3; ++i) {
      exact.push_back(exact_at(prepared, points, i));
      const double by_products = short_winding_number(prepared.x, prepared.y, prepared.z, prepared.triangles,
                                                      {points[3 * i], points[3 * i + 1], points[3 * i + 2]});
      largest = std::max(largest, std::abs(by_products - exact.back()));
    }
    CHECK(largest < 1e-11);
    double before = 0;
    for (const double bound : {1e-3, 0.02, 0.5}) {
      const std::vector<double> fast = winding_numbers(build_winding_tree(tree, {}, bound), points);
      double worst = 0;
      for (std::size_t i = 0; i < exact.size(); ++i) worst = std::max(worst, std::abs(fast[i] - exact[i]));
      INFO(prepared.triangle_count() << " triangles, bound " << bound << ", worst " << worst);
      CHECK(worst <= bound + 2e-5);
      // Nodes do stand for their triangles where there are many.
      if (prepared.triangle_count() > 1000 && bound == 0.5) CHECK(worst > 2 * before);
      before = worst;
    }
  }
}

TEST_CASE("winding_numbers: far away, and turned over triangle by triangle") {
  const PreparedMesh sphere = prepare_mesh(icosphere(3));
  const TriangleTree tree = tree_over(sphere);
  const std::vector<std::uint8_t> all(sphere.triangle_count(), 1);
  const std::vector<double> points{0, 0, 0, 0.2, 0.3, 0.1, 3, 4, 5, 1e6, 0, 0, 1e12, 1e12, 1e12};
  const std::vector<double> w = winding_numbers(build_winding_tree(tree, {}, 0.01), points),
                            turned = winding_numbers(build_winding_tree(tree, all, 0.01), points);
  for (std::size_t i = 0; i < w.size(); ++i) {
    CHECK(w[i] == Approx(i < 2 ? 1 : 0).margin(1e-3));
    CHECK(turned[i] == Approx(-w[i]).margin(1e-6));
  }
}

TEST_CASE("winding_numbers: the same for every thread count, order of the points and instruction set") {
  const PreparedMesh mesh = prepare_mesh(torus(80, 40));
  const TriangleTree tree = on_threads(1, [&] { return tree_over(mesh); });
  const TriangleTree same_tree = on_threads(3, [&] { return tree_over(mesh); });
  const WindingTree winding = build_winding_tree(tree, {}, 0.2),
                    same = build_winding_tree(same_tree, {}, 0.2);
  const std::vector<double> points = winding_points(mesh, 20000, 9);
  const std::vector<double> expected = on_threads(1, [&] { return winding_numbers(winding, points); });
  CHECK(on_threads(3, [&] { return winding_numbers(same, points); }) == expected);
  CHECK(winding_numbers(winding, points, {}, InstructionSet::scalar) == expected);
  for (std::size_t i = 0; i < 50; ++i)
    CHECK(winding_number(winding, {points[3 * i], points[3 * i + 1], points[3 * i + 2]}) == expected[i]);
}

TEST_CASE("winding_numbers: refuses what it cannot answer") {
  const PreparedMesh mesh = prepare_mesh(cube());
  const TriangleTree tree = tree_over(mesh);
  CHECK_THROWS_AS(build_winding_tree(tree, {}, 0), std::invalid_argument);
  CHECK_THROWS_AS(build_winding_tree(tree, {}, std::numeric_limits<double>::quiet_NaN()),
                  std::invalid_argument);
  CHECK_THROWS_AS(build_winding_tree(tree, std::vector<std::uint8_t>(3), 0.1), std::invalid_argument);
  const WindingTree winding = build_winding_tree(tree, {}, 0.1);
  CHECK_THROWS_AS(winding_numbers(winding, std::vector<double>{0, 0}), std::invalid_argument);
  CHECK_THROWS_AS(winding_numbers(winding, std::vector<double>{0, 0, 1e300}), std::invalid_argument);
  CHECK(winding_numbers(winding, {}).empty());
}

TEST_CASE("segment_crossings: how much winding numbers differ, and nothing where an edge is in the way") {
  // Two spheres that overlap, the second inside out.
  const PreparedMesh mesh =
      prepare_mesh(merged(icosphere(3), inside_out(moved(icosphere(2), 0.8, 0.7, 0.1, 0.2))));
  const TriangleTree tree = tree_over(mesh);
  const std::vector<double> points = winding_points(mesh, 600, 21);
  std::vector<std::uint32_t> positions(tree.count());
  std::iota(positions.begin(), positions.end(), 0u);
  std::size_t crossed = 0, unsure = 0;
  for (std::size_t i = 0; i + 1 < points.size() / 3; ++i) {
    const Vector3 a{points[3 * i], points[3 * i + 1], points[3 * i + 2]},
        b{points[3 * i + 3], points[3 * i + 4], points[3 * i + 5]};
    const SegmentCrossings found = segment_crossings(tree, {}, a, b);
    const bool free = found.sure && found.count == 0;
    CHECK(is_free_segment(tree, a, b) == free);
    CHECK(is_free_segment(tree, a, b, positions) == free);
    CHECK(is_free_segment(tree, a, b, std::span(positions).first(i % 7)) == free);
    if (!found.sure) {
      ++unsure;
      continue;
    }
    crossed += found.outward != 0;
    CHECK(found.outward == std::lround(exact_at(mesh, points, i) - exact_at(mesh, points, i + 1)));
  }
  CHECK(crossed > 100);
  CHECK(unsure == 0);
  const Vector3 corner = mesh.position(mesh.triangles[0]),
                middle = 0.5 * (corner + mesh.position(mesh.triangles[1]));
  for (const Vector3 through : {corner, middle}) {
    const Vector3 outward = 0.01 * through;
    CHECK_FALSE(segment_crossings(tree, {}, through - outward, through + outward).sure);
    CHECK_FALSE(segment_crossings(tree, {}, through - outward, through).sure);
  }
  const std::vector<std::uint8_t> all(mesh.triangle_count(), 1);
  const Vector3 center = mesh.centroid(0);
  const int outward = segment_crossings(tree, {}, 0.99 * center, 1.01 * center).outward;
  CHECK(std::abs(outward) == 1);
  CHECK(segment_crossings(tree, all, 0.99 * center, 1.01 * center).outward == -outward);
}

TEST_CASE("winding_numbers: real models, within the bound of the exact ones", "[release]") {
  MEANDER_NEEDS_SHARED_DATA();
  for (const std::string& name : query_models()) {
    const PreparedMesh mesh = prepare_mesh(model_of(name));
    const TriangleTree tree = tree_over(mesh);
    const std::vector<double> points = winding_points(mesh, 45, 11);
    const std::vector<double> strict = winding_numbers(build_winding_tree(tree, {}, 0.02), points),
                              usual = winding_numbers(build_winding_tree(tree, {}, 10), points);
    for (std::size_t i = 0; i < strict.size(); ++i) {
      const double exact = exact_at(mesh, points, i);
      INFO(name << " " << i << " " << exact);
      CHECK(std::abs(strict[i] - exact) <= 0.02 + 2e-5);
      // What sides are told by, where it is not near the threshold: far below its bound.
      CHECK(std::abs(usual[i] - exact) <= 0.1);
    }
  }
}
