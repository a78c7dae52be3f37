// Meshes of samples: topology, boundaries, creases, degenerate input, determinism.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <tuple>

#include "kernels/remesh/insert_samples.h"
#include "kernels/remeshed_mesh.h"
#include "support/catch.h"
#include "support/shared_mesh.h"
#include "support/test_meshes.h"
#include "support/threads.h"

using namespace meander;
using namespace meander::test;

namespace {

double volume_of(const RemeshedSurface& mesh) {
  double volume = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); t += 3) {
    const auto at = [&](std::size_t k) {
      const std::uint32_t v = mesh.triangles[t + k];
      return Vector3{mesh.x[v], mesh.y[v], mesh.z[v]};
    };
    volume += dot(at(0), cross(at(1), at(2))) / 6;
  }
  return volume;
}

// Mean distance of the centroids of the triangles from the unit sphere, in units of its radius.
double error_on_sphere(const Remeshed& result) {
  double sum = 0;
  const RemeshedSurface& mesh = result.mesh;
  for (std::size_t t = 0; t < mesh.triangles.size(); t += 3) {
    Vector3 center;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t v = mesh.triangles[t + k];
      center = center + (1. / 3) * Vector3{mesh.x[v], mesh.y[v], mesh.z[v]};
    }
    sum += std::abs(norm(to_file(result.model.surface, center)) - 1);
  }
  return sum / static_cast<double>(mesh.report.faces);
}

}  // namespace

TEST_CASE("remesh: closed surfaces keep their topology, and every sample is a vertex") {
  const std::array<PolygonMesh, 5> meshes = {icosphere(3), torus(40, 20), slab_with_tunnels(3),
                                             two_sided_plate(12, 0.01),
                                             merged(icosphere(2), moved(torus(20, 10), 1, 4, 0, 0))};
  for (const PolygonMesh& mesh : meshes)
    for (const std::uint32_t n : {1u, 2u, 5u, 30u, 300u, 1200u}) {
      INFO(n << " samples of " << mesh.polygon_count() << " faces");
      check_result(remeshed(mesh, n));
    }
}

TEST_CASE("remesh: smooth closed surfaces have no vertices other than the samples") {
  const Remeshed sphere = remeshed(icosphere(4), 200), ring = remeshed(torus(60, 30), 200);
  CHECK(sphere.mesh.origin.empty());
  CHECK(sphere.mesh.report.faces == 2 * 200 - 4);
  CHECK(ring.mesh.origin.empty());
  CHECK(ring.mesh.report.euler == 0);
}

TEST_CASE("remesh: a flat sheet keeps its boundary, its corners and its area") {
  for (const std::uint32_t n : {1u, 20u, 400u}) {
    const Remeshed sheet = remeshed(grid_plane(30, 30), n);
    check_result(sheet);
    const PreparedMesh again = prepare_mesh(as_file(sheet.mesh));
    CHECK(again.total_area * again.unit * again.unit == Approx(sheet.model.surface.total_area).epsilon(1e-6));
    std::size_t corners = 0;
    for (const std::uint32_t v : sheet.mesh.origin) {
      if (v == no_index) continue;
      const Vector3 at = to_file(sheet.model.surface, sheet.model.surface.position(v));
      corners += (at.x == 0 || at.x == 1) && (at.y == 0 || at.y == 1);
    }
    CHECK(corners == 4);
    CHECK(sheet.mesh.report.kept_vertices == 0);
  }
}

TEST_CASE("remesh: the creases of a cube are kept, and with them its volume") {
  for (const std::uint32_t n : {8u, 100u, 1500u}) {
    const Remeshed box = remeshed(cube(), n);
    check_result(box);
    const double unit = box.model.surface.unit;
    CHECK(volume_of(box.mesh) * unit * unit * unit == Approx(8).epsilon(1e-5));
    CHECK(box.mesh.report.line_vertices >= 8);
  }
  RemeshParameters smooth;
  smooth.lines.crease_angle = 180;
  const Remeshed without = remeshed(cube(), 100, smooth);
  check_result(without);
  CHECK(without.mesh.report.line_vertices == 0);
}

