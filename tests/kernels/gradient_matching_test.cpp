#include "kernels/tensor/gradient_matching.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <numbers>

#include "io/file/file_bytes.h"
#include "io/mesh/mesh_reader.h"
#include "kernels/cut/cut_to_disk.h"
#include "kernels/flatten/chart_report.h"
#include "kernels/mesh/prepare_mesh.h"
#include "support/catch.h"
#include "support/hand_charts.h"
#include "support/spacing_formula.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;

namespace {

using std::numbers::pi;

FieldChart flatten(const PreparedMesh& mesh, const TensorField& field) {
  return flatten_to_field(mesh, cut_to_disk(mesh, mesh.components.at(0), {0}), field);
}

// What holds for every result, whatever the input.
void check_sound(const FieldChart& chart) {
  REQUIRE(chart.flat.u.size() == chart.flat.cut.vertex_count());
  REQUIRE(chart.flat.v.size() == chart.flat.cut.vertex_count());
  for (std::size_t i = 0; i < chart.flat.u.size(); ++i) {
    REQUIRE((chart.flat.u[i] >= 0 && chart.flat.u[i] <= 1));
    REQUIRE((chart.flat.v[i] >= 0 && chart.flat.v[i] <= 1));
  }
  CHECK((chart.residual >= 0 && chart.residual <= 1 + 1e-9));
  CHECK(std::isfinite(chart.spacing));
  CHECK(chart.alignment.flips == chart.flat.report.flips);
  CHECK((chart.flat.report.method == Method::anisotropic || chart.flat.report.method == Method::none));
  if (chart.flat.report.method == Method::anisotropic) CHECK(chart.flat.report.flips == 0);
  CHECK(chart.flat.report.triangles == chart.flat.cut.triangle_count());
}

void check_exact(const FieldChart& chart) {
  check_sound(chart);
  CHECK(chart.flat.report.method == Method::anisotropic);
  CHECK(chart.source == FieldMapSource::space_weights);
  CHECK(chart.flat.report.repaired_triangles == 0);
  CHECK(chart.residual < 1e-6);
  CHECK(chart.alignment.angle_95 < 1e-6);
  CHECK(chart.alignment.stretch_95 < 1e-6);
  CHECK(chart.alignment.ratio_95 < 1 + 1e-6);
  CHECK(chart.inconsistent_edges == 0);
  CHECK(is_accepted(chart.alignment, AlignmentForm::gradient));
}

// nx x ny quads over [0, 1]^2, bent by a map into space.
PolygonMesh bent_sheet(std::uint32_t nx, std::uint32_t ny,
                       const std::function<Vector3(double, double)>& map) {
  PolygonMesh mesh = grid_plane(nx, ny);
  for (std::size_t i = 0; i < mesh.x.size(); ++i) {
    const Vector3 p = map(mesh.x[i], mesh.y[i]);
    mesh.x[i] = p.x;
    mesh.y[i] = p.y;
    mesh.z[i] = p.z;
  }
  return mesh;
}

PolygonMesh annulus(std::uint32_t around, std::uint32_t across, double inner) {
  std::vector<double> xyz;
  std::vector<std::vector<std::uint32_t>> faces;
  for (std::uint32_t j = 0; j <= across; ++j)
    for (std::uint32_t i = 0; i < around; ++i) {
      const double r = inner + (1 - inner) * j / across, phi = 2 * pi * i / around;
      xyz.insert(xyz.end(), {r * std::cos(phi), r * std::sin(phi), 0});
    }
  for (std::uint32_t j = 0; j < across; ++j)
    for (std::uint32_t i = 0; i < around; ++i) {
      const std::uint32_t a = j * around + i, b = j * around + (i + 1) % around;
      faces.push_back({a, a + around, b + around});
      faces.push_back({a, b + around, b});
    }
  return polygon_mesh(std::move(xyz), std::move(faces));
}

}  // namespace

