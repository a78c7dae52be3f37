#include "kernels/query/surface_sides.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "kernels/core/random.h"
#include "kernels/mesh/prepare_mesh.h"
#include "kernels/query/shell_grid.h"
#include "kernels/query/winding_number.h"
#include "support/catch.h"
#include "support/sided_mesh.h"
#include "support/test_meshes.h"
#include "support/threads.h"

using namespace meander;
using namespace meander::test;

TEST_CASE("orient_outward: a component is turned outward, whatever the file says") {
  for (const PolygonMesh& mesh : {sphere(1), inside_out(sphere(1))}) {
    const SidedMesh sided(mesh);
    CHECK(sided.rule == SignRule::closed);
    CHECK(sided.winding_at({0.1, 0.2, 0.3}) == 1);
    CHECK(sided.winding_at({1.1, 0, 0}) == 0);
  }
  // One of two that lie side by side.
  const SidedMesh two(merged(sphere(1), inside_out(sphere(1, 3))));
  CHECK(two.winding_at({0, 0.1, 0}) == 1);
  CHECK(two.winding_at({3, 0.1, 0}) == 1);
}

TEST_CASE("orient_outward: cavities are wound against what they lie in, solids in solids are one") {
  const SidedMesh hollow(merged(sphere(1), inside_out(sphere(0.5))));
  CHECK(hollow.winding_at({0, 0.1, 0}) == 0);
  CHECK(hollow.winding_at({0, 0.7, 0}) == 1);
  const SidedMesh turned(merged(inside_out(sphere(1)), sphere(0.5)));
  CHECK(turned.winding_at({0, 0.1, 0}) == 0);
  CHECK(turned.winding_at({0, 0.7, 0}) == 1);
  for (const bool inward : {false, true}) {
    PolygonMesh both = merged(sphere(1), sphere(0.5));
    if (inward) both = inside_out(both);
    const SidedMesh solid(both);
    CHECK(solid.winding_at({0, 0.1, 0}) == 2);
    CHECK(solid.winding_at({0, 0.7, 0}) == 1);
  }
  // A solid in a cavity, and one more in that; the order of the file does not matter.
  const SidedMesh nested(
      merged(merged(sphere(0.2), sphere(0.3)), merged(inside_out(sphere(0.5)), sphere(1))));
  CHECK(nested.winding_at({0, 0.1, 0}) == 2);
  CHECK(nested.winding_at({0, 0.27, 0}) == 1);
  CHECK(nested.winding_at({0, 0.4, 0}) == 0);
  CHECK(nested.winding_at({0, 0.7, 0}) == 1);
}

TEST_CASE("orient_outward: no side is certain where it would take too long to say what lies in what") {
  PolygonMesh file = icosphere(4);
  const RandomKey key = make_random_key(1, {});
  for (std::uint32_t i = 0; i < 9000; ++i) {
    const UnitPair at = random_pair(key, Stream::sequence, i);
    const auto first = static_cast<std::uint32_t>(file.x.size());
    for (const Vector3 corner : {Vector3{0, 0, 0}, Vector3{1, 0, 0}, Vector3{0, 1, 0}, Vector3{0, 0, 1}}) {
      file.x.push_back(0.5 * at.first + 1e-4 * corner.x);
      file.y.push_back(0.5 * at.second + 1e-4 * corner.y);
      file.z.push_back(1e-4 * corner.z);
    }
    for (const std::uint32_t v : {0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2}) file.corners.push_back(first + v);
    for (int face = 0; face < 4; ++face) file.polygon_begin.push_back(file.polygon_begin.back() + 3);
  }
  const SidedMesh sided(file);
  CHECK(sided.oriented.all_closed());
  CHECK_FALSE(sided.oriented.nested);
  CHECK(sided.rule == SignRule::shell);
  const std::vector<double> point{0, 0, 0.5};
  CHECK(label_points(sided.tree, sided.oriented, SignRule::closed, point).sides.uncertain == 1);
}

TEST_CASE("orient_outward: components that overlap are one solid") {
  const SidedMesh sided(merged(sphere(1), inside_out(sphere(1, 1.2))));
  CHECK(sided.winding_at({0, 0.1, 0}) == 1);
  CHECK(sided.winding_at({0.6, 0.1, 0}) == 2);
  CHECK(sided.winding_at({1.3, 0.1, 0}) == 1);
}

