#include "kernels/mesh/prepare_mesh.h"
#include "kernels/mesh/weld_vertices.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <utility>
#include <vector>

#include "kernels/mesh/triangulate_polygon.h"
#include "kernels/public/sampler.h"
#include "support/catch.h"
#include "support/sanitized.h"
#include "support/sparse_memory.h"
#include "support/test_meshes.h"
#include "support/threads.h"

using namespace meander;
using namespace meander::test;

namespace {

Status status_of(const PolygonMesh& mesh) {
  try {
    prepare_mesh(mesh);
  } catch (const ItemError& error) {
    return error.status();
  }
  return Status::ok;
}

double file_area(const PreparedMesh& mesh) { return mesh.total_area * mesh.unit * mesh.unit; }

// Every postcondition that later stages rely on.
void check_invariants(const PreparedMesh& mesh) {
  const std::size_t half_edges = 3 * mesh.triangle_count();
  REQUIRE(mesh.opposite.size() == half_edges);
  const auto is_paired = [&](std::uint32_t h) {
    const std::uint32_t other = mesh.opposite[h];
    return other == no_index ||
           (mesh.opposite.at(other) == h && mesh.triangles[h] == mesh.triangles[next_half_edge(other)] &&
            mesh.triangles[other] == mesh.triangles[next_half_edge(h)]);
  };
  std::uint32_t paired = 0;  // an assertion for each would take most of the time
  while (paired < half_edges && is_paired(paired)) ++paired;
  REQUIRE(paired == half_edges);
  std::uint32_t triangle = 0, vertex = 0;
  for (const Component& c : mesh.components) {
    REQUIRE(c.triangle_begin == triangle);
    REQUIRE(c.vertex_begin == vertex);
    std::uint32_t within = 3 * c.triangle_begin;
    while (within < 3 * c.triangle_end && mesh.triangles[within] >= c.vertex_begin &&
           mesh.triangles[within] < c.vertex_end)
      ++within;
    REQUIRE(within == 3 * c.triangle_end);
    triangle = c.triangle_end;
    vertex = c.vertex_end;
  }
  REQUIRE(triangle == mesh.triangle_count());
  REQUIRE(vertex == mesh.vertex_count());
}

// A wavy grid of more than 2^19 triangles in `strips` strips, triangles and quadrilaterals, row by row or in
// random order; with seams, bad faces and unused vertices. Strips have no edge in common.
PolygonMesh large_mesh(std::uint32_t strips, bool in_order) {
  constexpr std::uint32_t columns = 1201, rows = 251;
  std::mt19937 random(5);
  PolygonMesh mesh;
  const auto add_vertex = [&](double column, double row) {
    mesh.x.push_back(0.01 * column);
    mesh.y.push_back(0.01 * row);
    mesh.z.push_back(0.2 * std::sin(0.013 * column) * std::cos(0.02 * row));
    return static_cast<std::uint32_t>(mesh.x.size() - 1);
  };
  for (std::uint32_t row = 0; row < rows; ++row)
    for (std::uint32_t column = 0; column < columns; ++column) add_vertex(column, row);
  std::vector<std::vector<std::uint32_t>> faces;
  for (std::uint32_t row = 0; row + 1 < rows; ++row)
    for (std::uint32_t column = 0; column + 1 < columns; ++column) {
      if (strips > 1 && column % (columns / strips) == 0) continue;  // a gap between strips
      std::uint32_t a = row * columns + column;
      const std::uint32_t b = a + 1, c = b + columns, d = a + columns;
      if (random() % 16 == 0) a = add_vertex(column, row);  // the same place by another number
      if (random() % 8 == 0) {
        faces.push_back({a, b, c, d});
      } else {
        faces.push_back({a, b, c});
        faces.push_back({a, c, d});
      }
    }
  const auto nowhere = static_cast<std::uint32_t>(mesh.x.size()) + 7, infinite = add_vertex(0, 0);
  mesh.x[infinite] = std::numeric_limits<double>::infinity();
  add_vertex(-300, 3);  // of no face
  for (std::uint32_t k = 0; k < 50; ++k) {
    faces.push_back({k, k + 1, nowhere});
    faces.push_back({k, k + 1, infinite});
    faces.push_back({k, k, k + 1});
    faces.push_back({k, k + 1});
  }
  if (!in_order) std::shuffle(faces.begin(), faces.end(), random);
  mesh.polygon_begin.push_back(0);
  for (const std::vector<std::uint32_t>& face : faces) {
    mesh.corners.insert(mesh.corners.end(), face.begin(), face.end());
    mesh.polygon_begin.push_back(static_cast<std::uint32_t>(mesh.corners.size()));
  }
  return mesh;
}

void check_same(const PreparedMesh& a, const PreparedMesh& b) {
  CHECK(a.bbox == b.bbox);
  CHECK(a.unit == b.unit);
  CHECK(a.x == b.x);
  CHECK(a.y == b.y);
  CHECK(a.z == b.z);
  CHECK(a.triangles == b.triangles);
  CHECK(a.opposite == b.opposite);
  CHECK(a.corner_slot == b.corner_slot);
  CHECK(a.polygon == b.polygon);
  CHECK(a.area == b.area);
  CHECK(a.total_area == b.total_area);
  CHECK(a.unreferenced_vertices == b.unreferenced_vertices);
  CHECK(a.repairs.counts == b.repairs.counts);
  REQUIRE(a.components.size() == b.components.size());
  for (std::size_t c = 0; c < a.components.size(); ++c) {
    CHECK(a.components[c].triangle_begin == b.components[c].triangle_begin);
    CHECK(a.components[c].triangle_end == b.components[c].triangle_end);
    CHECK(a.components[c].vertex_begin == b.components[c].vertex_begin);
    CHECK(a.components[c].vertex_end == b.components[c].vertex_end);
    CHECK(a.components[c].boundary_loops == b.components[c].boundary_loops);
    CHECK(a.components[c].genus == b.components[c].genus);
    CHECK(a.components[c].area == b.components[c].area);
  }
}

}  // namespace

