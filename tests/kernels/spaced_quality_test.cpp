// Quality of spaced samples as a user gets them, through the stages of kernels/model/model.h: spacing, error
// over rotated boxes beside the sequence shifted, and how far they are from unbiased. The cases over shared
// meshes and many seeds are slow.

#include <algorithm>
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

constexpr std::array<double, 4> strips = {0.1, 0.25, 0.5, 1};

// Density of the samples at most strips x sqrt(A / n) from the border of a square, or the edges of a cube,
// over that of all.
std::array<double, 4> edge_density(SpacedModel& model, bool of_cube, std::uint32_t n, std::uint64_t seeds) {
  const double area = model.state.surface.total_area, side = std::sqrt(of_cube ? area / 6 : area);
  std::array<double, 4> inside{};
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    const std::vector<double> points = model.points(n, seed);
    for (std::size_t i = 0; i < points.size(); i += 3) {
      std::array<double, 3> gap;
      for (std::size_t k = 0; k < 3; ++k) gap[k] = 0.5 * side - std::abs(points[i + k]);
      std::sort(gap.begin(), gap.end());
      // The third coordinate of a square is 0, far from any border; the nearest face of a cube is its own.
      const double to_edge = gap[of_cube ? 1 : 0];
      for (std::size_t k = 0; k < strips.size(); ++k) inside[k] += to_edge < strips[k] * std::sqrt(area / n);
    }
  }
  for (std::size_t k = 0; k < strips.size(); ++k) {
    const double share = 1 - std::pow(1 - 2 * strips[k] * std::sqrt(area / n) / side, 2);
    inside[k] /= static_cast<double>(seeds) * n * share;
  }
  return inside;
}

constexpr SequenceKind in_places = SequenceKind::spaced, shifted = SequenceKind::shifted;

}  // namespace

TEST_CASE("spaced samples: keep a larger min distance and a lower error than shifted ones", "[statistics]") {
  // Well above most_typical_triangles: with fewer, the cells of `shifted` are cut exactly, those of `spaced`
  // are not.
  for (const PolygonMesh& mesh : {icosphere(4), torus(68, 40)})
    for (const char* const method : {"auto", "direct", "conformal"})
      for (const OrderKind order : {OrderKind::curve, OrderKind::progressive}) {
        if (sanitized && method != std::string_view("auto")) continue;  // release builds judge every method
        SpacedModel model(mesh, method, in_places, order), control(mesh, method, shifted, order);
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
    CHECK(bias(grid_plane(12, 12), in_places, order) < 0.10);
    CHECK(bias(torus(48, 24), in_places, order) < 0.10);
    CHECK(bias(cube(), in_places, order) < 0.22);
  }
  CHECK(bias(grid_plane(12, 12), SequenceKind::stratified, OrderKind::curve) <
        0.03);  // the measure's own error
}

TEST_CASE("spaced samples: are as dense beside borders and creases as elsewhere", "[statistics]") {
  constexpr std::array<double, 4> margins = {0.28, 0.15, 0.08, 0.05};
  for (const OrderKind order : {OrderKind::curve, OrderKind::progressive})
    for (const bool of_cube : {false, true}) {
      SpacedModel model(of_cube ? cube() : grid_plane(12, 12), "auto", in_places, order);
      const std::array<double, 4> density = edge_density(model, of_cube, 256, 300);
      for (std::size_t k = 0; k < strips.size(); ++k) {
        INFO((of_cube ? "cube" : "square") << (order == OrderKind::curve ? ", along" : ", progressive")
                                           << ", within " << strips[k] << " spacings");
        CHECK(density[k] == Approx(1).margin(margins[k]));
      }
    }
}

TEST_CASE("spaced samples: thin plates keep the samples of their rims, and strips stay filled",
          "[statistics]") {
  for (const OrderKind order : {OrderKind::curve, OrderKind::progressive}) {
    // The rim of a plate .002 thick and 1 wide has 40 of 10,000 samples.
    PolygonMesh plate = cube();
    for (double& z : plate.z) z *= 0.002;
    SpacedModel on_plate(plate, "auto", in_places, order);
    const double half = std::sqrt(on_plate.state.surface.total_area / (8 + 16 * 0.002));
    double rim = 0;
    constexpr std::uint32_t n = 10000, seeds = 4;
    for (std::uint32_t seed = 1; seed <= seeds; ++seed) {
      const std::vector<double> points = on_plate.points(n, seed);
      for (std::size_t i = 0; i < points.size(); i += 3)
        rim += std::max(std::abs(points[i]), std::abs(points[i + 1])) > half * (1 - 1e-6) ? 1.0 / seeds : 0;
    }
    CHECK(rim == Approx(n * 16 * 0.002 / (8 + 16 * 0.002)).margin(8));

    // A strip a third of a spacing wide: a tenth of its length has a tenth of the samples, its outer half a
    // half.
    SpacedModel on_strip(grid_plane(100, 1, 9, 0.01), "auto", in_places, order);
    const double length = 9 * std::sqrt(on_strip.state.surface.total_area / 0.09), width = length / 900;
    std::array<double, 10> tenths{};
    double beside = 0;
    for (std::uint32_t seed = 1; seed <= 8; ++seed) {
      const std::vector<double> points = on_strip.points(100, seed);
      for (std::size_t i = 0; i < points.size(); i += 3) {
        ++tenths[static_cast<std::size_t>(std::clamp(10 * (points[i] / length + 0.5), 0.0, 9.0))];
        beside += std::abs(points[i + 1]) > 0.25 * width ? 1 : 0;
      }
    }
    for (const double count : tenths) CHECK(count == Approx(80).margin(6));
    CHECK(beside == Approx(400).margin(80));
  }
}

