// Triangles that cross: found as by looking at all pairs, and parted in remeshed surfaces.
#include <cmath>
#include <numbers>

#include "kernels/core/random.h"
#include "kernels/remesh/crossing_triangles.h"
#include "kernels/remesh/remesh_surface.h"
#include "kernels/remeshed_mesh.h"
#include "support/catch.h"
#include "support/sanitized.h"
#include "support/test_meshes.h"
#include "support/threads.h"

using namespace meander;
using namespace meander::test;

namespace {

// By looking at all pairs.
template <class Vertices, class Corners>
std::uint64_t crossings_of_all(std::size_t count, const Vertices& vertices, const Corners& corners) {
  std::vector<SpaceBox> boxes;
  for (std::size_t t = 0; t < count; ++t) boxes.push_back(box_of(corners(t)));
  std::uint64_t found = 0;
  for (std::size_t t = 0; t < count; ++t)
    for (std::size_t u = t + 1; u < count; ++u)
      found += boxes[t].meets(boxes[u]) && !share_a_vertex(vertices(t), vertices(u)) &&
               triangles_cross(corners(t), corners(u));
  return found;
}

std::uint64_t crossings_of(const RemeshedSurface& mesh) {
  const auto vertices = [&](std::size_t t) {
    return TriangleVertices{mesh.triangles[3 * t], mesh.triangles[3 * t + 1], mesh.triangles[3 * t + 2]};
  };
  const auto at = [&](std::uint32_t v) { return Vector3{mesh.x[v], mesh.y[v], mesh.z[v]}; };
  return crossings_of_all(mesh.triangles.size() / 3, vertices, [&](std::size_t t) {
    const TriangleVertices v = vertices(t);
    return TriangleCorners{at(v[0]), at(v[1]), at(v[2])};
  });
}

// The outside and the inside of a ball with a hollow.
PolygonMesh shell(double thickness) {
  PolygonMesh inside = moved(icosphere(4), 1 - thickness, 0, 0, 0);
  for (std::size_t c = 0; c < inside.corners.size(); c += 3)
    std::swap(inside.corners[c], inside.corners[c + 1]);
  return merged(icosphere(4), inside);
}

}  // namespace

TEST_CASE("crossings: triangles cross if an edge of one passes through the inside of the other") {
  const TriangleCorners flat = {Vector3{-1, -1, 0}, Vector3{1, -1, 0}, Vector3{0, 1, 0}};
  const TriangleCorners through = {Vector3{0, 0, -1}, Vector3{0, 0, 1}, Vector3{0, 5, 0}};
  const TriangleCorners above = {Vector3{0, 0, 0.1}, Vector3{0, 0, 1}, Vector3{0, 5, 0.1}};
  CHECK(triangles_cross(flat, through));
  CHECK(triangles_cross(through, flat));
  CHECK_FALSE(triangles_cross(flat, above));
  // With a common vertex: the edge opposite to it goes through, or does not.
  const TriangleCorners turned = {Vector3{-1, -1, 0}, Vector3{0.5, 0, -1}, Vector3{0.5, 0, 1}};
  const TriangleCorners aside = {Vector3{-1, -1, 0}, Vector3{5, 0, -1}, Vector3{5, 0, 1}};
  CHECK(triangles_overlap({0, 1, 2}, flat, {0, 3, 4}, turned) ==
        triangles_overlap({0, 3, 4}, turned, {0, 1, 2}, flat));
  CHECK(triangles_overlap({0, 1, 2}, flat, {0, 3, 4},
                          {Vector3{-1, -1, 0}, Vector3{0, -0.5, -1}, Vector3{0, -0.5, 1}}));
  CHECK_FALSE(
      triangles_overlap({0, 1, 2}, flat, {0, 3, 4}, {aside[0], Vector3{-5, 0, -1}, Vector3{-5, 0, 1}}));
  // With a common edge: folded onto each other, or beside each other.
  CHECK(triangles_overlap({0, 1, 2}, flat, {1, 0, 3}, {flat[1], flat[0], Vector3{0, 1, 1e-3}}));
  CHECK_FALSE(triangles_overlap({0, 1, 2}, flat, {1, 0, 3}, {flat[1], flat[0], Vector3{0, -3, 0}}));
}