TEST_CASE("prepare_mesh: blocks of polygons without a triangle") {
  PolygonMesh file;
  file.polygon_begin = {0};
  const auto add = [&](const std::vector<std::uint32_t>& face) {
    file.corners.insert(file.corners.end(), face.begin(), face.end());
    file.polygon_begin.push_back(static_cast<std::uint32_t>(file.corners.size()));
  };
  file.x = {0, 1, 0};
  file.y = {0, 0, 1};
  file.z = {0, 0, 0};
  constexpr std::uint32_t bad = 200000;
  add({0, 1, 1});
  add({0, 1, 2});
  for (std::uint32_t k = 0; k < bad; ++k) add({0, 1});
  const PreparedMesh mesh = prepare_mesh(file);
  REQUIRE(mesh.triangle_count() == 1);
  CHECK(mesh.polygon[0] == 1);
  CHECK(mesh.repairs[Repair::short_faces] == bad);
  CHECK(mesh.repairs[Repair::repeated_corners] == 1);
}

TEST_CASE("prepare_mesh: a large mesh with every defect is the same with any number of threads") {
  for (const auto& [strips, in_order] : {std::pair{1u, true}, {40u, true}, {40u, false}}) {
    CAPTURE(strips, in_order);
    if (sanitized && strips > 1 && in_order) continue;  // release builds prepare all three
    const PolygonMesh file = large_mesh(strips, in_order);
    const auto prepared = [&](std::size_t threads) {
      return on_threads(threads, [&] { return prepare_mesh(file); });
    };
    const PreparedMesh one = prepared(1);
    check_invariants(one);
    REQUIRE(one.triangle_count() > std::size_t{1} << 19);
    REQUIRE(one.vertex_count() > std::size_t{1} << 18);
    CHECK(one.components.size() == strips);
    CHECK(one.unreferenced_vertices > 1);
    for (const Component& c : one.components) {
      CHECK(c.boundary_loops == 1);
      CHECK(c.genus == 0);
    }
    CHECK(one.repairs[Repair::index_out_of_range] == 50);
    CHECK(one.repairs[Repair::non_finite] == 50);
    CHECK(one.repairs[Repair::repeated_corners] == 50);
    CHECK(one.repairs[Repair::short_faces] == 50);
    CHECK(one.repairs[Repair::welded_vertices] > 10000);
    for (const std::size_t threads : {2u, 8u})
      if (!sanitized || threads == 2) check_same(one, prepared(threads));  // release builds compare both
    if (strips > 1) continue;
    const auto soup = [&](std::size_t threads) {
      return on_threads(threads, [&] { return prepare_soup(file); });
    };
    check_same(soup(1), soup(8));
  }
}

