#include "kernels/flatten/flatten_chart.h"

#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "kernels/cut/cut_to_disk.h"
#include "kernels/flatten/boundary_first.h"
#include "kernels/flatten/chart_report.h"
#include "kernels/flatten/mean_value.h"
#include "kernels/flatten/orient2d.h"
#include "kernels/flatten/repair_flips.h"
#include "kernels/mesh/prepare_mesh.h"
#include "kernels/solve/intrinsic_delaunay.h"
#include "kernels/tensor/surface_metric.h"
#include "support/catch.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;

namespace {

using std::numbers::pi;

FlatChart flatten(const PreparedMesh& mesh, std::uint32_t component = 0, const CutParameters& cut = {},
                  const FlattenParameters& parameters = {}) {
  return flatten_chart(mesh, cut_to_disk(mesh, mesh.components.at(component), cut), parameters);
}

// What holds for every result, whatever the input.
void check_sound(const FlatChart& flat) {
  REQUIRE(flat.u.size() == flat.cut.vertex_count());
  REQUIRE(flat.v.size() == flat.cut.vertex_count());
  for (std::size_t i = 0; i < flat.u.size(); ++i) {
    REQUIRE((flat.u[i] >= 0 && flat.u[i] <= 1));
    REQUIRE((flat.v[i] >= 0 && flat.v[i] <= 1));
  }
  const ChartReport& r = flat.report;
  CHECK(r.triangles == flat.cut.triangle_count());
  CHECK(r.mean_distortion >= 1);
  CHECK(r.max_distortion >= 1);
  CHECK(r.area_scale_range >= 1);
  CHECK(std::isfinite(r.mean_distortion + r.max_distortion + r.area_scale_range + r.min_uv_edge));
  CHECK((r.overlap >= 0 && r.overlap <= 1));
  if (r.method == Method::conformal) CHECK(r.flips == 0);
}

void check_isometric(const FlatChart& flat) {
  check_sound(flat);
  CHECK(flat.report.method == Method::conformal);
  CHECK(flat.report.max_distortion == Approx(1).margin(1e-9));
  CHECK(flat.report.area_scale_range == Approx(1).margin(1e-9));
  CHECK(flat.report.overlap == 0);
}

PolygonMesh cylinder(std::uint32_t around, std::uint32_t along, double top_radius = 1) {
  PolygonMesh mesh;
  mesh.polygon_begin.push_back(0);
  for (std::uint32_t j = 0; j <= along; ++j)
    for (std::uint32_t i = 0; i < around; ++i) {
      const double t = static_cast<double>(j) / along, r = 1 + t * (top_radius - 1);
      mesh.x.push_back(r * std::cos(2 * pi * i / around));
      mesh.y.push_back(r * std::sin(2 * pi * i / around));
      mesh.z.push_back(1.5 * t);
    }
  for (std::uint32_t j = 0; j < along; ++j)
    for (std::uint32_t i = 0; i < around; ++i) {
      const std::uint32_t a = j * around + i, b = j * around + (i + 1) % around;
      for (const std::uint32_t corner : {a, b, b + around, a, b + around, a + around})
        mesh.corners.push_back(corner);
      mesh.polygon_begin.push_back(mesh.polygon_begin.back() + 3);
      mesh.polygon_begin.push_back(mesh.polygon_begin.back() + 3);
    }
  return mesh;
}

// The part of the unit sphere above the equator, rings of equal latitude round the pole.
PolygonMesh hemisphere(std::uint32_t rings) {
  const std::uint32_t around = 4 * rings;
  std::vector<double> xyz = {0, 0, 1};
  for (std::uint32_t j = 1; j <= rings; ++j)
    for (std::uint32_t i = 0; i < around; ++i) {
      const double t = 0.5 * pi * j / rings, s = 2 * pi * i / around;
      xyz.insert(xyz.end(), {std::sin(t) * std::cos(s), std::sin(t) * std::sin(s), std::cos(t)});
    }
  std::vector<std::vector<std::uint32_t>> faces;
  for (std::uint32_t i = 0; i < around; ++i) faces.push_back({0, 1 + i, 1 + (i + 1) % around});
  for (std::uint32_t j = 1; j < rings; ++j)
    for (std::uint32_t i = 0; i < around; ++i) {
      const std::uint32_t a = 1 + (j - 1) * around + i, b = 1 + (j - 1) * around + (i + 1) % around;
      faces.push_back({a, a + around, b + around});
      faces.push_back({a, b + around, b});
    }
  return polygon_mesh(std::move(xyz), std::move(faces));
}

// A long thin pin: conformal maps shrink its ends exponentially.
PolygonMesh tentacle(double radius, double length) {
  PolygonMesh mesh = icosphere(3);
  for (std::size_t i = 0; i < mesh.x.size(); ++i) {
    const double z = mesh.z[i];
    const double r = std::hypot(mesh.x[i], mesh.y[i]);
    mesh.z[i] = 0.5 * length * z;
    const double wanted = radius * std::sqrt(std::max(0.0, 1 - std::pow(z, 8)));
    if (r > 0) {
      mesh.x[i] *= wanted / r;
      mesh.y[i] *= wanted / r;
    }
  }
  return mesh;
}

IntrinsicDisk disk_of(const PreparedMesh& mesh, const CutChart& chart) {
  IntrinsicDisk disk;
  disk.triangles = chart.triangles;
  disk.opposite = chart.opposite;
  disk.length = chart_edge_lengths(mesh, chart);
  disk.vertex_count = static_cast<std::uint32_t>(chart.vertex_count());
  mollify(disk.length);
  return disk;
}

}  // namespace

