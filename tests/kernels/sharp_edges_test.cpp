#include "kernels/query/sharp_edges.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>
#include <stdexcept>

#include "kernels/core/random.h"
#include "kernels/mesh/prepare_mesh.h"
#include "kernels/sample/sequence.h"
#include "support/catch.h"
#include "support/query_meshes.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;

namespace {

// Every triangle with corners of its own, moved by up to `noise`.
PolygonMesh exploded(const PolygonMesh& mesh, double noise) {
  const RandomKey key = make_random_key(5, {});
  std::vector<double> xyz;
  std::vector<std::vector<std::uint32_t>> faces;
  for (const std::uint32_t v : triangles_of(mesh)) {
    const auto number = static_cast<std::uint32_t>(xyz.size() / 3);
    const UnitPair a = random_pair(key, Stream::sequence, number),
                   b = random_pair(key, Stream::sequence, number, 1);
    xyz.insert(xyz.end(),
               {mesh.x[v] + noise * a.first, mesh.y[v] + noise * a.second, mesh.z[v] + noise * b.first});
    if (number % 3 == 0) faces.emplace_back();
    faces.back().push_back(number);
  }
  return polygon_mesh(xyz, faces);
}

// A prism over a regular polygon; its sides are smooth where the polygon has many corners.
PolygonMesh prism(std::uint32_t corners) {
  std::vector<double> xyz;
  std::vector<std::vector<std::uint32_t>> faces(2);
  for (std::uint32_t i = 0; i < corners; ++i) {
    const double angle = 2 * std::numbers::pi * i / corners;
    xyz.insert(xyz.end(), {std::cos(angle), std::sin(angle), 0, std::cos(angle), std::sin(angle), 1});
    const std::uint32_t next = (i + 1) % corners;
    faces[0].push_back(2 * (corners - 1 - i));
    faces[1].push_back(2 * i + 1);
    faces.push_back({2 * i, 2 * next, 2 * next + 1, 2 * i + 1});
  }
  return polygon_mesh(xyz, faces);
}

// Each edge once, in the direction of its curve, and curves without gaps.
void check_curves(const PreparedMesh& mesh, const SharpEdges& edges) {
  REQUIRE(edges.curve_begin.back() == edges.count());
  REQUIRE(edges.before.size() == edges.count() + 1);
  std::set<std::pair<std::uint32_t, std::uint32_t>> seen;
  std::set<std::uint32_t> first(edges.curve_begin.begin(), edges.curve_begin.end());
  for (std::uint32_t e = 0; e < edges.count(); ++e) {
    CHECK(seen.insert(std::minmax(edges.start[e], edges.end[e])).second);
    if (first.count(e) == 0) CHECK(edges.start[e] == edges.end[e - 1]);
    const double length = distance(mesh.position(edges.start[e]), mesh.position(edges.end[e]));
    CHECK(edges.before[e + 1] - edges.before[e] == Approx(length));
  }
}

std::size_t curves(const SharpEdges& edges) { return edges.curve_begin.size() - 1; }

}  // namespace

TEST_CASE("find_sharp_edges: a cube has twelve in four curves, whatever its triangles share") {
  for (const PolygonMesh& mesh :
       {cube(), inside_out(cube()), exploded(cube(), 0), exploded(cube(), 1e-7), merged(cube(), cube()),
        merged(cube(), inside_out(cube())), moved(exploded(cube(), 1e-7), 1e3, 5e3, 1, 2)}) {
    const PreparedMesh prepared = prepare_mesh(mesh);
    const SharpEdges edges = find_sharp_edges(prepared);
    CHECK(edges.count() == 12);
    CHECK(curves(edges) == 4);
    const double side = prepared.diagonal > 100 ? 2000 : 2;
    CHECK(edges.length() * prepared.unit == Approx(12 * side).epsilon(1e-5));
    check_curves(prepared, edges);
    for (std::size_t e = 0; e < edges.count(); ++e) {
      const auto normal = [&](std::size_t k) {
        const std::uint32_t* const c = &prepared.triangles[3 * std::size_t{edges.triangle[2 * e + k]}];
        const Vector3 n = cross(prepared.position(c[1]) - prepared.position(c[0]),
                                prepared.position(c[2]) - prepared.position(c[0]));
        return (1 / norm(n)) * n;
      };
      CHECK(std::abs(dot(normal(0), normal(1))) < 1e-5);
    }
  }
  // Corners farther apart than the tolerance are none that triangles share.
  CHECK(find_sharp_edges(prepare_mesh(exploded(cube(), 1e-3))).count() == 0);
  CHECK(find_sharp_edges(prepare_mesh(exploded(cube(), 1e-3)), {30, false, 1e-2}).count() == 12);
}