TEST_CASE("prepare_mesh: closed shapes keep their topology and area") {
  const PreparedMesh sphere = prepare_mesh(icosphere(3));
  check_invariants(sphere);
  REQUIRE(sphere.components.size() == 1);
  CHECK(sphere.components[0].genus == 0);
  CHECK(sphere.components[0].boundary_loops == 0);
  CHECK(file_area(sphere) == Approx(4 * std::numbers::pi).epsilon(0.01));

  const PreparedMesh ring = prepare_mesh(torus(20, 10));
  check_invariants(ring);
  CHECK(ring.components[0].genus == 1);
  const PreparedMesh box = prepare_mesh(cube());
  check_invariants(box);
  CHECK(file_area(box) == Approx(24).epsilon(1e-14));
  CHECK(box.triangle_count() == 12);
  CHECK(box.diagonal == Approx(std::sqrt(12.0)));
}

TEST_CASE("prepare_mesh: a plane has one boundary loop, an annulus two") {
  CHECK(prepare_mesh(grid_plane(4, 3)).components[0].boundary_loops == 1);
  PolygonMesh annulus = torus(12, 6);  // leaving out one ring of quads leaves a tube
  PolygonMesh tube = annulus;
  tube.corners.clear();
  tube.polygon_begin = {0};
  for (std::size_t p = 0; p < annulus.polygon_count(); ++p) {
    if (p % 12 < 2) continue;
    tube.corners.insert(tube.corners.end(), annulus.corners.begin() + 3 * static_cast<std::ptrdiff_t>(p),
                        annulus.corners.begin() + 3 * static_cast<std::ptrdiff_t>(p) + 3);
    tube.polygon_begin.push_back(static_cast<std::uint32_t>(tube.corners.size()));
  }
  const PreparedMesh prepared = prepare_mesh(tube);
  check_invariants(prepared);
  CHECK(prepared.components[0].boundary_loops == 2);
  CHECK(prepared.components[0].genus == 0);
}

TEST_CASE("prepare_mesh: an unwelded cube soup becomes one closed cube") {
  const PolygonMesh closed = cube();
  std::vector<double> xyz;
  std::vector<std::vector<std::uint32_t>> faces;
  for (const std::uint32_t corner : closed.corners) {
    if (xyz.size() / 3 % 4 == 0) faces.emplace_back();
    faces.back().push_back(static_cast<std::uint32_t>(xyz.size() / 3));
    xyz.insert(xyz.end(),
               {closed.x[corner] == -1 ? -1.0 : closed.x[corner], closed.y[corner], closed.z[corner]});
  }
  const PreparedMesh mesh = prepare_mesh(polygon_mesh(xyz, faces));
  check_invariants(mesh);
  CHECK(mesh.components.size() == 1);
  CHECK(mesh.vertex_count() == 8);
  CHECK(mesh.repairs[Repair::welded_vertices] == 16);
}