TEST_CASE("flatten_chart: a plane is mapped by a similarity") {
  check_isometric(flatten(prepare_mesh(grid_plane(12, 7, 3, 2))));
  check_isometric(flatten(prepare_mesh(moved(grid_plane(5, 9), 1e-3, 4, 5, 6))));
}

TEST_CASE("flatten_chart: developable surfaces are unrolled") {
  check_isometric(flatten(prepare_mesh(cylinder(24, 6)), 0, {0}));
  check_isometric(flatten(prepare_mesh(cylinder(24, 6, 0.4)), 0, {0}));
}

TEST_CASE("flatten_chart: charts without interior vertices are unfolded") {
  const PreparedMesh one = prepare_mesh(polygon_mesh({0, 0, 0, 5, 0, 0, 1, 2, 7}, {{0, 1, 2}}));
  check_isometric(flatten(one));
  const PreparedMesh strip = prepare_mesh(
      polygon_mesh({0, 0, 0, 1, 0, 0, 0.5, 1, 0, 1.5, 1, 0.4, 2, 0.3, 1}, {{0, 1, 2}, {1, 3, 2}, {1, 4, 3}}));
  check_isometric(flatten(strip));
  check_sound(flatten(prepare_mesh(tetrahedron())));
}

TEST_CASE("flatten_chart: a hemisphere is more conformal the finer the mesh") {
  double before = 1.1, range = 0;
  for (const std::uint32_t rings : {12u, 24u, 48u}) {
    const FlatChart flat = flatten(prepare_mesh(hemisphere(rings)), 0, {0});
    check_sound(flat);
    CHECK(flat.report.method == Method::conformal);
    CHECK(flat.report.extra_seams == 0);
    CHECK(flat.report.mean_distortion - 1 < 0.6 * (before - 1));
    before = flat.report.mean_distortion;
    range = flat.report.area_scale_range;
  }
  CHECK(before < 1.02);
  // Stereographic projection: lengths at the rim grow twice as much as at the pole.
  CHECK(range == Approx(4).epsilon(0.1));
}

TEST_CASE("flatten_chart: closed surfaces of every genus are flattened") {
  for (const PolygonMesh& mesh : {cube(), icosphere(3), torus(32, 16), two_sided_plate(8, 0.01)}) {
    const FlatChart flat = flatten(prepare_mesh(mesh));
    check_sound(flat);
    CHECK(flat.report.method == Method::conformal);
    CHECK(flat.report.mean_distortion < 1.5);
  }
}

TEST_CASE("flatten_chart: invariant to rotation, translation and scale up to rounding") {
  const PreparedMesh a = prepare_mesh(torus(24, 14)), b = prepare_mesh(moved(torus(24, 14), 17, 1, 2, 3));
  // The same cut for both: seams may differ by rounding among equal paths.
  const CutChart cut = cut_to_disk(a, a.components[0], {});
  REQUIRE(a.triangles == b.triangles);
  const FlatChart fa = flatten_chart(a, cut, {}), fb = flatten_chart(b, cut, {});
  CHECK(fa.report.mean_distortion == Approx(fb.report.mean_distortion).epsilon(1e-6));
  CHECK(fa.report.area_scale_range == Approx(fb.report.area_scale_range).epsilon(1e-5));
  for (std::size_t h = 0; h < cut.triangles.size(); ++h) {
    const std::uint32_t p = cut.triangles[h],
                        q = cut.triangles[next_half_edge(static_cast<std::uint32_t>(h))];
    const double la = std::hypot(fa.u[p] - fa.u[q], fa.v[p] - fa.v[q]);
    const double lb = std::hypot(fb.u[p] - fb.u[q], fb.v[p] - fb.v[q]);
    REQUIRE(la == Approx(lb).epsilon(1e-6).margin(1e-9));
  }
}