TEST_CASE("gradient_matching: constant tensors on a plane are mapped exactly") {
  const PreparedMesh mesh = prepare_mesh(wavy_grid(11, 9, 0.3, [](double, double) { return 0.0; }));
  for (const double angle : {0.0, 0.3, pi / 4, 1.7, 3.0})
    for (const double ratio : {1.0, 2.0, 4.0, 8.0}) {
      INFO("angle " << angle << " ratio " << ratio);
      const FieldChart chart =
          flatten(mesh, field_by_formula(mesh, constant_spacing(angle, ratio * 0.01, 0.01)));
      check_exact(chart);
      if (ratio == 1) continue;  // no direction of its own
      // u, v are affine: differences from vertex 0 are spacings up to one common sign.
      const CutChart& cut = chart.flat.cut;
      const Vector3 origin = mesh.position(cut.source_vertex[0]);
      double sign = 0;
      for (std::uint32_t w = 1; w < cut.vertex_count(); ++w) {
        const Vector3 p = mesh.position(cut.source_vertex[w]) - origin;
        const double u = (std::cos(angle) * p.x + std::sin(angle) * p.y) / (ratio * 0.01);
        const double v = (-std::sin(angle) * p.x + std::cos(angle) * p.y) / 0.01;
        const double du = (chart.flat.u[w] - chart.flat.u[0]) / chart.spacing;
        const double dv = (chart.flat.v[w] - chart.flat.v[0]) / chart.spacing;
        if (sign == 0) sign = u * du + v * dv > 0 ? 1 : -1;
        REQUIRE(sign * du == Approx(u).margin(1e-7));
        REQUIRE(sign * dv == Approx(v).margin(1e-7));
      }
    }
}

TEST_CASE("gradient_matching: zero-area slivers, single triangles and strips are exact") {
  const SpacingFormula field = constant_spacing(0.7, 5, 2);
  const PreparedMesh sliver =
      prepare_mesh(polygon_mesh({0, 0, 0, 1, 0, 0, 2, 0, 0, 0, 1, 0, 1, 1, 0, 2, 1, 0, 1, 0.5, 0},
                                {{0, 1, 3}, {1, 6, 3}, {6, 4, 3}, {1, 4, 6}, {1, 2, 4}, {2, 5, 4}}));
  REQUIRE(sliver.repairs[Repair::zero_area_faces] == 1);
  check_exact(flatten(sliver, field_by_formula(sliver, field)));
  const PreparedMesh one = prepare_mesh(polygon_mesh({0, 0, 0, 5, 0, 0, 1, 2, 7}, {{0, 1, 2}}));
  check_exact(flatten(one, field_by_formula(one, field)));
  const PreparedMesh strip = prepare_mesh(grid_plane(30, 1, 9, 0.1));
  check_exact(flatten(strip, field_by_formula(strip, field)));
}

TEST_CASE("gradient_matching: a helix on a cylinder is unrolled") {
  // The field turns with the facets: unrolled, it is constant but for the azimuth's projection into the
  // facet, which is the same for all.
  for (const std::uint32_t n : {8u, 32u}) {
    const PreparedMesh mesh = prepare_mesh(bent_sheet(3 * n, n, [](double x, double y) {
      return Vector3{std::cos(5 * x), std::sin(5 * x), 2 * y};
    }));
    check_exact(flatten(mesh, field_by_formula(mesh, [](Vector3 p, Vector3) {
                          const double r = std::hypot(p.x, p.y);
                          return WantedSpacing{{-0.8 * p.y / r, 0.8 * p.x / r, 0.6}, 4, 1};
                        })));
  }
}

TEST_CASE("gradient_matching: a constant field on an unrolled cone improves with the mesh") {
  // Half-angle 30 degrees: a point at distance r from the tip and azimuth phi unrolls to the angle phi / 2.
  double before = 1;
  for (const std::uint32_t n : {12u, 24u, 48u}) {
    const PreparedMesh mesh = prepare_mesh(bent_sheet(2 * n, n, [](double x, double y) {
      const double r = 1 + y, phi = 4 * x;
      return Vector3{0.5 * r * std::cos(phi), 0.5 * r * std::sin(phi), std::sqrt(0.75) * r};
    }));
    const FieldChart chart =
        flatten(mesh, field_by_formula(mesh, [](Vector3 p, Vector3) {
                  const double phi = std::atan2(p.y, p.x);
                  const double turned = 0.4 - 0.5 * (phi < -1 ? phi + 2 * pi : phi);
                  const Vector3 generator{0.5 * std::cos(phi), 0.5 * std::sin(phi), std::sqrt(0.75)};
                  const Vector3 round{-std::sin(phi), std::cos(phi), 0};
                  return WantedSpacing{std::cos(turned) * generator + std::sin(turned) * round, 3, 1};
                }));
    check_sound(chart);
    CHECK(is_accepted(chart.alignment, AlignmentForm::gradient));
    CHECK(chart.residual < 0.6 * before);
    before = chart.residual;
  }
  CHECK(before < 0.01);
}