TEST_CASE("weld_vertices: positions with colliding hashes are welded by sorting") {
  // Of the two steps of the hash of x and y (weld_vertices.cpp), y undoes what x does.
  // A table alone would take the square of their number in steps.
  constexpr std::uint32_t positions = sanitized ? 30000 : 300000;
  PolygonMesh mesh;
  for (int copy = 0; copy < 2; ++copy)
    for (std::uint32_t i = 0; i < positions; ++i) {
      const double x = 1 + i;
      const auto bits = std::bit_cast<std::uint64_t>(x);
      const auto y = std::bit_cast<double>(std::uint64_t{0x3FF0000000000000u} -
                                           (bits ^ (bits >> 32)) * 0x9E3779B97F4A7C15u);
      if (!std::isfinite(y)) continue;
      mesh.x.push_back(x);
      mesh.y.push_back(y);
      mesh.z.push_back(0);
    }
  const std::vector<std::uint8_t> used(mesh.vertex_count(), 1);
  RepairCounts repairs;
  const std::vector<std::uint32_t> welded = weld_vertices(mesh, used, repairs);
  const auto half = static_cast<std::uint32_t>(welded.size() / 2);
  REQUIRE(half > positions - positions / 500);
  CHECK(repairs[Repair::welded_vertices] == half);
  for (std::uint32_t v = 0; v < half; ++v) {
    if (welded[v] != v || welded[v + half] != v) FAIL("vertex " << v << " is " << welded[v]);
  }
}

TEST_CASE("prepare_mesh: negative zero welds with zero") {
  const PreparedMesh mesh = prepare_mesh(
      polygon_mesh({0, 0, 0, 1, 0, 0, 0, 1, 0, -0.0, 1, 0, 1, 0, -0.0, 1, 1, 0}, {{0, 1, 2}, {4, 5, 3}}));
  CHECK(mesh.components.size() == 1);
  CHECK(mesh.vertex_count() == 4);
}

TEST_CASE("prepare_mesh: two cubes that share an edge are separated at it") {
  PolygonMesh second = cube();
  for (double& x : second.x) x += 2;
  for (double& y : second.y) y += 2;
  const PreparedMesh mesh = prepare_mesh(merged(cube(), second));
  check_invariants(mesh);
  CHECK(mesh.repairs[Repair::split_edges] == 1);
  CHECK(file_area(mesh) == Approx(48).epsilon(1e-14));
}

TEST_CASE("prepare_mesh: a bow-tie vertex is split into one vertex per fan") {
  const PreparedMesh mesh =
      prepare_mesh(polygon_mesh({0, 0, 0, 1, 0, 0, 1, 1, 0, -1, 0, 0, -1, -1, 0}, {{0, 1, 2}, {0, 3, 4}}));
  check_invariants(mesh);
  CHECK(mesh.components.size() == 2);
  CHECK(mesh.vertex_count() == 6);
  CHECK(mesh.repairs[Repair::split_vertices] == 1);
}

TEST_CASE("prepare_mesh: a Moebius strip is cut and becomes orientable") {
  const PreparedMesh mesh = prepare_mesh(moebius_strip(24));
  check_invariants(mesh);
  CHECK(mesh.repairs[Repair::cut_edges] >= 1);
  CHECK(mesh.components[0].genus == 0);
  CHECK(mesh.triangle_count() == 48);
}

TEST_CASE("prepare_mesh: reversed faces are flipped to the orientation of most of the area") {
  PolygonMesh mesh = icosphere(2);
  for (std::size_t t = 0; t < mesh.corners.size(); t += 12)
    std::swap(mesh.corners[t + 1], mesh.corners[t + 2]);
  const PreparedMesh prepared = prepare_mesh(mesh);
  check_invariants(prepared);
  CHECK(prepared.repairs[Repair::flipped_faces] == 80);
  CHECK(prepared.components.size() == 1);
  for (std::size_t t = 0; t < prepared.triangle_count(); ++t) {  // every normal points outwards
    const Vector3 a = prepared.position(prepared.triangles[3 * t]),
                  b = prepared.position(prepared.triangles[3 * t + 1]),
                  c = prepared.position(prepared.triangles[3 * t + 2]);
    REQUIRE(dot(cross(b - a, c - a), a) > 0);
  }
}

