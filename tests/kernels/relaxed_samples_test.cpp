// Relaxed samples: how even they are, and what they leave as it was.
#include "kernels/sample/relaxed_samples.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <string>
#include <vector>

#include "kernels/analyse/box_discrepancy.h"
#include "kernels/analyse/spacing.h"
#include "kernels/sample/kernel_sums.h"
#include "kernels/sample/spaced_samples.h"
#include "support/catch.h"
#include "support/sampled_model.h"
#include "support/shared_mesh.h"
#include "support/test_meshes.h"
#include "support/threads.h"

using namespace meander;
using namespace meander::test;

namespace {

SpacedModel relaxed(const PolygonMesh& mesh, SequenceKind sequence = SequenceKind::shifted,
                    OrderKind order = OrderKind::curve, const char* method = "auto") {
  SpacedModel model(mesh, method, sequence, order);
  model.parameters.finish = FinishKind::relax;
  return model;
}

struct Evenness {
  double box = 0, rho = 0, hole = 0, chamfer = 0;
};
// Root mean square of the box error, means of the rest, over sets.
Evenness evenness(SpacedModel& model, std::uint32_t n, std::uint64_t sets) {
  Evenness result;
  const std::vector<RotatedBox> boxes = model.boxes(400);
  SpacedModel dense(model.state.file, "auto", SequenceKind::shifted, OrderKind::curve);
  const std::vector<double> reference = dense.points(32 * n, 777);
  const double area = model.state.surface.total_area;
  for (std::uint64_t seed = 1; seed <= sets; ++seed) {
    const std::vector<double> points = model.points(n, seed);
    result.box += std::pow(box_error_ratio(boxes, points), 2) / sets;
    result.rho += model.rho(points) / sets;
    const std::vector<double> distance = distances_to_samples(points, reference);
    double sum = 0;
    for (const double d : distance) sum += d;
    result.hole += *std::max_element(distance.begin(), distance.end()) / hexagonal_hole(area, n) / sets;
    result.chamfer += sum / distance.size() / hexagonal_mean_distance(area, n) / sets;
  }
  result.box = std::sqrt(result.box);
  return result;
}

}  // namespace

TEST_CASE("relax_samples: sets on smooth surfaces come near the hexagonal lattice, whatever the sequence") {
  for (const PolygonMesh& mesh : {torus(68, 40), icosphere(5)})
    for (const SequenceKind sequence : {SequenceKind::shifted, SequenceKind::spaced, SequenceKind::random}) {
      SpacedModel model = relaxed(mesh, sequence);
      const Evenness found = evenness(model, 1000, 2);
      INFO("sequence " << static_cast<int>(sequence) << ": box " << found.box << ", rho " << found.rho
                       << ", hole " << found.hole << ", Chamfer " << found.chamfer);
      const bool is_random = sequence == SequenceKind::random;
      CHECK(found.box <= (is_random ? 0.9 : 0.20));
      CHECK(found.rho >= 0.70);
      CHECK(found.hole <= (is_random ? 1.7 : 1.2));
      CHECK(found.chamfer <= (is_random ? 1.04 : 1.015));
    }
}

TEST_CASE("relax_samples: the same for one thread and many") {
  SpacedModel model = relaxed(torus(68, 40));
  std::vector<double> one, many;
  on_threads(1, [&] { one = model.points(5000, 3); });
  on_threads(4, [&] { many = model.points(5000, 3); });
  CHECK(one == many);
}

TEST_CASE("relax_samples: samples at a border keep their share, and the bias is less than the error of a set",
          "[statistics]") {
  constexpr std::uint32_t n = 256;
  constexpr std::uint64_t sets = 100;
  for (const SequenceKind sequence : {SequenceKind::shifted, SequenceKind::spaced}) {
    SpacedModel square = relaxed(grid_plane(12, 12), sequence), box = relaxed(cube(), sequence),
                ring = relaxed(torus(48, 24), sequence);
    const auto bias_of = [&](SpacedModel& model) {
      const std::vector<RotatedBox> boxes = model.boxes(200);
      BoxBias bias;
      for (std::uint64_t seed = 1; seed <= sets; ++seed) bias.add(box_errors(boxes, model.points(n, seed)));
      return bias.ratio();
    };
    const double of_square = bias_of(square), of_box = bias_of(box), of_ring = bias_of(ring);
    INFO("bias: square " << of_square << ", cube " << of_box << ", torus " << of_ring);
    const bool is_spaced = sequence == SequenceKind::spaced;
    CHECK(of_square <= (is_spaced ? 0.35 : 0.60));
    CHECK(of_box <= (is_spaced ? 0.10 : 0.20));
    CHECK(of_ring <= (is_spaced ? 0.10 : 0.25));
    const double side = std::sqrt(square.state.surface.total_area), spacing = side / std::sqrt(double(n));
    for (const double width : {0.1, 0.25, 0.5, 1.0}) {
      double inside = 0;
      for (std::uint64_t seed = 1; seed <= sets; ++seed) {
        const std::vector<double> points = square.points(n, seed);
        for (std::size_t i = 0; i < points.size(); i += 3)
          inside += side / 2 - std::max(std::abs(points[i]), std::abs(points[i + 1])) < width * spacing;
      }
      const double share = 1 - std::pow(1 - 2 * width * spacing / side, 2);
      INFO("within " << width << " of the border: " << inside / (sets * n * share));
      CHECK(inside / (sets * n * share) == Approx(1).margin(width < 0.7 ? 0.25 : 0.05));
    }
  }
}