TEST_CASE("flatten_chart: a tentacle gets more seams and keeps its scale in range") {
  const PreparedMesh mesh = prepare_mesh(tentacle(0.02, 2));
  FlattenParameters without;
  without.max_extra_seams = 0;
  const CutChart cut = cut_to_disk(mesh, mesh.components[0], {0});
  const FlatChart plain = flatten_chart(mesh, cut, without), seamed = flatten_chart(mesh, cut, {});
  check_sound(plain);
  check_sound(seamed);
  CHECK(plain.report.extra_seams == 0);
  CHECK(seamed.report.extra_seams <= 12);
  CHECK(seamed.report.mean_distortion <= plain.report.mean_distortion);
}

TEST_CASE("flatten_chart: degenerate triangles do not affect their neighbors") {
  // A grid with a sliver of no area along one diagonal and a vertex in the middle of an edge.
  const PreparedMesh mesh =
      prepare_mesh(polygon_mesh({0, 0, 0, 1, 0, 0, 2, 0, 0, 0, 1, 0, 1, 1, 0, 2, 1, 0, 1, 0.5, 0},
                                {{0, 1, 3}, {1, 6, 3}, {6, 4, 3}, {1, 4, 6}, {1, 2, 4}, {2, 5, 4}}));
  REQUIRE(mesh.repairs[Repair::zero_area_faces] == 1);
  const FlatChart flat = flatten(mesh);
  check_sound(flat);
  CHECK(flat.report.method == Method::conformal);
  CHECK(flat.report.mean_distortion < 1.001);
}

TEST_CASE("flatten_chart: coordinates of any range and coincident vertices stay finite") {
  PreparedMesh mesh = prepare_mesh(icosphere(2));
  for (std::size_t i = 0; i < mesh.x.size(); i += 2) mesh.x[i] = mesh.y[i] = mesh.z[i] = 0.25;
  for (std::size_t t = 0; t < mesh.triangle_count(); ++t)
    mesh.area[t] =
        triangle_area(mesh.position(mesh.triangles[3 * t]), mesh.position(mesh.triangles[3 * t + 1]),
                      mesh.position(mesh.triangles[3 * t + 2]));
  const FlatChart flat = flatten(mesh);
  for (const double value : flat.u) REQUIRE(std::isfinite(value));
  PolygonMesh stretched = icosphere(2);
  for (double& z : stretched.z) z *= 1e-9;
  check_sound(flatten(prepare_mesh(stretched)));
  for (double& z : stretched.z) z *= 1e18;
  check_sound(flatten(prepare_mesh(stretched)));
}

TEST_CASE("flatten_chart: an expired deadline ends the item") {
  const PreparedMesh mesh = prepare_mesh(icosphere(2));
  const CutChart cut = cut_to_disk(mesh, mesh.components[0], {});
  CancelToken token;
  token.deadline = std::chrono::steady_clock::now() - std::chrono::seconds(1);
  CHECK_THROWS_AS(flatten_chart(mesh, cut, {}, token), ItemError);
}

TEST_CASE("boundary-first: target angles of the boundary sum to one turn") {
  for (const PolygonMesh& polygons : {icosphere(3), torus(20, 12), hemisphere(8), grid_plane(6, 6)}) {
    const PreparedMesh mesh = prepare_mesh(polygons);
    const CutChart chart = cut_to_disk(mesh, mesh.components[0], {});
    const ConformalMap map = flatten_boundary_first(disk_of(mesh, chart));
    REQUIRE(map.finite);
    CHECK(map.turning == Approx(2 * pi).epsilon(1e-10));
    CHECK(branch_points(chart, map.u, map.v) == 0);
  }
}

TEST_CASE("intrinsic Delaunay: weights become non-negative, angles and area are preserved") {
  PolygonMesh sheared = torus(30, 10);
  for (std::size_t i = 0; i < sheared.x.size(); ++i) sheared.x[i] -= 3 * sheared.y[i];
  const PreparedMesh mesh = prepare_mesh(sheared);
  const CutChart chart = cut_to_disk(mesh, mesh.components[0], {});
  IntrinsicDisk disk = disk_of(mesh, chart);
  const auto summary = [](const IntrinsicDisk& d) {
    std::vector<double> sums(d.vertex_count + 1, 0);
    const CornerGeometry corners = corner_geometry(d.length);
    for (std::size_t h = 0; h < d.triangles.size(); ++h) sums[d.triangles[h]] += corners.angle[h];
    for (std::size_t t = 0; t < d.length.size(); t += 3)
      sums.back() += area_from_lengths(d.length[t], d.length[t + 1], d.length[t + 2]);
    return sums;
  };
  const std::vector<double> before = summary(disk);
  REQUIRE(make_intrinsic_delaunay(disk) > 0);
  const std::vector<double> after = summary(disk);
  for (std::size_t i = 0; i < before.size(); ++i) REQUIRE(after[i] == Approx(before[i]).epsilon(1e-6));
  const CornerGeometry corners = corner_geometry(disk.length);
  for (std::uint32_t h = 0; h < disk.opposite.size(); ++h) {
    const std::uint32_t other = disk.opposite[h];
    if (other == no_index) continue;
    REQUIRE(disk.opposite[other] == h);
    REQUIRE(disk.length[other] == disk.length[h]);
    REQUIRE(disk.triangles[h] == disk.triangles[next_half_edge(other)]);
    CHECK(corners.half_cotangent[h] + corners.half_cotangent[other] > -1e-6);
  }
}