TEST_CASE("prepare_mesh: a face stored twice counts twice") {
  PolygonMesh mesh = tetrahedron();
  const double area = file_area(prepare_mesh(mesh));
  mesh.corners.insert(mesh.corners.end(), {0, 1, 2});
  mesh.polygon_begin.push_back(15);
  const PreparedMesh twice = prepare_mesh(mesh);
  check_invariants(twice);
  CHECK(file_area(twice) == Approx(area * 1.25).epsilon(1e-14));
}

TEST_CASE("prepare_mesh: bad faces are dropped and counted, file numbers are kept") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const PreparedMesh mesh = prepare_mesh(polygon_mesh({0, 0, 0, 1, 0, 0, 0, 1, 0, nan, 0, 0, 5, 5, 5},
                                                      {{0, 1}, {0, 1, 9}, {0, 1, 3}, {0, 0, 1}, {0, 1, 2}}));
  CHECK(mesh.repairs[Repair::short_faces] == 1);
  CHECK(mesh.repairs[Repair::index_out_of_range] == 1);
  CHECK(mesh.repairs[Repair::non_finite] == 1);
  CHECK(mesh.repairs[Repair::repeated_corners] == 1);
  CHECK(mesh.unreferenced_vertices == 2);
  REQUIRE(mesh.triangle_count() == 1);
  CHECK(mesh.polygon[0] == 4);
  CHECK(mesh.corner_slot[0] == 11);
}

TEST_CASE("prepare_mesh: a mesh that cannot be sampled has a named status") {
  const double infinity = std::numeric_limits<double>::infinity();
  CHECK(status_of(PolygonMesh{}) == Status::empty);
  CHECK(status_of(polygon_mesh({0, 0, 0, 1, 0, 0}, {})) == Status::empty);
  CHECK(status_of(polygon_mesh({0, 0, 0, 1, 0, 0}, {{0, 1}})) == Status::empty);
  CHECK(status_of(polygon_mesh({0, 0, 0, 1, 0, 0, 0, 1, 0}, {{0, 1, 3}})) == Status::index_out_of_range);
  CHECK(status_of(polygon_mesh({0, 0, 0, 1, 0, 0, 0, infinity, 0}, {{0, 1, 2}})) == Status::non_finite);
  CHECK(status_of(polygon_mesh({0, 0, 0, 1, 1, 1, 2, 2, 2}, {{0, 1, 2}})) == Status::zero_area);
  CHECK(status_of(polygon_mesh({1, 1, 1, 1, 1, 1, 1, 1, 1}, {{0, 1, 2}})) == Status::zero_area);
}

TEST_CASE("prepare_mesh: extreme scales and origins are normalized away") {
  for (const double scale : {1e-30, 1e-3, 1.0, 1e30}) {
    const PreparedMesh mesh = prepare_mesh(moved(icosphere(2), scale, scale, 2 * scale, -3 * scale));
    CHECK(file_area(mesh) == Approx(file_area(prepare_mesh(icosphere(2))) * scale * scale).epsilon(1e-12));
    for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
      REQUIRE(std::abs(mesh.x[v]) <= 1);
      REQUIRE(std::abs(mesh.y[v]) <= 1);
      REQUIRE(std::abs(mesh.z[v]) <= 1);
    }
  }
}

TEST_CASE("prepare_mesh: zero-area triangles stay for adjacency and are counted") {
  const PreparedMesh mesh = prepare_mesh(polygon_mesh({0, 0, 0, 2, 0, 0, 0, 2, 0, 1, 0, 0, 1, -1, 0},
                                                      {{0, 1, 2}, {0, 3, 1}, {0, 4, 3}, {3, 4, 1}}));
  check_invariants(mesh);
  CHECK(mesh.components.size() == 1);
  CHECK(mesh.repairs[Repair::zero_area_faces] == 1);
}