TEST_CASE("relax_samples: follows a density") {
  // Nine times as dense at the top of a sphere as at its bottom: the share of a zone is that of its mass.
  PolygonMesh mesh = icosphere(5);
  ScalarAttribute weight{"weight", {}};
  for (const double z : mesh.z) weight.values.push_back(5 + 4 * z);
  mesh.vertex_attributes.push_back(weight);
  SpacedModel model = relaxed(mesh);
  model.parameters.density.kind = DensityKind::vertex_attribute;
  model.parameters.density.attribute = "weight";
  run_stages(charting_stages(model.parameters), model.state);
  constexpr std::uint32_t n = 2000, zones = 8;
  const std::vector<double> points = model.points(n, 1);
  std::array<double, zones> found{};
  for (std::size_t i = 2; i < points.size(); i += 3) {
    const double z = points[i] * model.state.surface.unit;
    found[static_cast<std::size_t>(std::clamp((z + 1) / 2 * zones, 0.0, zones - 1.0))] += 1;
  }
  for (std::uint32_t k = 0; k < zones; ++k) {
    const double low = -1 + 2.0 * k / zones, high = low + 2.0 / zones;
    const double share = (5 * (high - low) + 2 * (high * high - low * low)) / 10;
    CAPTURE(k);
    CHECK(found[k] == Approx(n * share).margin(0.05 * n * share + 6));
  }
  // Neighbors are farther apart where the density is lower, and nowhere nearer than the finish asks for.
  const std::vector<double> nearest = nearest_distances(points);
  const double mass = model.state.measure.total() / n;
  for (std::size_t i = 0; i < nearest.size(); ++i) {
    const double density = 5 + 4 * points[3 * i + 2] * model.state.surface.unit;
    CHECK(nearest[i] >= 0.55 * std::sqrt(mass / density) * hexagonal_distance);
  }
}

TEST_CASE("relax_samples: samples on stacked sheets stay, and are a note, and those elsewhere move") {
  // A pile of 12 square plates, a tenth of a spacing apart, beside a sphere.
  PolygonMesh pile = grid_plane(6, 6, 2);
  for (int sheet = 1; sheet < 12; ++sheet)
    pile = merged(pile, moved(grid_plane(6, 6, 2), 1, 0, 0, 0.01 * sheet));
  const PolygonMesh mesh = merged(pile, moved(icosphere(4), 1, 5, 0, 0));
  SpacedModel before(mesh, "auto", SequenceKind::shifted, OrderKind::curve), after = relaxed(mesh);
  constexpr std::uint32_t n = 1000;
  const std::vector<double> placed = before.points(n, 1), moved_points = after.points(n, 1);
  CHECK(before.state.row.report.notes[static_cast<std::size_t>(Note::feature_ignored)] == 0);
  std::uint32_t stayed = 0, on_sphere = 0, moved_on_sphere = 0;
  for (std::size_t i = 0; i < placed.size(); i += 3) {
    const bool same = std::equal(&placed[i], &placed[i] + 3, &moved_points[i]);
    stayed += same;
    // Samples keep their rank and their part.
    const bool sphere = placed[i] > 0;
    CHECK((moved_points[i] > 0) == sphere);
    on_sphere += sphere;
    moved_on_sphere += sphere && !same;
  }
  REQUIRE(on_sphere > 100);
  CHECK(moved_on_sphere == on_sphere);
  // But for corners of the pile, where there is little above each other.
  CHECK(stayed > 0.9 * (n - on_sphere));
  CHECK(after.state.row.report.notes[static_cast<std::size_t>(Note::feature_ignored)] == stayed);
  CHECK(after.state.row.report.note_text.find("sheets of the surface lie on each other") !=
        std::string::npos);
}