TEST_CASE("crossings: pairs equal a comparison of all with all") {
  const RandomKey key = make_random_key(11, {});
  std::vector<TriangleCorners> soup;
  for (std::uint32_t i = 0; i < 400; ++i) {
    const auto point = [&](std::uint32_t k) {
      const auto [a, b] = random_pair(key, Stream::test_shapes, i, 2 * k);
      const double c = random_pair(key, Stream::test_shapes, i, 2 * k + 1).first;
      return Vector3{2 * a - 1, 2 * b - 1, 2 * c - 1};
    };
    const Vector3 center = point(0);
    soup.push_back({center, center + 0.4 * point(1), center + 0.4 * point(2)});
  }
  const auto vertices = [](std::size_t t) {
    const auto first = static_cast<std::uint32_t>(3 * t);
    return TriangleVertices{first, first + 1, first + 2};
  };
  const std::uint64_t expected =
      crossings_of_all(soup.size(), vertices, [&](std::size_t t) { return soup[t]; });
  REQUIRE(expected > 20);
  const auto box = [&](std::size_t t) { return box_of(soup[t]); };
  const auto cross = [&](std::size_t t, std::size_t u) { return triangles_cross(soup[t], soup[u]); };
  const BoxSearch boxes(soup.size(), box);
  const CrossingPairs all = crossing_pairs(boxes, soup.size(), 400, {}, box, cross, [] {});
  CHECK(all.count == expected);
  CHECK(all.pairs.size() == expected);
  const CrossingPairs few = crossing_pairs(boxes, soup.size(), 1, {}, box, cross, [] {});
  CHECK(few.count == expected);
  CHECK(few.pairs.size() < expected);
  CHECK((all.is_whole && few.is_whole));
  // A search that ends at its bound has a part of the pairs, the same for any number of threads.
  const auto search = [&] {
    return crossing_pairs(boxes, soup.size(), 400, CrossingSearchBound{500}, box, cross, [] {});
  };
  const CrossingPairs part = on_threads(1, search);
  CHECK_FALSE(part.is_whole);
  CHECK(part.count < expected);
  CHECK(part.count > 0);
  CHECK(on_threads(2, search).count == part.count);
}

TEST_CASE("crossings: the search among needles at one point ends at its limit, and says so") {
  // The boxes of all needles of a quarter of a cone meet.
  constexpr std::uint32_t needles = 12000;
  std::vector<double> xyz = {0, 0, 0};
  std::vector<std::vector<std::uint32_t>> faces;
  for (std::uint32_t i = 0; i <= needles; ++i) {
    const double angle = 0.5 * std::numbers::pi * i / needles;
    xyz.insert(xyz.end(), {std::cos(angle), std::sin(angle), 0.1 * (i % 2) + 1});
    if (i > 0) faces.push_back({0, i, i + 1});
  }
  const Remeshed result = remeshed(polygon_mesh(xyz, faces), 2000, {}, SequenceKind::spaced);
  CHECK(result.mesh.report.partial_search == 1);
  CHECK(result.mesh.report.crossings == 0);
  CHECK(remeshed(icosphere(4), 600, {}, SequenceKind::spaced).mesh.report.partial_search == 0);
}

TEST_CASE("crossings: the two sides of a thin shell are separated") {
  for (const bool fit : {false, true})
    for (const double thickness : {0.02, 0.005})
      for (const std::uint32_t n : {60u, 300u}) {
        if (sanitized && (fit != (n == 60) || fit != (thickness < 0.01))) continue;  // release builds try all
        INFO(n << " samples, thickness " << thickness << (fit ? ", fitted" : ""));
        RemeshParameters wanted;
        wanted.fit = fit;
        const Remeshed result = remeshed(shell(thickness), n, wanted, SequenceKind::spaced);
        check_result(result, fit);
        CHECK(crossings_of(result.mesh) == 0);
        CHECK(result.mesh.report.crossings == 0);
        CHECK(result.mesh.report.input_crossings == 0);
        CHECK(result.mesh.report.components == 2);
        if (n == 60 && thickness < 0.01) CHECK(result.mesh.report.kept_vertices > 0);
      }
}

TEST_CASE("crossings: those of the input surface itself are distinguished") {
  const PolygonMesh crossed = merged(icosphere(4), moved(icosphere(4), 1, 1.1, 0.2, 0.1));
  const Remeshed result = remeshed(crossed, 600, {}, SequenceKind::spaced);
  check_result(result);
  CHECK(result.mesh.report.input_crossings > 10);
  CHECK(result.mesh.report.crossings == 0);
  CHECK(crossings_of(result.mesh) == result.mesh.report.input_crossings);
}

TEST_CASE("crossings: repaired in the same way for every number of threads", "[release]") {
  RemeshParameters fit;
  fit.fit = true;
  const std::uint32_t n = sanitized ? 50 : 100;
  const Remeshed one = on_threads(1, [&] { return remeshed(shell(0.005), n, fit); });
  const Remeshed four = on_threads(4, [&] { return remeshed(shell(0.005), n, fit); });
  CHECK(one.mesh.triangles == four.mesh.triangles);
  CHECK(one.mesh.x == four.mesh.x);
  CHECK(one.mesh.report.kept_vertices == four.mesh.report.kept_vertices);
  CHECK(one.mesh.report.crossings == 0);
}

TEST_CASE("crossings: those of a cluster of needles are counted, repaired or not") {
  // A strip of small triangles that share one vertex far away: long needles side by side.
  std::vector<double> positions = {1e5, 1e5, 0};
  for (std::uint32_t k = 0; k < 30; ++k)
    positions.insert(positions.end(), {0.01 * k, 0.01 * (k % 2), 0.01 * (k % 3)});
  std::vector<std::vector<std::uint32_t>> faces;
  for (std::uint32_t k = 1; k + 2 <= 30; ++k) {
    faces.push_back({k, k + 1, k + 2});
    faces.push_back({0, k, k + 2});
  }
  const Remeshed result = remeshed(polygon_mesh(positions, faces), 200, {}, SequenceKind::spaced);
  CHECK(result.mesh.report.crossings + result.mesh.report.input_crossings > 0);
  CHECK(crossings_of(result.mesh) == result.mesh.report.crossings + result.mesh.report.input_crossings);
}