TEST_CASE("find_sharp_edges: an angle decides") {
  const PreparedMesh round = prepare_mesh(prism(40)), sphere = prepare_mesh(icosphere(4));
  // Two rims of 40 edges each, a curve each, and sides that meet at 9 degrees.
  const SharpEdges rims = find_sharp_edges(round);
  CHECK(rims.count() == 80);
  CHECK(curves(rims) == 2);
  CHECK(rims.length() * round.unit == Approx(2 * 80 * std::sin(std::numbers::pi / 40)));
  check_curves(round, rims);
  for (const auto& [angle, count] :
       std::map<double, std::size_t>{{8.9, 120}, {9.1, 80}, {89.9, 80}, {90.1, 0}})
    CHECK(find_sharp_edges(round, {angle}).count() == count);
  CHECK(find_sharp_edges(sphere).count() == 0);
  CHECK(find_sharp_edges(sphere).length() == 0);
  CHECK(find_sharp_edges(prepare_mesh(torus(60, 40))).count() == 0);
}

TEST_CASE("find_sharp_edges: borders by option, and edges where more than two faces meet") {
  const PreparedMesh sheet = prepare_mesh(grid_plane(5, 5));
  CHECK(find_sharp_edges(sheet).count() == 0);
  const SharpEdges border = find_sharp_edges(sheet, {30, true});
  CHECK(border.count() == 20);
  CHECK(curves(border) == 1);
  CHECK(border.triangle[1] == no_index);
  check_curves(sheet, border);
  // A two-sided sheet ends at the same edges.
  CHECK(find_sharp_edges(prepare_mesh(merged(grid_plane(5, 5), inside_out(grid_plane(5, 5)))), {30, true})
            .count() == 20);
  // A wall that stands on a floor, along one edge of four triangles, and one that goes through.
  const std::vector<double> xyz{0, 0, 0, 1, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 1, 0, 0, -1};
  const PreparedMesh wall = prepare_mesh(polygon_mesh(xyz, {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}}));
  CHECK(find_sharp_edges(wall).count() == 1);
  CHECK(find_sharp_edges(prepare_mesh(polygon_mesh(xyz, {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}, {0, 1, 5}})))
            .count() == 1);
  CHECK(find_sharp_edges(prepare_mesh(polygon_mesh(xyz, {{0, 1, 2}, {1, 0, 3}}))).count() == 0);
}

TEST_CASE("points_on_edges: exactly N, even by length, on the edges of a cube N / 12 each") {
  const PreparedMesh mesh = prepare_mesh(cube());
  const SharpEdges edges = find_sharp_edges(mesh);
  for (std::uint64_t seed = 1; seed <= 5; ++seed)
    for (const std::uint32_t n : {1u, 100u, 1000u, 4099u}) {
      const SampleSequence sequence =
          make_sequence(SequenceKind::shifted, n, 0.25, make_random_key(seed, {}));
      const EdgePoints points = points_on_edges(mesh, edges, sequence.position);
      REQUIRE(points.edge.size() == n);
      std::vector<double> of_edge(12, 0);
      for (std::size_t i = 0; i < n; ++i) {
        ++of_edge[points.edge[i]];
        const Vector3 a = mesh.position(edges.start[points.edge[i]]),
                      b = mesh.position(edges.end[points.edge[i]]);
        const Vector3 p{points.point[3 * i], points.point[3 * i + 1], points.point[3 * i + 2]};
        CHECK(distance(p, a + points.along[i] * (b - a)) < 1e-15);
        CHECK((edges.before[points.edge[i]] + points.along[i] * distance(a, b)) / edges.length() ==
              Approx(sequence.position[i]).epsilon(1e-12));
      }
      for (const double count : of_edge) CHECK(std::abs(count - n / 12.0) <= 1);
    }
}

TEST_CASE("points_on_edges: prefixes of a progressive order are even, too") {
  const PreparedMesh mesh = prepare_mesh(prism(40));
  const SharpEdges edges = find_sharp_edges(mesh);
  const RandomKey key = make_random_key(3, {});
  const SampleSequence sequence = make_sequence(SequenceKind::shifted, 4096, 0.25, key);
  const std::vector<std::uint32_t> order = progressive_order(4096, key);
  std::vector<double> shares;
  for (const std::uint32_t rank : order) shares.push_back(sequence.position[rank]);
  const EdgePoints points = points_on_edges(mesh, edges, shares);
  for (const std::size_t prefix : {64, 512, 4096}) {
    // Sixteen parts of the length.
    std::vector<double> counts(16, 0);
    for (std::size_t i = 0; i < prefix; ++i) {
      const std::uint32_t e = points.edge[i];
      const double along = edges.before[e] + points.along[i] * (edges.before[e + 1] - edges.before[e]);
      ++counts[std::min<std::size_t>(15, static_cast<std::size_t>(16 * along / edges.length()))];
    }
    for (const double count : counts) CHECK(std::abs(count - static_cast<double>(prefix) / 16) <= 1);
  }
}

