#include "kernels/tensor/comb_directions.h"

#include <algorithm>
#include <cmath>

#include "kernels/cut/cut_to_disk.h"
#include "kernels/mesh/prepare_mesh.h"
#include "support/catch.h"
#include "support/hand_charts.h"
#include "support/spacing_formula.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;

namespace {

// The corners of every face begin somewhere else: the frames of the triangles point everywhere, and with them
// the signs that tensor_axes() gives.
PolygonMesh turned_corners(PolygonMesh mesh) {
  for (std::size_t f = 0; f + 1 < mesh.polygon_begin.size(); ++f) {
    const auto begin = mesh.corners.begin() + mesh.polygon_begin[f];
    std::rotate(begin, begin + (f * 7 + f / 3) % 3, mesh.corners.begin() + mesh.polygon_begin[f + 1]);
  }
  return mesh;
}

PolygonMesh jittered_grid(std::uint32_t n) {
  return turned_corners(wavy_grid(n, n, 0.3, [](double, double) { return 0.0; }));
}

CutChart cut(const PreparedMesh& mesh) { return cut_to_disk(mesh, mesh.components.at(0), {0}); }

Vector3 in_space(const PreparedMesh& mesh, const CombedDirections& combed, std::uint32_t t) {
  const TangentFrame frame = triangle_frame(mesh, t);
  return combed.x[t] * frame.x + combed.y[t] * frame.y;
}

// e1 turns by `index` turns on a turn round (0.503, 0.496).
SpacingFormula singularity(double index) {
  return [index](Vector3 p, Vector3) {
    const double angle = index * std::atan2(p.y - 0.496, p.x - 0.503) + 0.3;
    return WantedSpacing{{std::cos(angle), std::sin(angle), 0}, 3, 1};
  };
}

}  // namespace

TEST_CASE("comb_directions: triangle frames and unfolded edges agree") {
  const PreparedMesh mesh = prepare_mesh(turned_corners(torus(14, 9)));
  const CutChart chart = cut(mesh);
  const ChartGeometry geometry = chart_geometry(mesh, chart);
  const UnfoldedTriangles unfolded = unfold_triangles(geometry);
  for (std::uint32_t t = 0; t < chart.triangle_count(); ++t) {
    const TangentFrame frame = triangle_frame(mesh, chart.triangle_begin + t);
    for (std::uint32_t h = 3 * t; h < 3 * t + 3; ++h) {
      const Vector3 edge = mesh.position(chart.source_vertex[chart.triangles[next_half_edge(h)]]) -
                           mesh.position(chart.source_vertex[chart.triangles[h]]);
      REQUIRE(unfolded.x[h] == Approx(dot(edge, frame.x)).margin(1e-14));
      REQUIRE(unfolded.y[h] == Approx(dot(edge, frame.y)).margin(1e-14));
    }
  }
}

TEST_CASE("comb_directions: a constant field is combed whatever the frames") {
  const PreparedMesh mesh = prepare_mesh(jittered_grid(12));
  for (const double angle : {0.0, 0.4, 1.5, 2.9}) {
    const CombedDirections combed =
        comb_directions(mesh, cut(mesh), field_by_formula(mesh, constant_spacing(angle, 4, 0.5)));
    CHECK(combed.inconsistent_edges == 0);
    CHECK(combed.odd_vertices.empty());
    const Vector3 wanted{std::cos(angle), std::sin(angle), 0};
    const double sign = dot(in_space(mesh, combed, 0), wanted) > 0 ? 1 : -1;
    for (std::uint32_t t = 0; t < mesh.triangle_count(); ++t) {
      REQUIRE(distance(sign * in_space(mesh, combed, t), wanted) < 1e-7);
      REQUIRE(combed.inherited[t] == 0);
      REQUIRE(combed.first[t] == Approx(4));
      REQUIRE(combed.second[t] == Approx(0.5));
    }
  }
}

TEST_CASE("comb_directions: a smooth field on a bumpy surface is consistent") {
  const PreparedMesh mesh = prepare_mesh(turned_corners(
      wavy_grid(24, 24, 0.2, [](double x, double y) { return 0.1 * std::sin(7 * x) * std::cos(5 * y); })));
  const CombedDirections combed =
      comb_directions(mesh, cut(mesh), field_by_formula(mesh, [](Vector3 p, Vector3) {
                        const double angle = 2 * p.x + 3 * p.y;  // more than a turn in all
                        return WantedSpacing{{std::cos(angle), std::sin(angle), 0}, 2, 1};
                      }));
  CHECK(combed.inconsistent_edges == 0);
  CHECK(combed.odd_vertices.empty());
}