TEST_CASE("gradient_matching: an annulus is cut open") {
  const PreparedMesh mesh = prepare_mesh(annulus(48, 8, 0.5));
  check_exact(flatten(mesh, field_by_formula(mesh, constant_spacing(0.2, 0.4, 0.1))));
  // Circles with spacings proportional to the radius: u = 5 phi, v = -20 log r, the complex logarithm.
  double before = 1;
  for (const std::uint32_t n : {4u, 8u, 16u}) {
    const PreparedMesh finer = prepare_mesh(annulus(8 * n, n, 0.4));
    const FieldChart chart = flatten(finer, field_by_formula(finer, [](Vector3 p, Vector3) {
                                       const double r = std::hypot(p.x, p.y);
                                       return WantedSpacing{{-p.y, p.x, 0}, 0.2 * r, 0.05 * r};
                                     }));
    check_sound(chart);
    CHECK(chart.flat.report.method == Method::anisotropic);
    CHECK(chart.flat.report.overlap == 0);
    CHECK(chart.residual < 0.7 * before);
    before = chart.residual;
    const auto [left, right] = std::minmax_element(chart.flat.u.begin(), chart.flat.u.end());
    const auto [low, high] = std::minmax_element(chart.flat.v.begin(), chart.flat.v.end());
    if (n < 16) continue;
    CHECK((*right - *left) / (*high - *low) == Approx(10 * pi / (20 * std::log(2.5))).epsilon(0.05));
    CHECK(is_accepted(chart.alignment, AlignmentForm::gradient));
  }
}

TEST_CASE("gradient_matching: a field with curl leaves a residual") {
  const PreparedMesh mesh = prepare_mesh(grid_plane(20, 20));
  // e1 / s1 = (1 + 2 y, 0): its curl is -2 everywhere.
  const FieldChart chart = flatten(mesh, field_by_formula(mesh, [](Vector3 p, Vector3) {
                                     return WantedSpacing{{1, 0, 0}, 1 / (1 + 2 * p.y), 0.2};
                                   }));
  check_sound(chart);
  CHECK(chart.residual > 0.05);
  CHECK(chart.residual < 0.3);
  CHECK(chart.alignment.stretch_95 > 0.05);
}

TEST_CASE("gradient_matching: a map that must fold is reported") {
  // Radial strokes: u = r, and nothing has gradient e2 = round. The best v is constant.
  const PreparedMesh mesh = prepare_mesh(wavy_grid(16, 16, 0.2, [](double, double) { return 0.0; }));
  const FieldChart radial = flatten(mesh, field_by_formula(mesh, [](Vector3 p, Vector3) {
                                      return WantedSpacing{{p.x - 0.51, p.y - 0.52, 0}, 1.5, 1};
                                    }));
  check_sound(radial);
  CHECK(radial.flat.report.flips > 0);
  CHECK(radial.flat.report.method == Method::none);
  CHECK(radial.residual > 0.3);
  CHECK(!is_accepted(radial.alignment, AlignmentForm::gradient));
  // A wedge: the two sides of the line of inconsistent edges pull against each other.
  const FieldChart wedge = flatten(mesh, field_by_formula(mesh, [](Vector3 p, Vector3) {
                                     const double angle = 0.5 * std::atan2(p.y - 0.52, p.x - 0.51);
                                     return WantedSpacing{{std::cos(angle), std::sin(angle), 0}, 3, 1};
                                   }));
  check_sound(wedge);
  CHECK(wedge.odd_vertices == 1);
  CHECK(wedge.inconsistent_edges > 0);
  CHECK(!is_accepted(wedge.alignment, AlignmentForm::gradient));
}