TEST_CASE("find_sharp_edges, points_on_edges: refuse what makes no sense") {
  const PreparedMesh mesh = prepare_mesh(cube());
  for (const double angle : {0.0, 180.0, -1.0, std::nan("")})
    CHECK_THROWS_AS(find_sharp_edges(mesh, {angle}), std::invalid_argument);
  for (const double tolerance : {-1e-9, 0.02, std::nan("")})
    CHECK_THROWS_AS(find_sharp_edges(mesh, {30, false, tolerance}), std::invalid_argument);
  const SharpEdges edges = find_sharp_edges(mesh), none = find_sharp_edges(prepare_mesh(icosphere(3)));
  for (const double share : {1.0, -0.1, std::nan("")})
    CHECK_THROWS_AS(points_on_edges(mesh, edges, std::vector<double>{share}), std::invalid_argument);
  CHECK_THROWS_AS(points_on_edges(mesh, none, std::vector<double>{0.5}), std::invalid_argument);
  CHECK(points_on_edges(mesh, none, {}).edge.empty());
}

TEST_CASE("find_sharp_edges: real models, the same of their soups") {
  MEANDER_NEEDS_SHARED_DATA();
  for (const char* name :
       {"paper/fandisk.off", "dirty/trimesh_angle_block.STL", "dirty/common3d_teapot.obj"}) {
    INFO(name);
    const PolygonMesh file = model_of(name);
    const PreparedMesh mesh = prepare_mesh(file), soup = prepare_mesh(exploded(file, 0));
    const SharpEdges edges = find_sharp_edges(mesh), of_soup = find_sharp_edges(soup);
    check_curves(mesh, edges);
    CHECK(edges.count() > 50);
    CHECK(edges.count() == of_soup.count());
    CHECK(edges.length() == Approx(of_soup.length()));
  }
}

TEST_CASE("find_sharp_edges: flat edges between two classes are sharp, those of doubled faces are not") {
  const PolygonMesh file = grid_plane(4, 4);
  const PreparedMesh sheet = prepare_mesh(file);
  std::vector<double> classes;
  for (std::size_t p = 0; p < file.polygon_count(); ++p) classes.push_back(p < 16 ? 1 : std::nan(""));
  const SharpEdges between = find_sharp_edges(sheet, {.classes = classes});
  CHECK(between.count() == 4);
  CHECK(curves(between) == 1);
  CHECK(between.length() * sheet.unit == Approx(1));
  check_curves(sheet, between);
  for (std::size_t e = 0; e < 4; ++e)
    CHECK(std::abs(sheet.position(between.start[e]).y - sheet.position(between.end[e]).y) < 1e-12);
  CHECK(find_sharp_edges(sheet, {.classes = std::vector<double>(32, 7)}).count() == 0);
  std::vector<double> doubled(32, 7);
  doubled.resize(64, 8);
  CHECK(find_sharp_edges(prepare_mesh(merged(file, file)), {.classes = doubled}).count() == 0);
  CHECK_THROWS_AS(find_sharp_edges(sheet, {.classes = std::vector<double>(31, 7)}), std::invalid_argument);
}

TEST_CASE("sharp_corners: where other than two edges meet, or where two turn") {
  const auto corners = [](const PolygonMesh& mesh, double angle, bool borders = false) {
    const PreparedMesh prepared = prepare_mesh(mesh);
    const SharpEdges edges = find_sharp_edges(prepared, {.borders = borders});
    std::set<std::uint32_t> at;
    for (const EdgeEnd& end : sharp_corners(prepared, edges, angle))
      CHECK(at.insert((end.is_start ? edges.start : edges.end)[end.edge]).second);
    return at.size();
  };
  CHECK(corners(cube(), 30) == 8);
  CHECK(corners(merged(cube(), inside_out(cube())), 30) == 8);
  CHECK(corners(exploded(cube(), 1e-7), 30) == 8);
  // Rims of a prism turn by 9 degrees at each of 40 corners.
  CHECK(corners(prism(40), 30) == 0);
  CHECK(corners(prism(40), 8.9) == 80);
  CHECK(corners(grid_plane(5, 5), 30, true) == 4);
  CHECK(corners(grid_plane(5, 5), 91, true) == 0);
  CHECK(corners(icosphere(2), 30) == 0);
}
