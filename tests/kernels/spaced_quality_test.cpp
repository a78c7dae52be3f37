// Quality of spaced samples as a user gets them, through the stages of kernels/model/model.h: spacing, error
// over rotated boxes beside the sequence shifted, and how far they are from unbiased. The cases over shared
// meshes and many seeds are slow.

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "kernels/analyse/box_discrepancy.h"
#include "kernels/analyse/spacing.h"
#include "support/catch.h"
#include "support/sampled_model.h"
#include "support/sanitized.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;

namespace {

struct Quality {
  double error = 0, mean_rho = 0, least_rho = 1;
};

// Over the first `first` of n points of `seeds` sets.
Quality quality(SpacedModel& model, std::span<const RotatedBox> boxes, std::uint32_t n, std::size_t first,
                std::uint64_t seeds) {
  Quality result;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    std::vector<double> points = model.points(n, seed);
    points.resize(3 * first);
    result.error += std::pow(box_error_ratio(boxes, points), 2) / static_cast<double>(seeds);
    const double rho = model.rho(points);
    result.mean_rho += rho / static_cast<double>(seeds);
    result.least_rho = std::min(result.least_rho, rho);
  }
  result.error = std::sqrt(result.error);
  return result;
}

double bias_ratio(SpacedModel& model, std::span<const RotatedBox> boxes, std::uint32_t n,
                  std::uint64_t seeds) {
  BoxBias bias;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) bias.add(box_errors(boxes, model.points(n, seed)));
  return bias.ratio();
}

// Density of the samples at most .1 sqrt(A / n) from the border of the unit square, over that of all.
double border_density(SpacedModel& model, std::uint32_t n, std::uint64_t seeds) {
  const double side = std::sqrt(model.state.surface.total_area), strip = 0.1 * side / std::sqrt(n);
  double inside = 0;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    const std::vector<double> points = model.points(n, seed);
    for (std::size_t i = 0; i < points.size(); i += 3)
      inside += 0.5 * side - std::max(std::abs(points[i]), std::abs(points[i + 1])) < strip;
  }
  const double share = 1 - std::pow(1 - 2 * strip / side, 2);
  return inside / (static_cast<double>(seeds) * n * share);
}

constexpr SequenceKind spaced = SequenceKind::spaced, shifted = SequenceKind::shifted;

}  // namespace

TEST_CASE("spaced samples: keep a larger min distance and a lower error than shifted ones", "[statistics]") {
  // Well above most_typical_triangles: with fewer, the cells of `shifted` are cut exactly, those of `spaced`
  // are not.
  for (const PolygonMesh& mesh : {icosphere(4), torus(68, 40)})
    for (const char* const method : {"auto", "direct", "conformal"})
      for (const OrderKind order : {OrderKind::curve, OrderKind::progressive}) {
        if (sanitized && method != std::string_view("auto")) continue;  // release builds judge every method
        SpacedModel model(mesh, method, spaced, order), control(mesh, method, shifted, order);
        const std::vector<RotatedBox> boxes = model.boxes(400);
        const Quality own = quality(model, boxes, 1024, 1024, 8),
                      other = quality(control, boxes, 1024, 1024, 8);
        const bool along = order == OrderKind::curve;
        INFO(mesh.polygon_count() << " faces, " << method << (along ? ", curve" : ", progressive") << ": rho "
                                  << own.mean_rho << " (" << own.least_rho << "), error " << own.error
                                  << ", shifted " << other.error);
        CHECK(own.mean_rho > (along ? 0.62 : 0.55));
        CHECK(own.least_rho > (along ? 0.55 : 0.48));
        CHECK(other.mean_rho < 0.2);
        CHECK(own.error < (along ? 0.95 : 1.03) * other.error);
      }
}

TEST_CASE("spaced samples: nearly unbiased", "[statistics]") {
  const std::uint64_t seeds = 300;
  const auto bias = [&](const PolygonMesh& mesh, SequenceKind sequence, OrderKind order) {
    SpacedModel model(mesh, "auto", sequence, order);
    return bias_ratio(model, model.boxes(200), 256, seeds);
  };
  for (const OrderKind order : {OrderKind::curve, OrderKind::progressive}) {
    CHECK(bias(grid_plane(12, 12), spaced, order) < 0.10);
    CHECK(bias(torus(48, 24), spaced, order) < 0.10);
    CHECK(bias(cube(), spaced, order) < 0.22);
    SpacedModel square(grid_plane(12, 12), "auto", spaced, order);
    CHECK(border_density(square, 256, seeds) == Approx(1).margin(0.2));
  }
  CHECK(bias(grid_plane(12, 12), SequenceKind::stratified, OrderKind::curve) <
        0.03);  // the measure's own error
}