TEST_CASE("prepare_mesh: a face without area does not extend the bounds") {
  const PolygonMesh whole = cube();
  const PreparedMesh expected = prepare_mesh(whole), expected_soup = prepare_soup(whole);
  const auto far = static_cast<std::uint32_t>(whole.vertex_count());
  struct Case {
    std::vector<std::array<double, 3>> points;
    std::vector<std::uint32_t> face;
  };
  for (const double size : {3.0, 1e4, 1e8, 1e17, 1e300}) {
    const std::vector<Case> cases = {
        {{{size, size, size}}, {0, far, far}},                                         // a repeated corner,
        {{{size, 0, 0}, {size / 2, 0, 0}, {0, 0, 0}}, {far, far + 1, far + 2}},        // collinear ones,
        {{{size, size, size}, {size / 2, size / 2, size / 2}, {-size, -size, -size}},  // through all axes,
         {far, far + 1, far + 2}},
        {{{size, 2, 1}, {size, 2, 1}, {size, 2, 1}}, {far, far + 1, far + 2}},  // a facet in one point,
        {{{size, 2, 1}, {1, 2, 1}, {size, 2, 1}}, {far, far + 1, far + 2}},     // there and back,
        {{{.1 * size, .2 * size, .3 * size},                                    // with rounding,
          {.27 * size, .54 * size, .81 * size},
          {-.33 * size, -.66 * size, -.99 * size}},
         {far, far + 1, far + 2}},
        {{{size, 0, 0}, {0, 0, 0}}, {far, far + 1, far, far + 1}}};  // and a polygon
    for (std::size_t k = 0; k < cases.size(); ++k) {
      INFO(size << " case " << k);
      PolygonMesh mesh = whole;
      for (const auto& point : cases[k].points) {
        mesh.x.push_back(point[0]);
        mesh.y.push_back(point[1]);
        mesh.z.push_back(point[2]);
      }
      mesh.corners.insert(mesh.corners.end(), cases[k].face.begin(), cases[k].face.end());
      mesh.polygon_begin.push_back(static_cast<std::uint32_t>(mesh.corners.size()));
      for (const bool topology : {true, false}) {
        const PreparedMesh made = topology ? prepare_mesh(mesh) : prepare_soup(mesh);
        const PreparedMesh& wanted = topology ? expected : expected_soup;
        CHECK(made.bbox == wanted.bbox);
        CHECK(made.diagonal == wanted.diagonal);
        CHECK(made.total_area == wanted.total_area);
        CHECK(made.triangle_count() == wanted.triangle_count());
        for (std::size_t v = 0; v < made.vertex_count(); ++v) CHECK(std::abs(made.x[v]) <= 1);
        if (topology) check_invariants(made);
      }
    }
  }
}

TEST_CASE("prepare_mesh: distant parts with area are unchanged") {
  PolygonMesh mesh =
      polygon_mesh({0, 0, 0, 1, 0, 0, 0, 1, 0, 1e6, 0, 0, 1e6 + 1, 0, 0, 1e6, 1, 0}, {{0, 1, 2}, {3, 4, 5}});
  const PreparedMesh made = prepare_mesh(mesh);
  CHECK(made.bbox == std::array<double, 6>{0, 0, 0, 1e6 + 1, 1, 0});
  CHECK(made.triangle_count() == 2);
  // Thin, but not by rounding.
  const PreparedMesh needle = prepare_mesh(
      polygon_mesh({0, 0, 0, 1, 0, 0, 0, 1, 0, 1000, 0, 0, 1000, 1e-6, 0}, {{0, 1, 2}, {0, 3, 4}}));
  CHECK(needle.bbox[3] == 1000);
}

TEST_CASE("prepare_soup: on a consistent component the triangles of prepare_mesh, without adjacency") {
  for (const PolygonMesh& mesh : {torus(12, 8), icosphere(2), cube()}) {
    const PreparedMesh full = prepare_mesh(mesh), soup = prepare_soup(mesh);
    CHECK(full.has_topology());
    CHECK(!soup.has_topology());
    CHECK(soup.area == full.area);
    CHECK(soup.total_area == full.total_area);
    CHECK(soup.corner_slot == full.corner_slot);
    CHECK(soup.polygon == full.polygon);
    CHECK(soup.bbox == full.bbox);
    CHECK(soup.repairs.counts == full.repairs.counts);
    REQUIRE(soup.components.size() == 1);
    CHECK(soup.components[0].triangle_end == soup.triangle_count());
    for (std::size_t h = 0; h < soup.triangles.size(); ++h) {
      CHECK(soup.triangles[h] == mesh.corners[soup.corner_slot[h]]);
      CHECK(distance(soup.position(soup.triangles[h]), full.position(full.triangles[h])) == 0);
    }
  }
}