TEST_CASE("relax_samples: exactly n distinct points, for few samples and small parts") {
  PolygonMesh dust = cube();
  for (int k = 0; k < 30; ++k) dust = merged(dust, moved(tetrahedron(), 0.01, 3 + 0.1 * k, 0, 0));
  for (const std::uint32_t n : {1u, 2u, 3u, 7u, 500u})
    for (const PolygonMesh& mesh : {dust, cube(), two_sided_plate(8, 0.001)}) {
      SpacedModel model = relaxed(mesh, SequenceKind::spaced, OrderKind::progressive);
      const std::vector<double> points = model.points(n, 2);
      std::set<std::array<double, 3>> distinct;
      for (std::size_t i = 0; i < points.size(); i += 3)
        distinct.insert({points[i], points[i + 1], points[i + 2]});
      CHECK(distinct.size() == n);
    }
}

TEST_CASE("sum_pull: sums and slopes are those of the kernel, the same for every instruction set") {
  SurfaceRows rows;
  constexpr std::size_t count = 37;
  rows.resize(count);
  CHECK(rows.size() == 40);
  const auto random = [](std::size_t i, std::uint32_t k) {
    return static_cast<float>(random_pair(make_random_key(4, {}), Stream::element_point, i, k).first);
  };
  for (std::size_t i = 0; i < count; ++i) {
    rows.x[i] = 3 * random(i, 0) - 1.5f;
    rows.y[i] = 3 * random(i, 1) - 1.5f;
    rows.z[i] = 3 * random(i, 2) - 1.5f;
    rows.mass[i] = 0.1f + random(i, 3);
    rows.normal_z[i] = i % 2 == 0 ? 1 : -1;
  }
  constexpr double per_spacing = 1.3;
  const auto slow = [&](double px, double py, double pz, bool facing) {
    double sum = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const double x = rows.x[i] - px, y = rows.y[i] - py, z = rows.z[i] - pz;
      const double t = 1 - per_spacing * per_spacing * (x * x + y * y + z * z) / 4;
      if (t > 0 && (!facing || i % 2 == 0)) sum += double(rows.mass[i]) * std::pow(t, 8);
    }
    return sum;
  };
  const std::array<float, 3> at = {0.1f, -0.2f, 0.05f}, normal = {0, 0, 1};
  const Pull pull = sum_pull(rows, at, normal, static_cast<float>(per_spacing));
  CHECK(pull.all == Approx(slow(0.1, -0.2, 0.05, false)).epsilon(1e-5));
  CHECK(pull.facing == Approx(slow(0.1, -0.2, 0.05, true)).epsilon(1e-5));
  const double h = 1e-4;
  const auto sum = [&](double x, double y, double z) { return slow(0.1 + x, -0.2 + y, 0.05 + z, false); };
  // A quarter of the gradient in spacings, and its derivatives.
  CHECK(pull.way[0] == Approx((sum(h, 0, 0) - sum(-h, 0, 0)) / (2 * h * per_spacing) / 4).epsilon(1e-3));
  CHECK(pull.way[2] == Approx((sum(0, 0, h) - sum(0, 0, -h)) / (2 * h * per_spacing) / 4).epsilon(1e-3));
  const double square = h * h * per_spacing * per_spacing * 4;
  CHECK(pull.slope[0] == Approx((sum(h, 0, 0) - 2 * sum(0, 0, 0) + sum(-h, 0, 0)) / square).epsilon(1e-3));
  CHECK(pull.slope[1] ==
        Approx((sum(h, h, 0) - sum(h, -h, 0) - sum(-h, h, 0) + sum(-h, -h, 0)) / (4 * square)).epsilon(1e-3));
  for (const InstructionSet set : {InstructionSet::scalar, InstructionSet::avx2}) {
    if (!is_available(set)) continue;
    const Pull other = sum_pull(rows, at, normal, static_cast<float>(per_spacing), set);
    CHECK(other.way == pull.way);
    CHECK(other.slope == pull.slope);
    CHECK(other.all == pull.all);
  }
}

TEST_CASE("sum_ways: that of points of mass 1, the same for every instruction set") {
  SurfaceRows rows;
  rows.resize(24);
  PointRows points;
  const std::array<float, 3> at = {0.1f, -0.2f, 0.05f};
  for (std::size_t i = 0; i < 24; ++i) {
    const bool counts = i < 21;
    const auto random = [&](std::uint32_t k) {
      return static_cast<float>(3 * random_pair(make_random_key(4, {}), Stream::element_point, i, k).first -
                                1.5);
    };
    rows.x[i] = counts ? random(0) : at[0];
    rows.y[i] = counts ? random(1) : at[1];
    rows.z[i] = counts ? random(2) : at[2];
    rows.mass[i] = 1;
    points.push_back(rows.x[i], rows.y[i], rows.z[i]);
  }
  const Pull pull = sum_pull(rows, at, {0, 0, 1}, 1.3f);
  CHECK(pull.way != std::array<float, 3>{});
  for (const InstructionSet set : {InstructionSet::scalar, InstructionSet::avx2})
    if (is_available(set)) CHECK(sum_ways(points, at, 1.3f, set) == pull.way);
}