TEST_CASE("remesh: the lid of a can, a fan of needles, does not fold over") {
  constexpr std::uint32_t sides = 240;
  std::vector<double> xyz;
  std::vector<std::vector<std::uint32_t>> faces(2);
  for (std::uint32_t i = 0; i < sides; ++i) {
    const double angle = 2 * 3.14159265358979 * i / sides;
    for (const double z : {0., 1.}) xyz.insert(xyz.end(), {std::cos(angle), std::sin(angle), z});
    const std::uint32_t next = (i + 1) % sides;
    faces[0].insert(faces[0].begin(), 2 * i);
    faces[1].push_back(2 * i + 1);
    faces.push_back({2 * i, 2 * next, 2 * next + 1, 2 * i + 1});
  }
  for (const std::uint32_t n : {10u, 60u, 400u, 3000u}) {
    INFO(n << " samples");
    const Remeshed can = remeshed(polygon_mesh(xyz, faces), n, {}, SequenceKind::spaced);
    check_result(can);
    const RemeshedSurface& mesh = can.mesh;
    double lids = 0, turned = 0;
    for (std::size_t t = 0; t < mesh.triangles.size(); t += 3) {
      const auto at = [&](std::size_t k) {
        const std::uint32_t v = mesh.triangles[t + k];
        return to_file(can.model.surface, {mesh.x[v], mesh.y[v], mesh.z[v]});
      };
      const Vector3 normal = cross(at(1) - at(0), at(2) - at(0));
      if (std::abs(normal.z) < 0.99 * norm(normal)) continue;
      lids += 0.5 * norm(normal);
      if ((normal.z > 0) != (at(0).z > 0.5)) turned += 0.5 * norm(normal);
    }
    CHECK(turned < 1e-6);
    CHECK(lids == Approx(2 * 3.14159).epsilon(0.1));
  }
}

TEST_CASE("remesh: inside a flat sheet the triangles are Delaunay") {
  const Remeshed sheet = remeshed(grid_plane(20, 20), 500);
  std::map<std::pair<std::uint32_t, std::uint32_t>, double> angles;
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> faces;
  const RemeshedSurface& mesh = sheet.mesh;
  for (std::size_t t = 0; t < mesh.triangles.size(); t += 3)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = mesh.triangles[t + k], b = mesh.triangles[t + (k + 1) % 3],
                          c = mesh.triangles[t + (k + 2) % 3];
      const auto at = [&](std::uint32_t v) { return Vector3{mesh.x[v], mesh.y[v], mesh.z[v]}; };
      const Vector3 u = at(a) - at(c), v = at(b) - at(c);
      angles[std::minmax(a, b)] += std::atan2(norm(cross(u, v)), dot(u, v));
      ++faces[std::minmax(a, b)];
    }
  for (const auto& [edge, sum] : angles)
    if (faces[edge] == 2) REQUIRE(sum < 3.14159265358979 + 1e-5);
}

TEST_CASE("remesh: samples on corners, on edges and at one place become vertices") {
  const PreparedMesh surface = prepare_mesh(grid_plane(1, 1));
  const std::vector<std::array<float, 2>> places = {
      {0, 0}, {1, 0},       {0, 1},         {0.5f, 0.5f},   {0.5f, 0},      {0, 0.25f},
      {0, 0}, {0.5f, 0.5f}, {0.25f, 0.25f}, {0.25f, 0.25f}, {0.25f, 0.25f}, {1e-30f, 1e-38f}};
  std::vector<std::uint32_t> triangle, rank;
  std::vector<float> weights;
  std::vector<double> position;
  for (std::uint32_t t = 0; t < 2; ++t)
    for (const auto& [u, v] : places) {
      triangle.push_back(t);
      rank.push_back(static_cast<std::uint32_t>(rank.size()));
      weights.insert(weights.end(), {u, v});
      const std::uint32_t* corner = &surface.triangles[3 * t];
      const Vector3 at = (1. - double{u} - double{v}) * surface.position(corner[0]) +
                         double{u} * surface.position(corner[1]) + double{v} * surface.position(corner[2]);
      position.insert(position.end(), {at.x, at.y, at.z});
    }
  const RemeshedSurface mesh = remesh_surface(surface, {triangle, weights, position, rank}, {});
  CHECK(mesh.report.euler == 1);
  CHECK(mesh.report.boundary_loops == 1);
  CHECK(mesh.report.vertices >= triangle.size() + 4);
}

