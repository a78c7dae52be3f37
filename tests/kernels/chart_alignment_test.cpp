#include "kernels/tensor/chart_alignment.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "kernels/mesh/prepare_mesh.h"
#include "support/catch.h"
#include "support/hand_charts.h"
#include "support/spacing_formula.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;

namespace {

constexpr double degree = std::numbers::pi / 180;

// u, v = spacings along and across the direction at `angle`, then turned by `turn` and scaled.
ChartMap spacings_map(double angle, double first, double second, double turn = 0, double scale = 1) {
  return [=](Vector3 p) {
    const double u = (std::cos(angle) * p.x + std::sin(angle) * p.y) / first;
    const double v = (-std::sin(angle) * p.x + std::cos(angle) * p.y) / second;
    return std::pair(scale * (std::cos(turn) * u - std::sin(turn) * v),
                     scale * (std::sin(turn) * u + std::cos(turn) * v));
  };
}

AlignmentReport report_of(const PreparedMesh& mesh, const TensorField& field, const ChartMap& map) {
  const FlatChart flat = hand_chart(mesh, mesh.components[0], map);
  return chart_alignment(mesh, flat.cut, field, flat.u, flat.v);
}

// Ratio of the singular values of diag(1 / s1, 1 / s2) R(-delta) diag(s1, s2), from trace and determinant of
// M^T M.
double mismatch_ratio(double delta, double first, double second) {
  const double r = first / second, c = std::cos(delta), s = std::sin(delta);
  const double sum = 2 * c * c + s * s * (r * r + 1 / (r * r));  // |M|^2, det M = 1
  const double large = 0.5 * (sum + std::sqrt(sum * sum - 4));
  return large;
}

}  // namespace

TEST_CASE("chart_alignment: a map that follows the field is perfect") {
  const PreparedMesh mesh = prepare_mesh(wavy_grid(9, 9, 0.3, [](double, double) { return 0.0; }));
  for (const double angle : {0.0, 0.5, 1.9})
    for (const double ratio : {1.0, 2.0, 8.0}) {
      const TensorField field = field_by_formula(mesh, constant_spacing(angle, ratio, 1));
      const AlignmentReport report = report_of(mesh, field, spacings_map(angle, ratio, 1));
      CHECK(report.angle_95 < 1e-7);
      CHECK(report.stretch_95 < 1e-10);
      CHECK(report.ratio_95 == Approx(1).epsilon(1e-10));
      CHECK(report.flips == 0);
      CHECK(report.overlap == 0);
      CHECK(report.area == Approx(mesh.total_area));
      CHECK(report.anisotropic_share == Approx(ratio > 1 ? 1 : 0));
      CHECK(is_accepted(report, AlignmentForm::gradient));
      CHECK(is_accepted(report, AlignmentForm::metric));
    }
}

TEST_CASE("chart_alignment: a wrong direction and a wrong stretch are measured in closed form") {
  const PreparedMesh mesh = prepare_mesh(wavy_grid(9, 9, 0.3, [](double, double) { return 0.0; }));
  const TensorField field = field_by_formula(mesh, constant_spacing(0.3, 3, 1));
  for (const double delta : {-20 * degree, 10 * degree, 90 * degree}) {
    const AlignmentReport report = report_of(mesh, field, spacings_map(0.3 + delta, 3, 1));
    CHECK(report.mean_angle == Approx(std::abs(delta)).epsilon(1e-9));
    CHECK(report.angle_95 == Approx(std::abs(delta)).epsilon(1e-9));
    CHECK(report.stretch_95 < 1e-10);
    CHECK(report.ratio_95 == Approx(mismatch_ratio(delta, 3, 1)).epsilon(1e-9));
    CHECK(is_accepted(report, AlignmentForm::gradient) == (std::abs(delta) < 15 * degree));
  }
  for (const double wrong : {0.5, 1.4, 1.6}) {
    const AlignmentReport report = report_of(mesh, field, spacings_map(0.3, 3 * wrong, 1));
    CHECK(report.angle_95 < 1e-7);
    CHECK(report.mean_stretch == Approx(std::abs(std::log(wrong))).epsilon(1e-9));
    CHECK(report.stretch_95 == Approx(std::abs(std::log(wrong))).epsilon(1e-9));
    CHECK(report.ratio_95 == Approx(std::max(wrong, 1 / wrong)).epsilon(1e-9));
    CHECK(is_accepted(report, AlignmentForm::gradient) == (wrong == 1.4));
    CHECK(is_accepted(report, AlignmentForm::metric) == (wrong == 1.4));
  }
}

TEST_CASE("chart_alignment: form B is invariant to rotation, all forms to scale") {
  const PreparedMesh mesh = prepare_mesh(grid_plane(7, 5));
  const TensorField field = field_by_formula(mesh, constant_spacing(1.1, 4, 1));
  const AlignmentReport turned = report_of(mesh, field, spacings_map(1.1, 4, 1, 0.8, 1e-3));
  CHECK(turned.ratio_95 == Approx(1).epsilon(1e-9));
  CHECK(turned.stretch_95 < 1e-9);
  CHECK(is_accepted(turned, AlignmentForm::metric));
  // J^-1 (1, 0) = S R^T (1, 0): the angle of (4 cos, -sin).
  CHECK(turned.angle_95 == Approx(std::atan2(std::sin(0.8), 4 * std::cos(0.8))).epsilon(1e-9));
  const AlignmentReport scaled = report_of(mesh, field, spacings_map(1.1, 4, 1, 0, 1e6));
  CHECK(is_accepted(scaled, AlignmentForm::gradient));
}