TEST_CASE("comb_directions: odd singularities are found, even ones can be combed") {
  const PreparedMesh mesh = prepare_mesh(jittered_grid(20));
  const CutChart chart = cut(mesh);
  for (const double index : {0.5, -0.5, 1.5}) {
    const CombedDirections combed = comb_directions(mesh, chart, field_by_formula(mesh, singularity(index)));
    INFO("index " << index);
    // Round a triangle with index 3/2 the direction may turn by more than a right angle from one triangle to
    // the next: then the parity is that of the neighborhood.
    CHECK(combed.odd_vertices.size() % 2 == 1);
    if (std::abs(index) < 1) REQUIRE(combed.odd_vertices.size() == 1);
    CHECK(combed.inconsistent_edges >= 5);  // from the middle to the rim
    for (const std::uint32_t w : combed.odd_vertices) {
      const Vector3 p = mesh.center + mesh.unit * mesh.position(chart.source_vertex[w]);
      CHECK(std::hypot(p.x - 0.503, p.y - 0.496) < 0.15);
    }
  }
  // Centered on a vertex of a regular grid, six triangles round it.
  const PreparedMesh regular = prepare_mesh(turned_corners(grid_plane(8, 8)));
  const CombedDirections combed =
      comb_directions(regular, cut(regular), field_by_formula(regular, [](Vector3 p, Vector3) {
                        return WantedSpacing{{p.y - 0.5, 0.5 - p.x, 0}, 2, 1};
                      }));
  CHECK(combed.odd_vertices.empty());
  CHECK(combed.inconsistent_edges == 0);
}

TEST_CASE("comb_directions: wedges and trisectors are both found") {
  const PreparedMesh mesh = prepare_mesh(jittered_grid(24));
  const CombedDirections combed =
      comb_directions(mesh, cut(mesh), field_by_formula(mesh, [](Vector3 p, Vector3) {
                        const double angle = 0.5 * std::atan2(p.y - 0.51, p.x - 0.31) -
                                             0.5 * std::atan2(p.y - 0.49, p.x - 0.71);
                        return WantedSpacing{{std::cos(angle), std::sin(angle), 0}, 3, 1};
                      }));
  CHECK(combed.odd_vertices.size() == 2);
  CHECK(combed.inconsistent_edges > 0);
}

TEST_CASE("comb_directions: isotropic regions take the direction around them") {
  const PreparedMesh mesh = prepare_mesh(jittered_grid(20));
  const Vector3 wanted{0.6, 0.8, 0};
  const TensorField field = field_by_formula(mesh, [&](Vector3 p, Vector3) {
    const bool inside = std::hypot(p.x - 0.4, p.y - 0.5) < 0.25;
    return WantedSpacing{inside ? Vector3{-0.3, 0.9, 0} : wanted, inside ? 1.04 : 2.0, 1};
  });
  const CombedDirections combed = comb_directions(mesh, cut(mesh), field);
  CHECK(combed.inconsistent_edges == 0);
  std::size_t inherited = 0;
  for (std::uint32_t t = 0; t < mesh.triangle_count(); ++t) {
    inherited += combed.inherited[t];
    REQUIRE(std::abs(dot(in_space(mesh, combed, t), wanted)) > 1 - 1e-9);
  }
  CHECK(inherited == Approx(0.2 * static_cast<double>(mesh.triangle_count())).epsilon(0.15));
  // Nothing but isotropic triangles: one direction, carried along.
  const CombedDirections none =
      comb_directions(mesh, cut(mesh), field_by_formula(mesh, constant_spacing(1, 1, 1)));
  CHECK(none.inconsistent_edges == 0);
  for (std::uint32_t t = 0; t < mesh.triangle_count(); ++t)
    REQUIRE(dot(in_space(mesh, none, t), in_space(mesh, none, 0)) > 1 - 1e-9);
}

TEST_CASE("comb_directions: a zero-area sliver between two triangles passes the direction on") {
  const PreparedMesh mesh = prepare_mesh(
      turned_corners(polygon_mesh({0, 0, 0, 1, 0, 0, 2, 0, 0, 0, 1, 0, 1, 1, 0, 2, 1, 0, 1, 0.5, 0},
                                  {{0, 1, 3}, {1, 6, 3}, {6, 4, 3}, {1, 4, 6}, {1, 2, 4}, {2, 5, 4}})));
  REQUIRE(mesh.repairs[Repair::zero_area_faces] == 1);
  const CombedDirections combed =
      comb_directions(mesh, cut(mesh), field_by_formula(mesh, constant_spacing(0.7, 5, 2)));
  CHECK(combed.inconsistent_edges == 0);
  for (std::uint32_t t = 0; t < mesh.triangle_count(); ++t) {
    CHECK(combed.first[t] == Approx(5));
    CHECK(combed.second[t] == Approx(2));
    if (mesh.area[t] > 0)
      CHECK(dot(in_space(mesh, combed, t), in_space(mesh, combed, 0)) == Approx(1).epsilon(1e-6));
    else
      CHECK(combed.inherited[t] == 1);
  }
}

TEST_CASE("comb_directions: on a cut-open sphere curvature is transported and not counted as a fault") {
  // Meridians: index 1 at both poles, which are vertices or lie in triangles; no odd vertex far from them.
  const PreparedMesh mesh = prepare_mesh(turned_corners(icosphere(3)));
  const CutChart chart = cut(mesh);
  const CombedDirections combed =
      comb_directions(mesh, chart, field_by_formula(mesh, [](Vector3 p, Vector3) {
                        return WantedSpacing{{-p.x * p.z, -p.y * p.z, 1 - p.z * p.z}, 2, 1};
                      }));
  for (const std::uint32_t w : combed.odd_vertices) {
    const Vector3 p = mesh.center + mesh.unit * mesh.position(chart.source_vertex[w]);
    CHECK(std::hypot(p.x, p.y) < 0.3);
  }
  CHECK(combed.odd_vertices.size() % 2 == 0);
  const double largest = *std::max_element(combed.first.begin(), combed.first.end());
  CHECK(largest == Approx(2));
}