TEST_CASE("remesh: non-manifold, non-orientable and split surfaces come out complete") {
  const PolygonMesh pillow = polygon_mesh({0, 0, 0, 1, 0, 0, 0, 1, 0}, {{0, 1, 2}, {0, 2, 1}});
  const PolygonMesh fin =
      polygon_mesh({0, 0, 0, 1, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 1}, {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}});
  PolygonMesh soup;
  for (int i = 0; i < 40; ++i)
    soup = merged(soup.x.empty() ? fin : soup, moved(tetrahedron(), 0.01 + 0.02 * i, i % 7, i % 5, i % 3));
  const PolygonMesh needle =
      polygon_mesh({0, 0, 0, 1, 0, 0, 0.5, 1e-9, 0, 0.5, 0, 1}, {{0, 1, 2}, {1, 0, 3}});
  const std::array<PolygonMesh, 6> meshes = {
      pillow, fin, soup, needle, moebius_strip(20), folded_sheet(4, 6, 1e-4)};
  for (const PolygonMesh& mesh : meshes)
    for (const std::uint32_t n : {1u, 3u, 40u, 400u}) {
      INFO(n << " samples of " << mesh.polygon_count() << " faces");
      const Remeshed result = remeshed(mesh, n);
      CHECK(result.mesh.report.vertices >= n);
      CHECK(result.mesh.report.components + result.mesh.report.dropped_components ==
            result.model.surface.components.size());
      CHECK(result.mesh.report.dropped_share < 1);
      check_topology_by_numbers(result.mesh);
    }
}

TEST_CASE("remesh: seams with one edge on each side stay open in the file") {
  // Three sheets at one edge: the preparation parts them there, and in a chain of such fins it leaves loops
  // of two edges.
  PolygonMesh fins =
      polygon_mesh({0, 0, 0, 1, 0, 0, 0.5, 1, 0, 0.5, -1, 0, 0.5, 0, 1, 0.5, 0, -1},
                   {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}, {1, 0, 5}, {0, 2, 4}, {0, 3, 5}, {2, 1, 4}, {3, 1, 5}});
  for (const std::uint32_t n : {4u, 30u, 300u}) check_topology_by_numbers(remeshed(fins, n).mesh);
}

TEST_CASE("remesh: components without a sample are dropped and counted") {
  const PolygonMesh mesh = merged(icosphere(3), moved(icosphere(1), 1e-4, 3, 0, 0));
  const Remeshed result = remeshed(mesh, 50);
  CHECK(result.mesh.report.components == 1);
  CHECK(result.mesh.report.dropped_components == 1);
  CHECK(result.mesh.report.dropped_share > 0);
  CHECK(result.mesh.report.dropped_share < 1e-6);
  CHECK(result.mesh.report.euler == 2);
}

TEST_CASE("remesh: the same for every number of threads") {
  PolygonMesh mesh = icosphere(3);
  for (int i = 1; i < 6; ++i) mesh = merged(mesh, moved(torus(20, 10), 0.3 + 0.1 * i, 3.0 * i, 0, 0));
  RemeshParameters wanted;
  wanted.fit = true;
  const Remeshed one = on_threads(1, [&] { return remeshed(mesh, 1000, wanted); });
  const Remeshed four = on_threads(4, [&] { return remeshed(mesh, 1000, wanted); });
  CHECK(one.mesh.triangles == four.mesh.triangles);
  CHECK(one.mesh.x == four.mesh.x);
  CHECK(one.mesh.y == four.mesh.y);
  CHECK(one.mesh.z == four.mesh.z);
}

TEST_CASE("remesh: fitting brings the mesh nearer to the surface and moves no sample far") {
  RemeshParameters fit;
  fit.fit = true;
  const Remeshed plain = remeshed(icosphere(4), 150), fitted = remeshed(icosphere(4), 150, fit);
  check_result(fitted, true);
  CHECK(error_on_sphere(fitted) < 0.6 * error_on_sphere(plain));
  CHECK(fitted.mesh.report.largest_shift > 0);
  CHECK(fitted.mesh.report.largest_shift <= 0.2 + 1e-12);
  check_result(remeshed(cube(), 100, fit), true);
  check_result(remeshed(grid_plane(9, 9), 40, fit), true);
}