TEST_CASE("gradient_matching: the solution minimizes the energy over triangles") {
  const PreparedMesh mesh =
      prepare_mesh(wavy_grid(7, 6, 0.3, [](double x, double y) { return 0.2 * std::sin(4 * x * y); }));
  const CutChart cut = cut_to_disk(mesh, mesh.components[0], {0});
  const TensorField field = field_by_formula(mesh, [](Vector3 p, Vector3) {
    return WantedSpacing{{std::cos(2 * p.x), std::sin(2 * p.x), 0}, 0.5 + p.y, 0.2};
  });
  const ChartGeometry geometry = chart_geometry(mesh, cut);
  const UnfoldedTriangles unfolded = unfold_triangles(geometry);
  const CombedDirections combed = comb_directions(cut, geometry, unfolded, field);
  const IntrinsicDisk disk{
      cut.triangles, cut.opposite, geometry.length, static_cast<std::uint32_t>(cut.vertex_count()), {}};
  GradientMatch match =
      match_gradients(disk, corner_geometry(disk.length).half_cotangent, target_steps(unfolded, combed));
  REQUIRE(match.finite);
  // sum A (|grad u - e1 / s1|^2 + |grad v - e2 / s2|^2) from the gradients themselves.
  const auto energy = [&](const std::vector<double>& u, const std::vector<double>& v) {
    double sum = 0;
    for (std::size_t t = 0; t < cut.triangle_count(); ++t) {
      const std::uint32_t* c = &cut.triangles[3 * t];
      const double x1 = unfolded.x[3 * t], x2 = -unfolded.x[3 * t + 2], y2 = -unfolded.y[3 * t + 2];
      const double ux = (u[c[1]] - u[c[0]]) / x1, uy = (u[c[2]] - u[c[0]] - ux * x2) / y2;
      const double vx = (v[c[1]] - v[c[0]]) / x1, vy = (v[c[2]] - v[c[0]] - vx * x2) / y2;
      const double ex = combed.x[t], ey = combed.y[t], s1 = combed.first[t], s2 = combed.second[t];
      sum += geometry.area[t] * (std::pow(ux - ex / s1, 2) + std::pow(uy - ey / s1, 2) +
                                 std::pow(vx + ey / s2, 2) + std::pow(vy - ex / s2, 2));
    }
    return sum;
  };
  const std::vector<double> zero(cut.vertex_count(), 0);
  const double least = energy(match.u, match.v);
  CHECK(match.residual > 0.1);
  CHECK(match.residual == Approx(std::sqrt(least / energy(zero, zero))).epsilon(1e-9));
  for (std::vector<double>* x : {&match.u, &match.v})
    for (double& value : *x) {
      const double old = value;
      // The slope vanishes: both ways up, by the same amount.
      value = old + 1e-3;
      const double up = energy(match.u, match.v) - least;
      value = old - 1e-3;
      const double down = energy(match.u, match.v) - least;
      value = old;
      REQUIRE(up > 0);
      REQUIRE(up == Approx(down).epsilon(1e-6));
    }
}

TEST_CASE("gradient_matching: a few flips are repaired by patches in the metric") {
  const PreparedMesh mesh = prepare_mesh(wavy_grid(30, 30, 0.2, [](double, double) { return 0.0; }));
  // A small whirl in a constant field: the direction turns by pi within a few triangles, the spacing is four
  // times finer in the middle.
  const TensorField field = field_by_formula(mesh, [](Vector3 p, Vector3) {
    const double x = p.x - 0.5, y = p.y - 0.5, bump = std::exp(-(x * x + y * y) / 0.005);
    const double angle = 3.14 * bump, size = std::pow(4.0, -bump);
    return WantedSpacing{{std::cos(angle), std::sin(angle), 0}, 2 * size, size};
  });
  const CutChart cut = cut_to_disk(mesh, mesh.components[0], {0});
  const ChartGeometry geometry = chart_geometry(mesh, cut);
  const UnfoldedTriangles unfolded = unfold_triangles(geometry);
  const IntrinsicDisk disk{
      cut.triangles, cut.opposite, geometry.length, static_cast<std::uint32_t>(cut.vertex_count()), {}};
  const GradientMatch plain =
      match_gradients(disk, corner_geometry(disk.length).half_cotangent,
                      target_steps(unfolded, comb_directions(cut, geometry, unfolded, field)));
  REQUIRE(!flipped_triangles(cut.triangles, geometry.counts, plain.u, plain.v).empty());
  const FieldChart repaired = flatten_to_field(mesh, cut, field);
  check_sound(repaired);
  CHECK(repaired.flat.report.method == Method::anisotropic);
  CHECK(repaired.flat.report.repaired_triangles > 0);
}