TEST_CASE("chart_alignment: quantiles are weighted by area") {
  const PreparedMesh mesh = prepare_mesh(grid_plane(50, 3));
  for (const double share : {0.02, 0.04, 0.06, 0.5}) {
    const TensorField field = field_by_formula(mesh, [&](Vector3 p, Vector3) {
      return p.x < share ? WantedSpacing{{1, 1, 0}, 2, 1} : WantedSpacing{{1, 0, 0}, 2, 1};
    });
    const AlignmentReport report = report_of(mesh, field, spacings_map(0, 2, 1));
    INFO("share " << share);
    CHECK(report.mean_angle == Approx(share * 45 * degree).epsilon(1e-9));
    CHECK(report.angle_95 == Approx(share > 0.05 ? 45 * degree : 0).margin(1e-12));
    CHECK(report.mean_ratio == Approx(1 + share * (mismatch_ratio(45 * degree, 2, 1) - 1)).epsilon(1e-9));
    CHECK(is_accepted(report, AlignmentForm::gradient) == (share < 0.05));
  }
}

TEST_CASE("chart_alignment: quantiles equal those of sorted values") {
  for (const std::uint32_t side : {1u, 3u, 7u, 9u, 41u}) {
    const PreparedMesh mesh = prepare_mesh(grid_plane(side, side));
    const TensorField field = field_by_formula(mesh, constant_spacing(0, 2, 1));
    const FlatChart flat = hand_chart(mesh, mesh.components[0], [](Vector3 p) {
      return std::pair(p.x + 0.2 * std::sin(5 * p.x + p.y), p.y + 0.3 * std::cos(4 * p.x) * p.y * p.y);
    });
    const TriangleAlignment each = triangle_alignment(mesh, flat.cut, field, flat.u, flat.v);
    std::vector<std::pair<double, double>> sorted;
    double total = 0, above = 0;
    for (std::size_t t = 0; t < each.weight.size(); ++t) {
      sorted.emplace_back(-each.ratio[t], each.weight[t]);
      total += each.weight[t];
    }
    std::sort(sorted.begin(), sorted.end());
    std::size_t i = 0;
    while (i + 1 < sorted.size() && above + sorted[i].second <= 0.05 * total) above += sorted[i++].second;
    INFO(side << " squares");
    CHECK(chart_alignment(mesh, flat.cut, field, flat.u, flat.v).ratio_95 == -sorted[i].first);
  }
}

TEST_CASE("chart_alignment: of a chart in the unit square, with its overlap") {
  const PreparedMesh mesh = prepare_mesh(grid_plane(90, 2, 9 * std::numbers::pi, 0.4));
  const TensorField field = field_by_formula(mesh, constant_spacing(0, 1, 1));
  FlatChart flat = hand_chart(mesh, mesh.components[0], [](Vector3 p) {
    return std::pair((3 - p.y) * std::cos(p.x / 3), (3 - p.y) * std::sin(p.x / 3));
  });
  const AlignmentReport measured = chart_alignment(mesh, flat.cut, field, flat.u, flat.v);
  flat.report.overlap = 0.25;
  const AlignmentReport taken = chart_alignment(mesh, field, flat);
  CHECK(taken.overlap == 0.25);
  CHECK(taken.ratio_95 == measured.ratio_95);
  CHECK(taken.mean_angle == measured.mean_angle);
  CHECK(taken.flipped_share == measured.flipped_share);
  CHECK(taken.anisotropic_share == measured.anisotropic_share);
}

TEST_CASE("chart_alignment: flips, collapse and overlap are never accepted") {
  const PreparedMesh mesh = prepare_mesh(grid_plane(8, 8));
  const TensorField field = field_by_formula(mesh, constant_spacing(0, 2, 1));
  const AlignmentReport mirrored = report_of(mesh, field, [](Vector3 p) { return std::pair(p.x / 2, -p.y); });
  CHECK(mirrored.flips == 128);
  CHECK(mirrored.angle_95 < 1e-12);
  CHECK(!is_accepted(mirrored, AlignmentForm::gradient));
  CHECK(!is_accepted(mirrored, AlignmentForm::metric));
  const AlignmentReport folded =
      report_of(mesh, field, [](Vector3 p) { return std::pair(std::abs(p.x - 0.5) / 2, p.y); });
  CHECK(folded.flips == 64);
  CHECK(folded.overlap > 0.9);
  const AlignmentReport collapsed = report_of(mesh, field, [](Vector3 p) { return std::pair(p.x / 2, 0.0); });
  CHECK(collapsed.flips == 128);
  CHECK(std::isfinite(collapsed.mean_stretch + collapsed.mean_ratio + collapsed.mean_angle));
  const AlignmentReport point = report_of(mesh, field, [](Vector3) { return std::pair(0.0, 0.0); });
  CHECK(point.angle_95 == Approx(90 * degree));
  CHECK(!is_accepted(point, AlignmentForm::metric));
  // A long strip wound one and a half times round: locally sound.
  const PreparedMesh strip = prepare_mesh(grid_plane(90, 2, 9 * std::numbers::pi, 0.4));
  const AlignmentReport wound = report_of(
      strip, field_by_formula(strip, constant_spacing(0, 1, 1)),
      [](Vector3 p) { return std::pair((3 - p.y) * std::cos(p.x / 3), (3 - p.y) * std::sin(p.x / 3)); });
  CHECK(wound.flips == 0);
  CHECK(wound.overlap == Approx(0.5).margin(0.1));
  CHECK(wound.ratio_95 < 1.2);
  CHECK(!is_accepted(wound, AlignmentForm::metric));
}