namespace {

// The least angles of the triangles, degrees, ascending.
std::vector<double> least_angles(const RemeshedSurface& mesh) {
  std::vector<double> angles;
  for (std::size_t t = 0; t < mesh.triangles.size(); t += 3) {
    double least = 180;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto at = [&](std::size_t i) {
        const std::uint32_t v = mesh.triangles[t + (k + i) % 3];
        return Vector3{mesh.x[v], mesh.y[v], mesh.z[v]};
      };
      const Vector3 u = at(1) - at(0), v = at(2) - at(0);
      least = std::min(least, std::atan2(norm(cross(u, v)), dot(u, v)) * 180 / 3.14159265358979);
    }
    angles.push_back(least);
  }
  std::sort(angles.begin(), angles.end());
  return angles;
}

}  // namespace

TEST_CASE("remesh: fitting moves samples near feature lines onto them, and the lines stay") {
  RemeshParameters fit;
  fit.fit = true;
  for (const std::uint32_t n : {100u, 1500u}) {
    // A single small set may happen to have as few samples beside lines as can be.
    std::size_t fitted = 0, unfitted = 0;
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      INFO(n << " samples, seed " << seed);
      const Remeshed box = remeshed(cube(), n, fit, SequenceKind::spaced, seed);
      const Remeshed plain = remeshed(cube(), n, {}, SequenceKind::spaced, seed);
      check_result(box, true);
      const double unit = box.model.surface.unit;
      CHECK(volume_of(box.mesh) * unit * unit * unit == Approx(8).epsilon(1e-5));
      CHECK(box.mesh.report.line_vertices <= plain.mesh.report.line_vertices);
      fitted += box.mesh.report.line_vertices;
      unfitted += plain.mesh.report.line_vertices;
      const std::vector<double> angles = least_angles(box.mesh), before = least_angles(plain.mesh);
      CHECK(angles[angles.size() / 100] > before[before.size() / 100]);
      CHECK(angles[angles.size() / 100] > 6);
      CHECK(angles[angles.size() / 2] > 34);  // flat faces stay Delaunay
      CHECK(box.mesh.report.largest_shift <= 0.2);
    }
    INFO(n << " samples");
    CHECK(fitted < unfitted);
    const Remeshed sheet = remeshed(grid_plane(30, 30), n, fit, SequenceKind::spaced);
    check_result(sheet, true);
    const PreparedMesh again = prepare_mesh(as_file(sheet.mesh));
    CHECK(again.total_area * again.unit * again.unit == Approx(sheet.model.surface.total_area).epsilon(1e-6));
  }
}

TEST_CASE("remesh: fitted smooth surfaces keep their angles") {
  RemeshParameters fit;
  fit.fit = true;
  for (const PolygonMesh& mesh : {icosphere(5), torus(80, 40)}) {
    const std::vector<double> angles = least_angles(remeshed(mesh, 700, fit, SequenceKind::spaced).mesh);
    CHECK(angles[angles.size() / 2] > 30);
    CHECK(angles[angles.size() / 100] > 12);
  }
}

TEST_CASE("remesh: arrays of the wrong size are refused, and a deadline is respected") {
  const PreparedMesh surface = prepare_mesh(cube());
  const std::vector<std::uint32_t> triangle = {99}, rank = {0};
  const std::vector<float> weights = {0, 0};
  const std::vector<double> position = {0, 0, 0};
  CHECK_THROWS_AS(remesh_surface(surface, {triangle, weights, position, rank}, {}), std::invalid_argument);
  CHECK_THROWS_AS(remesh_surface(surface, {rank, weights, {}, rank}, {}), std::invalid_argument);
  CancelToken late;
  late.deadline = std::chrono::steady_clock::now() - std::chrono::seconds(1);
  CHECK_THROWS_AS(remesh_surface(surface, {rank, weights, position, rank}, {}, {}, late), ItemError);
}

TEST_CASE("remesh: real meshes of the survey") {
  MEANDER_NEEDS_SHARED_DATA();
  for (const char* name : {"eight.off", "eight_hole.off", "hand_3k.off", "venus_1k_open.off"}) {
    INFO(name);
    const Remeshed result = remeshed(shared_mesh(name), 300, {}, SequenceKind::spaced);
    check_result(result);
    CHECK(result.mesh.report.kept_vertices == 0);
  }
}