TEST_CASE("gradient_matching: a whole real surface on one chart is refused without a crash") {
  MEANDER_NEEDS_SHARED_DATA();
  for (const char* name : {"paper/bunny_closed.off", "paper/fandisk.off"}) {
    const FileBytes file(shared_data(name));
    const PreparedMesh mesh = prepare_mesh(read_mesh(file.bytes(), MeshFormat::off));
    const FieldChart chart = flatten(mesh, field_by_formula(mesh, [](Vector3, Vector3) {
                                       return WantedSpacing{{0.3, 0.1, 0.9}, 4, 1};
                                     }));
    check_sound(chart);
    CHECK(chart.flat.report.method == Method::none);
    CHECK(!is_accepted(chart.alignment, AlignmentForm::gradient));
  }
}

TEST_CASE("gradient_matching: invariant to rotation, translation and scale up to rounding") {
  const PolygonMesh polygons =
      wavy_grid(14, 14, 0.2, [](double x, double y) { return 0.1 * std::sin(5 * x + 2 * y); });
  const PreparedMesh a = prepare_mesh(polygons), b = prepare_mesh(moved(polygons, 1.5, 1, 2, 3));
  REQUIRE(a.triangles == b.triangles);
  // Tensors live in the frames of the triangles, which move along.
  const TensorField field = field_by_formula(a, constant_spacing(0.5, 3, 1));
  const CutChart cut = cut_to_disk(a, a.components[0], {0});
  const FieldChart fa = flatten_to_field(a, cut, field), fb = flatten_to_field(b, cut, field);
  REQUIRE(fa.flat.report.method == Method::anisotropic);
  CHECK(fa.residual == Approx(fb.residual).epsilon(1e-7));
  CHECK(fa.alignment.angle_95 == Approx(fb.alignment.angle_95).epsilon(1e-6));
  CHECK(fa.alignment.ratio_95 == Approx(fb.alignment.ratio_95).epsilon(1e-6));
  for (std::size_t w = 0; w < cut.vertex_count(); ++w) {
    REQUIRE(fa.flat.u[w] == Approx(fb.flat.u[w]).margin(1e-9));
    REQUIRE(fa.flat.v[w] == Approx(fb.flat.v[w]).margin(1e-9));
  }
}

TEST_CASE("gradient_matching: whole closed surfaces stay finite") {
  for (const PolygonMesh& polygons : {icosphere(3), torus(24, 12), cube()}) {
    const PreparedMesh mesh = prepare_mesh(polygons);
    check_sound(flatten(mesh, field_by_formula(mesh, [](Vector3, Vector3) {
                          return WantedSpacing{{0.3, 0.1, 0.9}, 4, 1};
                        })));
  }
  PreparedMesh mesh = prepare_mesh(icosphere(2));
  for (std::size_t i = 0; i < mesh.x.size(); i += 2) mesh.x[i] = mesh.y[i] = mesh.z[i] = 0.25;
  for (std::size_t t = 0; t < mesh.triangle_count(); ++t)
    mesh.area[t] =
        triangle_area(mesh.position(mesh.triangles[3 * t]), mesh.position(mesh.triangles[3 * t + 1]),
                      mesh.position(mesh.triangles[3 * t + 2]));
  check_sound(flatten(mesh, field_by_formula(mesh, constant_spacing(0, 8, 1))));
}

TEST_CASE("gradient_matching: an expired deadline ends the item") {
  const PreparedMesh mesh = prepare_mesh(grid_plane(4, 4));
  const CutChart cut = cut_to_disk(mesh, mesh.components[0], {});
  CancelToken token;
  token.deadline = std::chrono::steady_clock::now() - std::chrono::seconds(1);
  CHECK_THROWS_AS(flatten_to_field(mesh, cut, field_by_formula(mesh, constant_spacing(0, 2, 1)), {}, token),
                  ItemError);
}