TEST_CASE("spaced samples: stacks of sheets and parts smaller than a sample get their share",
          "[statistics]") {
  for (const OrderKind order : {OrderKind::curve, OrderKind::progressive}) {
    // A book of 40 pages beside a single one.
    PolygonMesh book = moved(grid_plane(4, 4), 1, 2, 0, 0);
    for (int page = 0; page < 40; ++page) book = merged(book, moved(grid_plane(4, 4), 1, 0, 0, 2e-4 * page));
    SpacedModel on_book(book, "auto", in_places, order), control(book, "auto", shifted, order);
    const std::vector<RotatedBox> boxes = on_book.boxes(300);
    const Quality own = quality(on_book, boxes, 1024, 1024, 4),
                  other = quality(control, boxes, 1024, 1024, 4);
    INFO((order == OrderKind::curve ? "along" : "progressive")
         << ": error " << own.error << ", shifted " << other.error);
    // The first samples of a progressive set know nothing of the pages that the last ones are to share.
    CHECK(own.error < (order == OrderKind::curve ? 1.0 : 1.1) * other.error);
    // 1,024 triangles, each a sixteenth of a sample: one half of them has half of the samples.
    PolygonMesh parts = moved(tetrahedron(), 0.01, 0, 0, 0);
    for (int i = 1; i < 256; ++i)
      parts = merged(parts, moved(tetrahedron(), 0.01, i % 16, i / 16, 0.3 * (i % 7)));
    SpacedModel on_parts(parts, "auto", in_places, order);
    double left = 0;
    constexpr std::uint32_t seeds = 40;
    for (std::uint32_t seed = 1; seed <= seeds; ++seed) {
      const std::vector<double> points = on_parts.points(64, seed);
      for (std::size_t i = 0; i < points.size(); i += 3) left += points[i] < 0 ? 1.0 / seeds : 0;
    }
    CHECK(left == Approx(32).margin(1.5));
  }
}

TEST_CASE("spaced samples: along the path they keep the distance that a heap of sheets has room for",
          "[statistics]") {
  // 96 squares, a third across each axis, spread over a cube twice as wide.
  PolygonMesh heap;
  for (int i = 0; i < 96; ++i) {
    PolygonMesh sheet = grid_plane(2, 2);
    if (i % 3 == 1) std::swap(sheet.x, sheet.z);
    if (i % 3 == 2) std::swap(sheet.y, sheet.z);
    const auto place = [&](double step) { return 2 * (i * step - std::floor(i * step)); };
    heap = merged(heap, moved(sheet, 1, place(0.8191725134), place(0.6710436067), place(0.5497004779)));
  }
  SpacedModel along(heap, "auto", in_places, OrderKind::curve),
      in_order(heap, "auto", in_places, OrderKind::progressive),
      control(heap, "auto", shifted, OrderKind::curve);
  const std::vector<RotatedBox> boxes = along.boxes(300);
  const Quality own = quality(along, boxes, 512, 512, 4), progressive = quality(in_order, boxes, 512, 512, 4),
                other = quality(control, boxes, 512, 512, 4);
  INFO("rho " << own.mean_rho << ", progressive " << progressive.mean_rho << "; error " << own.error << ", "
              << progressive.error << ", shifted " << other.error);
  CHECK(own.mean_rho > 0.29);  // .26 if all sheets within reach counted as one stack
  CHECK(progressive.mean_rho > 0.2);
  CHECK(own.error < other.error);
  CHECK(progressive.error < other.error);
}

TEST_CASE("spaced samples: region counts follow a density") {
  PolygonMesh mesh = torus(48, 24);
  ScalarAttribute weight{"weight", {}};
  for (const double x : mesh.x) weight.values.push_back(x + 1.5);
  mesh.vertex_attributes.push_back(weight);
  SpacedModel model(mesh, "auto", in_places, OrderKind::progressive);
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
      SpacedModel along(mesh, method, in_places, OrderKind::curve),
          progressive(mesh, method, in_places, OrderKind::progressive),
          best(mesh, method, in_places, OrderKind::curve, SpacingKind::best),
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