TEST_CASE("spaced samples: region counts follow a density") {
  PolygonMesh mesh = torus(48, 24);
  ScalarAttribute weight{"weight", {}};
  for (const double x : mesh.x) weight.values.push_back(x + 1.5);
  mesh.vertex_attributes.push_back(weight);
  SpacedModel model(mesh, "auto", spaced, OrderKind::progressive);
  model.parameters.density.kind = DensityKind::vertex_attribute;
  model.parameters.density.attribute = "weight";
  run_stages(charting_stages(model.parameters), model.state);
  // Octants of the mesh: share of the mass by a sum over triangles, count over seeds.
  std::array<double, 8> share{}, count{};
  const auto octant = [](double x, double y, double z) { return (x > 0) + 2 * (y > 0) + 4 * (z > 0); };
  const PreparedMesh& surface = model.state.surface;
  double total = 0;
  for (std::size_t t = 0; t < surface.triangle_count(); ++t) {
    Vector3 middle;
    for (std::size_t k = 0; k < 3; ++k)
      middle = middle + (1.0 / 3) * surface.position(surface.triangles[3 * t + k]);
    const double mass = model.state.measure.masses[t];
    share[static_cast<std::size_t>(octant(middle.x, middle.y, middle.z))] += mass;
    total += mass;
  }
  constexpr std::uint32_t n = 1000, seeds = 20;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    const std::vector<double> points = model.points(n, seed);
    for (std::size_t i = 0; i < points.size(); i += 3)
      ++count[static_cast<std::size_t>(octant(points[i], points[i + 1], points[i + 2]))];
  }
  // Random counts would have a standard deviation of about .015 of their expectation in 20,000 samples.
  for (std::size_t o = 0; o < 8; ++o) CHECK(count[o] / (n * seeds) == Approx(share[o] / total).epsilon(0.02));
}

TEST_CASE("spaced samples: of the meshes of the survey", "[slow]") {
  MEANDER_NEEDS_SHARED_DATA();
  struct Limits {
    const char* file;
    double thousand, ten_thousand, hundred_thousand;
  };
  for (const Limits& limit : {Limits{"bunny_closed.off", 0.23, 0.138, 0.08},
                              {"maxplanck_25k.off", 0.23, 0.138, 0.08},
                              {"fandisk.off", 0.24, 0.145, 0.082},
                              {"igea_full.ply", 0.23, 0.138, 0.08},
                              {"hand_3k.off", 0.23, 0.138, 0.08},
                              {"dragon_100k.ply", 0.24, 0.145, 0.082}})
    for (const char* const method : {"auto", "direct"}) {
      const PolygonMesh mesh = shared_mesh(limit.file);
      SpacedModel along(mesh, method, spaced, OrderKind::curve),
          progressive(mesh, method, spaced, OrderKind::progressive),
          best(mesh, method, spaced, OrderKind::curve, SpacingKind::best),
          control(mesh, method, shifted, OrderKind::curve);
      const std::vector<RotatedBox> boxes = along.boxes(600);
      for (const std::uint32_t n : {1000u, 10000u, 100000u}) {
        const std::uint64_t seeds = n == 1000 ? 12 : n == 10000 ? 6 : 3;
        const double error = n == 1000    ? limit.thousand
                             : n == 10000 ? limit.ten_thousand
                                          : limit.hundred_thousand;
        const Quality a = quality(along, boxes, n, n, seeds), p = quality(progressive, boxes, n, n, seeds),
                      b = quality(best, boxes, n, n, seeds), c = quality(control, boxes, n, n, seeds);
        INFO(limit.file << ", " << method << ", " << n << ": curve " << a.mean_rho << " " << a.least_rho
                        << " " << a.error << ", progressive " << p.mean_rho << " " << p.least_rho << " "
                        << p.error << ", best " << b.mean_rho << " " << b.least_rho << " " << b.error
                        << ", shifted " << c.error);
        // Strata along a curve are less compact than cells.
        const bool cells = std::string(method) == "auto";
        CHECK(a.mean_rho > (n == 100000 ? 0.58 : 0.60));
        CHECK(a.least_rho > 0.53);
        CHECK(a.error < (cells ? 1.0 : 1.07) * error);
        CHECK(a.error < (cells ? 1.0 : 0.92) * c.error);
        // 100,000 is half way between powers of two, where the last level has room for few of its samples.
        CHECK(p.mean_rho > (n == 100000 ? 0.44 : cells ? 0.55 : 0.52));
        CHECK(p.least_rho > (n == 100000 ? 0.40 : cells ? 0.50 : 0.46));
        CHECK(b.mean_rho > (n == 100000 ? 0.62 : cells ? 0.66 : 0.64));
        CHECK(b.error < (n == 1000 ? 0.245 : n == 10000 ? 0.138 : 0.08));
      }
    }
}