TEST_CASE("orient_outward: edges of four faces, of a solid by itself and between two") {
  // Two cubes that share an edge.
  std::vector<double> xyz;
  std::vector<std::vector<std::uint32_t>> faces;
  for (const double shift : {0.0, 1.0}) {
    const auto first = static_cast<std::uint32_t>(xyz.size() / 3);
    for (int i = 0; i < 8; ++i)
      xyz.insert(xyz.end(), {shift + (i & 1), shift + (i >> 1 & 1), static_cast<double>(i >> 2)});
    for (const std::vector<std::uint32_t>& face : std::vector<std::vector<std::uint32_t>>{
             {0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}) {
      faces.emplace_back();
      for (const std::uint32_t v : face) faces.back().push_back(first + v);
    }
  }
  const SidedMesh sided(polygon_mesh(xyz, faces));
  CHECK(sided.rule == SignRule::closed);
  CHECK(sided.winding_at({0.5, 0.5, 0.5}) == 1);
  CHECK(sided.winding_at({1.5, 1.5, 0.5}) == 1);
  CHECK(sided.winding_at({1.5, 0.5, 0.5}) == 0);
}

TEST_CASE("drop_doubled_faces: one face stays of those at the same corners, and numbers stay") {
  PolygonMesh doubled = merged(cube(), inside_out(cube()));
  CHECK(drop_doubled_faces(doubled) == 6);
  CHECK(doubled.polygon_count() == 12);
  CHECK(doubled.corners.size() == 24);
  CHECK(doubled.polygon_begin[6] == 24);
  PolygonMesh single = cube();
  CHECK(drop_doubled_faces(single) == 0);
  CHECK(single.corners == cube().corners);
  // A face in the middle, whose corners begin elsewhere.
  PolygonMesh three = polygon_mesh({0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1}, {{0, 1, 2}, {1, 2, 0}, {0, 1, 3}});
  CHECK(drop_doubled_faces(three) == 1);
  CHECK(three.polygon_begin == std::vector<std::uint32_t>{0, 3, 3, 6});
  CHECK(three.corners == std::vector<std::uint32_t>{0, 1, 2, 0, 1, 3});
  for (const PolygonMesh& second : {sphere(1), inside_out(sphere(1))}) {
    const SidedMesh sided(merged(sphere(1), second));
    CHECK(sided.rule == SignRule::closed);
    CHECK(sided.winding_at({0, 0.1, 0}) == 1);
  }
}

TEST_CASE("point_sides: steps give the whole numbers of all triangles, for any thread count") {
  const SidedMesh sided(merged(merged(torus(60, 40), sphere(0.4, 0.9)), inside_out(sphere(0.2, 0.9))));
  REQUIRE(sided.rule == SignRule::closed);
  std::vector<std::uint32_t> turned = sided.mesh.triangles;
  for (std::size_t t = 0; t < sided.oriented.flipped.size(); ++t)
    if (sided.oriented.flipped[t] != 0) std::swap(turned[3 * t + 1], turned[3 * t + 2]);
  const std::vector<double> points = side_points(sided.mesh, 30000, 3);
  const PointSides found = on_threads(1, [&] { return sided.sides(points); });
  CHECK(on_threads(3, [&] { return sided.sides(points); }).winding == found.winding);
  CHECK(found.uncertain == 0);
  std::size_t wrong = 0, twice = 0;
  for (std::size_t i = 0; i < 3000; ++i) {
    const double exact = exact_winding_number(sided.mesh.x, sided.mesh.y, sided.mesh.z, turned,
                                              {points[3 * i], points[3 * i + 1], points[3 * i + 2]});
    wrong += found.winding[i] != std::round(exact) || found.inside[i] != (std::abs(exact) >= 0.5);
    twice += found.winding[i] == 2;
  }
  CHECK(wrong == 0);
  CHECK(twice > 10);
}

TEST_CASE("point_sides: points on the surface are uncertain, points beside it are not") {
  const SidedMesh sided(cube());
  std::vector<double> points;
  for (const double x : {1.0, 1.0 - 1e-9, 1.0 + 1e-9, 1.0, 0.2})
    points.insert(points.end(), {x, 0.123, 0.456});
  const PointSides found = sided.sides(sided.working(points));
  CHECK(found.certain == std::vector<std::uint8_t>{0, 1, 1, 0, 1});
  CHECK(found.inside[1] == 1);
  CHECK(found.inside[2] == 0);
  CHECK(found.inside[4] == 1);
  CHECK(found.uncertain == 2);
}

TEST_CASE("sign_rule: by winding where little is missing, by shell else") {
  const SidedMesh pierced(with_holes(icosphere(4), 0.03, 1));
  CHECK(pierced.rule == SignRule::winding);
  CHECK_FALSE(pierced.oriented.all_closed());
  CHECK_THROWS_AS(point_sides(pierced.tree, pierced.oriented, SignRule::closed, {}, {}),
                  std::invalid_argument);
  const std::vector<double> point{0.1, 0.2, 0.3};
  for (const PolygonMesh& mesh : {grid_plane(10, 10), moebius_strip(40), folded_sheet(5, 8, 0.05)}) {
    const SidedMesh sheet(mesh);
    CHECK(sheet.rule == SignRule::shell);
    const PointSides found = sheet.sides(point);
    CHECK(found.uncertain == 0);
    CHECK(found.inside[0] == 0);
    CHECK(found.winding.empty());
    const PointSides none = label_points(sheet.tree, sheet.oriented, SignRule::none, point).sides;
    CHECK(none.uncertain == 1);
    CHECK(none.inside[0] == 0);
  }
}

TEST_CASE("point_sides: by shell as by winding numbers where a surface is closed") {
  for (const PolygonMesh& mesh : {icosphere(4), torus(60, 40), inside_out(cube()),
                                  merged(sphere(1), sphere(1, 1.2)), slab_with_tunnels(3)}) {
    const SidedMesh sided(mesh);
    const std::vector<double> points = side_points(sided.mesh, 20000, 8);
    const auto shell = [&] {
      return label_points(sided.tree, sided.oriented, SignRule::shell, points).sides;
    };
    const PointSides found = on_threads(1, shell), expected = sided.sides(points);
    CHECK(on_threads(3, shell).inside == found.inside);
    CHECK(found.uncertain <= 20);
    std::size_t wrong = 0;
    for (std::size_t i = 0; i < points.size() / 3; ++i)
      wrong += found.certain[i] != 0 && found.inside[i] != expected.inside[i];
    CHECK(wrong == 0);
  }
}

TEST_CASE("point_sides: by shell narrow gaps are closed and wide ones open, and what is inside is inside") {
  const auto side_of = [](const PolygonMesh& mesh, Vector3 file) {
    const SidedMesh sided(mesh);
    const std::vector<double> point = sided.working(std::vector<double>{file.x, file.y, file.z});
    const PointSides found = label_points(sided.tree, sided.oriented, SignRule::shell, point).sides;
    return std::pair(found.inside[0] != 0, found.certain[0] != 0);
  };
  using Side = std::pair<bool, bool>;
  const Side inside{true, true}, outside{false, true};
  // The triangles of a cube, apart: gaps of 0.01 where a cell is 0.016, and of 0.2.
  for (const double gap : {0.01, 0.2}) {
    std::vector<double> xyz;
    std::vector<std::vector<std::uint32_t>> faces;
    const PolygonMesh whole = cube();
    const std::vector<std::uint32_t> corners = triangles_of(whole);
    for (std::uint32_t c = 0; c < corners.size(); ++c) {
      const std::uint32_t first = c / 3 * 3;
      const auto middle = [&](const std::vector<double>& of) {
        return (of[corners[first]] + of[corners[first + 1]] + of[corners[first + 2]]) / 3;
      };
      for (const std::vector<double>* of : {&whole.x, &whole.y, &whole.z})
        xyz.push_back((1 - gap / 2) * (*of)[corners[c]] + gap / 2 * middle(*of));
      if (c % 3 == 0) faces.push_back({c, c + 1, c + 2});
    }
    const PolygonMesh apart = polygon_mesh(xyz, faces);
    CHECK(side_of(apart, {0.1, 0, 0}) == (gap < 0.1 ? inside : outside));
    CHECK(side_of(apart, {0.97, 0.3, 0.1}) == (gap < 0.1 ? inside : outside));
    CHECK(side_of(apart, {1.05, 0.3, 0.1}) == outside);
    CHECK(side_of(apart, {7, 0.3, 0.1}) == outside);
  }
  // Cavities are not reached, however they are wound.
  for (const PolygonMesh& inner : {sphere(0.5), inside_out(sphere(0.5))}) {
    CHECK(side_of(merged(sphere(1), inner), {0, 0.1, 0}) == inside);
    CHECK(side_of(merged(sphere(1), inner), {0, 0.7, 0}) == inside);
  }
  // A plate that is thinner than a cell: uncertain within.
  const PolygonMesh plate = two_sided_plate(6, 1e-3);
  CHECK(side_of(plate, {0.52, 0.51, 0.1}) == outside);
  CHECK(side_of(plate, {0.52, 0.51, 0.002}) == outside);
  CHECK_FALSE(side_of(plate, {0.52, 0.51, 0.0005}).second);
}

TEST_CASE("build_shell_grid: has bounds") {
  const SidedMesh sided(cube());
  for (const std::size_t cells : {0, 15, 257})
    CHECK_THROWS_AS(build_shell_grid(sided.tree, cells), std::invalid_argument);
  CHECK(build_shell_grid(sided.tree, 64).count == std::array<std::size_t, 3>{64, 64, 64});
  // Fewer cells where many triangles are as large as the box.
  const RandomKey key = make_random_key(4, {});
  std::vector<double> xyz;
  std::vector<std::vector<std::uint32_t>> faces;
  for (std::uint32_t v = 0; v < 3000; ++v) {
    const UnitPair a = random_pair(key, Stream::sequence, v), b = random_pair(key, Stream::sequence, v, 1);
    xyz.insert(xyz.end(), {a.first, a.second, b.first});
    if (v % 3 == 0) faces.push_back({v, v + 1, v + 2});
  }
  const SidedMesh crowded(polygon_mesh(xyz, faces));
  CHECK(build_shell_grid(crowded.tree).count[0] <= 64);
}