TEST_CASE("prepare_soup: keeps the order and winding of the file, whatever its components") {
  PolygonMesh mesh = merged(moved(torus(10, 6), 1, 5, 0, 0), icosphere(1));
  std::swap(mesh.corners[4], mesh.corners[5]);  // the second triangle, against its neighbors
  const PreparedMesh full = prepare_mesh(mesh), soup = prepare_soup(mesh);
  REQUIRE(full.repairs[Repair::flipped_faces] == 1);
  CHECK(soup.repairs[Repair::flipped_faces] == 0);
  CHECK(full.components.size() == 2);
  CHECK(soup.components.size() == 1);
  CHECK(soup.triangles == mesh.corners);
  CHECK(soup.total_area == Approx(full.total_area).epsilon(1e-14));
}

TEST_CASE("prepare_soup: repeated positions in a face, unused and infinite vertices") {
  PolygonMesh mesh = cube();
  const double infinity = std::numeric_limits<double>::infinity();
  for (const double at : {0.0, infinity}) {  // a copy of a vertex below, and one that nothing uses
    mesh.x.push_back(at == 0 ? mesh.x[0] : at);
    mesh.y.push_back(at == 0 ? mesh.y[0] : at);
    mesh.z.push_back(at == 0 ? mesh.z[0] : at);
  }
  const auto copy = static_cast<std::uint32_t>(mesh.vertex_count() - 2);
  mesh.corners.insert(mesh.corners.begin(), {0, copy, 1});
  for (std::uint32_t& begin : mesh.polygon_begin) begin += 3;
  mesh.polygon_begin.insert(mesh.polygon_begin.begin(), 0);
  const PreparedMesh full = prepare_mesh(mesh), soup = prepare_soup(mesh);
  CHECK(soup.repairs[Repair::repeated_corners] == 1);
  CHECK(full.repairs[Repair::repeated_corners] == 1);
  CHECK(soup.polygon == full.polygon);
  CHECK(soup.area == full.area);
  CHECK(soup.unreferenced_vertices == full.unreferenced_vertices);
  for (const std::vector<double>* const row : {&soup.x, &soup.y, &soup.z})
    for (const double w : *row) CHECK(std::abs(w) <= 1);
}

TEST_CASE("prepare_soup: a mesh that cannot be sampled has the status of prepare_mesh") {
  const auto status_of_soup = [](const PolygonMesh& mesh) {
    try {
      prepare_soup(mesh);
    } catch (const ItemError& error) {
      return error.status();
    }
    return Status::ok;
  };
  PolygonMesh point = cube(), line = cube(), nowhere = cube(), infinite = cube();
  for (std::vector<double>* const row : {&point.x, &point.y, &point.z}) row->assign(row->size(), 1.0);
  for (std::vector<double>* const row : {&line.y, &line.z}) row->assign(row->size(), 0.0);
  for (std::uint32_t& corner : nowhere.corners) corner += 1000;
  infinite.x.assign(infinite.x.size(), NAN);
  for (const PolygonMesh& mesh : {point, line, nowhere, infinite, PolygonMesh()}) {
    CHECK(status_of_soup(mesh) == status_of(mesh));
    CHECK(status_of_soup(mesh) != Status::ok);
  }
}