TEST_CASE("mean value: a disk in a circle has no flips, a flat patch is reproduced") {
  for (const PolygonMesh& polygons : {icosphere(3), torus(20, 12), cube()}) {
    const PreparedMesh mesh = prepare_mesh(polygons);
    const CutChart chart = cut_to_disk(mesh, mesh.components[0], {});
    const IntrinsicDisk disk = disk_of(mesh, chart);
    std::vector<double> u, v;
    REQUIRE(flatten_to_circle(disk, u, v));
    const ChartGeometry geometry = chart_geometry(mesh, chart);
    CHECK(flipped_triangles(chart.triangles, geometry.counts, u, v).empty());
    CHECK(branch_points(chart, u, v) == 0);
  }
}

TEST_CASE("repair: a vertex pulled over its neighbors is moved back") {
  const PreparedMesh mesh = prepare_mesh(grid_plane(10, 10));
  const CutChart chart = cut_to_disk(mesh, mesh.components[0], {});
  const IntrinsicDisk disk = disk_of(mesh, chart);
  const ChartGeometry geometry = chart_geometry(mesh, chart);
  std::vector<double> u, v;
  for (const std::uint32_t w : chart.source_vertex) {
    u.push_back(mesh.x[w]);
    v.push_back(mesh.y[w]);
  }
  const auto bad = [&] { return scan_map(geometry, chart.triangles, u, v).bad; };
  CHECK(repair_flips(disk, geometry, bad(), u, v) == 0);  // nothing to do
  const std::vector<double> good_u = u;
  std::uint32_t inside = 0;
  for (std::uint32_t w = 0; w < u.size(); ++w)
    if (std::abs(u[w]) < 0.15 && std::abs(v[w]) < 0.15) inside = w;
  u[inside] += 0.7;
  REQUIRE(!flipped_triangles(chart.triangles, geometry.counts, u, v).empty());
  CHECK(repair_flips(disk, geometry, bad(), u, v) > 0);
  CHECK(flipped_triangles(chart.triangles, geometry.counts, u, v).empty());
  CHECK(u[inside] == Approx(good_u[inside]).margin(1e-9));  // mean values reproduce a flat patch
}

TEST_CASE("chart report: overlap of a folded strip") {
  // Two unit triangles laid on top of each other, and side by side.
  const std::vector<std::uint32_t> triangles = {0, 1, 2, 1, 3, 2};
  const std::vector<double> u = {0.1, 0.9, 0.1, 0.9}, v = {0.1, 0.1, 0.9, 0.9};
  CHECK(overlap_share(triangles, u, v) == 0);
  const std::vector<std::uint32_t> folded = {0, 1, 2, 0, 1, 2};
  CHECK(overlap_share(folded, u, v) == 1);
  const std::vector<std::uint32_t> half = {0, 1, 2, 1, 3, 2, 0, 1, 2};
  CHECK(overlap_share(half, u, v) == Approx(0.5).margin(0.1));
}

TEST_CASE("flatten: a map with an allowed number of bad triangles is kept without repairs") {
  // A metric that is rough from triangle to triangle.
  const PreparedMesh mesh = prepare_mesh(grid_plane(40, 40));
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(0, 1);
  TensorField field;
  for (std::size_t h = 0; h < mesh.triangles.size(); ++h) {
    const double angle = 3.2 * uniform(random), half = 1.0 * uniform(random);
    field.corner.push_back(tensor_of({half, -half, std::cos(angle), std::sin(angle)}));
  }
  const std::vector<double> length = surface_metric(mesh, field);
  const MeasuredMesh measured(mesh, length);
  const auto flattened = [&](double share) {
    FlattenParameters parameters;
    parameters.max_extra_seams = 0;
    parameters.max_flipped_share = share;
    return flatten_chart(measured, cut_to_disk(measured, mesh.components[0], {}), parameters);
  };
  const FlatChart strict = flattened(0), kept = flattened(0.05);
  INFO(kept.report.flips << " flips kept");
  CHECK(strict.report.flips == 0);
  CHECK(kept.report.method == Method::conformal);
  CHECK(kept.report.repaired_triangles == 0);
  CHECK(kept.report.flips > 0);
  CHECK(kept.report.flips <= 0.05 * static_cast<double>(mesh.triangle_count()));
}