TEST_CASE("triangulate_polygon: a convex polygon is fanned, a concave one clipped, areas agree") {
  std::vector<std::uint32_t> triangles;
  const std::vector<Vector3> square = {{0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
  CHECK_FALSE(triangulate_polygon(square, triangles));
  CHECK(triangles == std::vector<std::uint32_t>{0, 1, 2, 0, 2, 3});

  // An L and a five-pointed star outline in a tilted plane.
  const auto tilt = [](double x, double y) { return Vector3{x, 0.6 * y, 0.8 * y}; };
  std::vector<Vector3> shape = {tilt(0, 0), tilt(2, 0), tilt(2, 1), tilt(1, 1), tilt(1, 2), tilt(0, 2)};
  const auto area_of = [&](const std::vector<Vector3>& p) {
    triangles.clear();
    CHECK(triangulate_polygon(p, triangles));
    REQUIRE(triangles.size() == 3 * (p.size() - 2));
    double area = 0;
    for (std::size_t t = 0; t < triangles.size(); t += 3)
      area += triangle_area(p[triangles[t]], p[triangles[t + 1]], p[triangles[t + 2]]);
    return area;
  };
  CHECK(area_of(shape) == Approx(3).epsilon(1e-12));
  shape.clear();
  double exact = 0;
  std::vector<std::pair<double, double>> flat;
  for (int i = 0; i < 10; ++i) {
    const double r = i % 2 ? 0.3 : 1, s = std::numbers::pi * i / 5;
    flat.emplace_back(r * std::cos(s), r * std::sin(s));
    shape.push_back(tilt(flat.back().first, flat.back().second));
  }
  for (std::size_t i = 0; i < 10; ++i) {
    const auto [ax, ay] = flat[i];
    const auto [bx, by] = flat[(i + 1) % 10];
    exact += 0.5 * (ax * by - ay * bx);
  }
  CHECK(area_of(shape) == Approx(exact).epsilon(1e-12));
}

TEST_CASE("triangulate_polygon: a bridge to a hole and a polygon without area still cover every corner") {
  // A square with a square hole, joined by a bridge that is walked twice.
  const std::vector<Vector3> holed = {{0, 0, 0}, {3, 0, 0}, {3, 3, 0}, {0, 3, 0}, {0, 0, 0},
                                      {1, 1, 0}, {1, 2, 0}, {2, 2, 0}, {2, 1, 0}, {1, 1, 0}};
  std::vector<std::uint32_t> triangles;
  triangulate_polygon(holed, triangles);
  REQUIRE(triangles.size() == 24);
  double area = 0;
  for (std::size_t t = 0; t < triangles.size(); t += 3)
    area += triangle_area(holed[triangles[t]], holed[triangles[t + 1]], holed[triangles[t + 2]]);
  CHECK(area == Approx(8).epsilon(1e-12));
  triangles.clear();
  CHECK_FALSE(
      triangulate_polygon(std::vector<Vector3>{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}}, triangles));
  CHECK(triangles.size() == 6);
}

TEST_CASE("Sampler: arrays with more corners than 32 bits can number are refused before they are copied") {
  constexpr std::size_t corners = std::size_t{3} * 1431655766;
  const SparseMemory memory(corners * sizeof(std::uint32_t));
  if (!memory) {
    WARN("skipped: no address space");
    return;
  }
  const std::vector<double> positions = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  const SampledModel row =
      Sampler().sample({positions, {reinterpret_cast<const std::uint32_t*>(memory.data()), corners}});
  CHECK(row.report.status == Status::unsupported_format);
  CHECK(row.report.reason == "4294967298 corners are more than 32 bits can number");
}

TEST_CASE("prepare_mesh: a polygon that repeats a vertex many times is scanned once") {
  // As many corners as would take minutes one by one.
  PolygonMesh mesh = polygon_mesh({0, 0, 0, 1, 0, 0, 2, 0, 0, 1, 1, 0}, {{1, 2, 3}});
  std::vector<std::uint32_t> corners(200000, 0);
  corners.insert(corners.end(), mesh.corners.begin(), mesh.corners.end());
  mesh.corners = corners;
  mesh.polygon_begin = {0, 200000, 200003};
  const PreparedMesh made = prepare_mesh(mesh);
  CHECK(made.bbox == std::array<double, 6>{1, 0, 0, 2, 1, 0});
  CHECK(made.triangle_count() == 1);
}
