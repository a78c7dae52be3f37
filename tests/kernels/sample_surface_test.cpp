#include "kernels/surface/sample_surface.h"
#include "kernels/analyse/spacing.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <functional>
#include <numbers>
#include <numeric>
#include <set>
#include <stdexcept>

#include "kernels/analyse/chi_square.h"
#include "kernels/pointset/surface_curve.h"
#include "kernels/surface/analytic_surface.h"
#include "kernels/surface/formula_surface.h"
#include "kernels/surface/fundamental_forms.h"
#include "kernels/surface/height_field.h"
#include "support/catch.h"
#include "support/sanitized.h"
#include "support/threads.h"

using namespace meander;
using namespace meander::test;
using std::numbers::pi;

namespace {

SurfaceSampleParameters parameters_for(std::uint32_t samples, std::uint64_t seed = 1) {
  SurfaceSampleParameters p;
  p.samples = samples;
  p.seed = seed;
  return p;
}

SurfaceSampleParameters with_expression(std::uint32_t samples, const char* text) {
  SurfaceSampleParameters p = parameters_for(samples);
  p.density.kind = SurfaceDensityKind::expression;
  p.density.expression = text;
  return p;
}

SurfaceSamples sample(const char* name, const SurfaceSampleParameters& p) {
  return sample_surface(*make_surface(name), p);
}

SurfaceJet jet_at(const ParametricSurface& surface, double u, double v) {
  SurfaceJet jet;
  surface.jets({&u, 1}, {&v, 1}, {&jet, 1});
  return jet;
}

// Cells of the (u, v) square, moved by half a cell in u so that a seam lies inside cells; an odd number in v
// puts the middle line (the pinch of the eight) inside cells too.
constexpr std::size_t cells_u = 16, cells_v = 13;
std::size_t cell_of(double u, double v) {
  const double shifted = u + 0.5 / cells_u;
  const auto column = static_cast<std::size_t>((shifted - std::floor(shifted)) * cells_u);
  return std::min(column, cells_u - 1) * cells_v +
         std::min(static_cast<std::size_t>(v * cells_v), cells_v - 1);
}

// Integral of area element x density(jet) over every cell, by midpoints.
std::vector<double> cell_measures(const ParametricSurface& surface,
                                  const std::function<double(const SurfaceJet&)>& density) {
  constexpr std::size_t fine_u = 32 * cells_u, fine_v = 40 * cells_v;
  std::vector<double> result(cells_u * cells_v, 0.0);
  std::vector<double> u(fine_v), v(fine_v);
  std::vector<SurfaceJet> jets(fine_v);
  for (std::size_t i = 0; i < fine_u; ++i) {
    for (std::size_t j = 0; j < fine_v; ++j) {
      u[j] = (static_cast<double>(i) + 0.5) / fine_u;
      v[j] = (static_cast<double>(j) + 0.5) / fine_v;
    }
    surface.jets(u, v, jets);
    for (std::size_t j = 0; j < fine_v; ++j)
      result[cell_of(u[j], v[j])] += area_element(jets[j].du, jets[j].dv) * density(jets[j]);
  }
  return result;
}

// The curvature that gets density 1, found independently on another grid.
double reference_of(const ParametricSurface& surface, double quantile) {
  constexpr std::size_t n = 301;
  std::vector<std::pair<double, double>> values;
  double total = 0;
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j < n; ++j) {
      const FundamentalForms forms = fundamental_forms(
          jet_at(surface, (static_cast<double>(i) + 0.5) / n, (static_cast<double>(j) + 0.5) / n));
      values.emplace_back(std::abs(forms.mean), forms.area_element);
      total += forms.area_element;
    }
  std::sort(values.begin(), values.end());
  double below = 0;
  for (const auto& [value, area] : values)
    if ((below += area) >= quantile * total) return value;
  return values.back().first;
}

// Counts per cell over several seeds.
std::vector<std::uint64_t> cell_counts(const ParametricSurface& surface, SurfaceSampleParameters p,
                                       std::uint64_t seeds) {
  std::vector<std::uint64_t> counts(cells_u * cells_v, 0);
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    p.seed = seed;
    const SurfaceSamples samples = sample_surface(surface, p);
    for (std::size_t i = 0; i < samples.count(); ++i)
      ++counts[cell_of(samples.uv[2 * i], samples.uv[2 * i + 1])];
  }
  return counts;
}

void check_samples(const ParametricSurface& surface, const SurfaceSamples& samples, std::size_t n) {
  REQUIRE(samples.count() == n);
  REQUIRE(samples.points.size() == 3 * n);
  REQUIRE(samples.uv.size() == 2 * n);
  CHECK(samples.coincident_points == 0);
  std::set<std::array<float, 3>> distinct;
  std::vector<std::uint32_t> ranks = samples.curve_rank;
  std::sort(ranks.begin(), ranks.end());
  for (std::size_t i = 0; i < n; ++i) {
    REQUIRE(ranks[i] == i);
    const double u = samples.uv[2 * i], v = samples.uv[2 * i + 1];
    REQUIRE((u >= 0 && u <= 1 && v >= 0 && v <= 1));
    const SurfaceJet jet = jet_at(surface, u, v);
    const std::array<float, 3> point = {samples.points[3 * i], samples.points[3 * i + 1],
                                        samples.points[3 * i + 2]};
    REQUIRE(distance(jet.position, {point[0], point[1], point[2]}) < 1e-6);
    const Vector3 normal = {samples.normals[3 * i], samples.normals[3 * i + 1], samples.normals[3 * i + 2]};
    REQUIRE(distance(normal, unit_normal(jet.du, jet.dv)) < 1e-6);
    REQUIRE(samples.density[i] > 0);
    distinct.insert(point);
  }
  CHECK(distinct.size() == n);
}

struct Line {
  static constexpr std::string_view name = "line";
  template <class Scalar>
  std::array<Scalar, 3> operator()(const Scalar& u, const Scalar& v) const {
    return {u + v, 2 * (u + v), Scalar(1.0)};
  }
};

struct Hole {
  static constexpr std::string_view name = "hole";
  template <class Scalar>
  std::array<Scalar, 3> operator()(const Scalar& u, const Scalar& v) const {
    return {u, v, square_root(u - Scalar(0.25))};
  }
};

Status status_of(const ParametricSurface& surface, const SurfaceSampleParameters& p,
                 std::string* reason = nullptr) {
  try {
    sample_surface(surface, p);
  } catch (const ItemError& error) {
    if (reason != nullptr) *reason = error.what();
    return error.status();
  }
  return Status::ok;
}

}  // namespace

TEST_CASE("sample_surface: exactly n distinct points on every surface") {
  for (const std::string_view name : surface_names()) {
    INFO(name);
    const auto surface = make_surface(name);
    for (const std::uint32_t n : {1u, 7u, 256u, 5000u})
      check_samples(*surface, sample_surface(*surface, parameters_for(n)), n);
  }
}

TEST_CASE("sample_surface: every curve, sequence, order, placement and the warp") {
  const auto surface = make_surface("eight");
  for (const CurveKind curve : {CurveKind::hilbert, CurveKind::peano, CurveKind::peano_meander})
    for (const SequenceKind sequence : {SequenceKind::shifted, SequenceKind::stratified, SequenceKind::owen,
                                        SequenceKind::regular, SequenceKind::random, SequenceKind::spaced})
      for (const PlaceKind place : {PlaceKind::element, PlaceKind::vertex}) {
        if (sequence == SequenceKind::spaced && place == PlaceKind::vertex) continue;
        SurfaceSampleParameters p = parameters_for(100);
        p.curve = curve;
        p.sequence = sequence;
        p.place = place;
        p.order = sequence == SequenceKind::owen ? OrderKind::curve : OrderKind::progressive;
        p.reparameterize = place == PlaceKind::element && sequence == SequenceKind::stratified;
        if (p.reparameterize) p.density.kind = SurfaceDensityKind::max;
        check_samples(*surface, sample_surface(*surface, p), 100);
      }
}

TEST_CASE("sample_surface: spaced samples keep their distance, uniform and by a density") {
  for (const char* const name : {"sphere", "torus", "eight"})
    for (const OrderKind order : {OrderKind::curve, OrderKind::progressive}) {
      // Release builds take both orders on each.
      if (sanitized && (order == OrderKind::curve) != (name == std::string_view("torus"))) continue;
      SurfaceSampleParameters p = parameters_for(2000);
      p.sequence = SequenceKind::spaced;
      p.order = order;
      const SurfaceSamples s = sample(name, p);
      check_samples(*make_surface(name), s, 2000);
      const std::vector<double> points(s.points.begin(), s.points.end());
      INFO(name);
      CHECK(spacing_of(nearest_distances(points), s.area).rho > (order == OrderKind::curve ? 0.58 : 0.5));
      p.density.kind = SurfaceDensityKind::expression;
      p.density.expression = "1 + 3*u";  // with a jump where u begins again
      const SurfaceSamples dense = sample(name, p);
      // Against the spacing that is wanted at the denser one of two samples.
      double least = 1;
      const auto wanted = [&](std::size_t i) {
        return hexagonal_spacing(dense.measure / static_cast<double>(dense.density[i]), 2000);
      };
      for (std::size_t i = 0; i < 2000; ++i)
        for (std::size_t j = 0; j < i; ++j) {
          double squared = 0;
          for (std::size_t k = 0; k < 3; ++k) {
            const double d =
                static_cast<double>(dense.points[3 * i + k]) - static_cast<double>(dense.points[3 * j + k]);
            squared += d * d;
          }
          least = std::min(least, std::sqrt(squared) / std::min(wanted(i), wanted(j)));
        }
      CHECK(least > 0.5);
    }
}

TEST_CASE(
    "sample_surface: relaxed samples come near the hexagonal lattice, across seams, poles and densities") {
  for (const char* const name : {"sphere", "torus", "plane"})
    for (const SequenceKind sequence : {SequenceKind::shifted, SequenceKind::spaced}) {
      if (sanitized && sequence == SequenceKind::spaced) continue;
      SurfaceSampleParameters p = parameters_for(2000);
      p.sequence = sequence;
      p.finish = FinishKind::relax;
      const SurfaceSamples s = sample(name, p);
      check_samples(*make_surface(name), s, 2000);
      CHECK_FALSE(s.notes.any());
      const std::vector<double> points(s.points.begin(), s.points.end());
      INFO(name);
      CHECK(spacing_of(nearest_distances(points), s.area).rho > 0.7);
    }
  // As many samples on a side of the torus as before.
  SurfaceSampleParameters p = with_expression(4000, "1 + 3*sin(pi*u)^2");
  p.finish = FinishKind::relax;
  const SurfaceSamples dense = sample("torus", p);
  double share = 0;
  for (std::size_t i = 0; i < dense.count(); ++i)
    share += std::abs(dense.uv[2 * i] - 0.5) < 0.25 ? 1.0 / 4000 : 0;
  CHECK(share == Approx((2.5 / 2 + 1.5 / pi) / 2.5).epsilon(0.01));
}

TEST_CASE("sample_surface: relaxed samples keep their share of the border, and their order") {
  SurfaceSampleParameters p = parameters_for(256);
  p.finish = FinishKind::relax;
  // Within a quarter of a spacing of the border of the square, where there are 1 - (1 - 2 / 64)^2 of all.
  double near = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    p.seed = seed;
    const SurfaceSamples s = sample("plane", p);
    for (std::size_t i = 0; i < s.count(); ++i) {
      const double u = s.uv[2 * i], v = s.uv[2 * i + 1];
      near += std::min({u, 1 - u, v, 1 - v}) < 1.0 / 64 ? 1 : 0;
    }
  }
  CHECK(near / (40 * 256 * (1 - std::pow(1 - 2.0 / 64, 2))) == Approx(1).epsilon(0.2));
  p = parameters_for(3000);
  const auto run = [&] { return sample("klein-bottle", p); };
  const SurfaceSamples before = run();
  p.finish = FinishKind::relax;
  const SurfaceSamples first = test::on_threads(4, run), alone = test::on_threads(1, run);
  CHECK(first.points == alone.points);
  CHECK(first.uv == alone.uv);
  CHECK(first.curve_rank == before.curve_rank);
  CHECK(first.points != before.points);
}

TEST_CASE("sample_surface: relaxed samples on sheets that lie on each other stay, and are counted") {
  // A band that goes around twice, the second time beside itself by a thousandth.
  SurfaceSampleParameters p = parameters_for(500);
  const auto surface = make_formula_surface("(1 + 0.001*u)*cos(4*pi*u), (1 + 0.001*u)*sin(4*pi*u), v");
  const SurfaceSamples before = sample_surface(*surface, p);
  p.finish = FinishKind::relax;
  const SurfaceSamples after = sample_surface(*surface, p);
  CHECK(after.notes[Note::feature_ignored] > 250);
  CHECK(after.notes.examples[static_cast<std::size_t>(Note::feature_ignored)].find("of 500 samples") !=
        std::string::npos);
  p.place = PlaceKind::vertex;
  CHECK_FALSE(validate(p).empty());
}

TEST_CASE("sample_surface: areas of sphere, torus and planes are exact") {
  CHECK(sample("sphere", parameters_for(10)).area == Approx(4 * pi).epsilon(1e-9));
  CHECK(sample("torus", parameters_for(10)).area == Approx(4 * pi * pi * 0.5).epsilon(1e-9));
  CHECK(sample("plane", parameters_for(10)).area == Approx(1).epsilon(1e-12));
  CHECK(sample("stretched-plane", parameters_for(1000)).area == Approx(1).epsilon(1e-6));
  SurfaceSampleParameters p = parameters_for(1000);
  p.reparameterize = true;
  for (const CurveKind curve : {CurveKind::hilbert, CurveKind::peano}) {
    p.curve = curve;
    CHECK(sample("stretched-plane", p).area == Approx(1).epsilon(1e-5));
    CHECK(sample("sphere", p).area == Approx(4 * pi).epsilon(1e-6));
  }
}

TEST_CASE("sample_surface: integrals of smooth, narrow, bent and vanishing densities") {
  const auto measure = [](const char* text) { return sample("plane", with_expression(500, text)).measure; };
  CHECK(measure("x2y2") == Approx(1.0 / 9).epsilon(1e-6));
  CHECK(measure("cos10") == Approx(1 + 0.16583475942188740493).epsilon(1e-4));  // Si(10) / 10
  CHECK(measure("exp(-5000*((u - 0.37)^2 + (v - 0.61)^2))") == Approx(pi / 5000).epsilon(1e-3));
  CHECK(measure("abs(x - 0.3)") == Approx(0.29).epsilon(1e-4));
  CHECK(measure("max(0, x - 0.7)") == Approx(0.045).epsilon(1e-3));
  CHECK(measure("1/sqrt(x + 0.0001)") == Approx(2 * (std::sqrt(1.0001) - 0.01)).epsilon(1e-3));
}

TEST_CASE("sample_surface: the leaves form a curve with the right masses") {
  for (const char* name : {"torus", "eight"})
    for (const CurveKind kind : {CurveKind::hilbert, CurveKind::peano, CurveKind::peano_meander})
      for (const bool warp : {false, true}) {
        INFO(name << " " << static_cast<int>(kind) << " " << warp);
        SurfaceSampleParameters p = parameters_for(3000);
        p.curve = kind;
        p.reparameterize = warp;
        const auto surface = make_surface(name);
        const SurfaceCurve curve = build_surface_curve(*surface, p);
        const SurfaceSamples samples = sample_surface(*surface, p);
        const std::size_t leaves = curve.tree.leaf_count();
        REQUIRE(curve.mass.size() == leaves);
        REQUIRE(curve.uv.size() == 2 * leaves);
        CHECK(samples.leaves == leaves);
        const double total = std::accumulate(curve.mass.begin(), curve.mass.end(), 0.0);
        CHECK(total == Approx(samples.measure).epsilon(1e-10));
        double area = 0;
        std::size_t apart = 0;
        const CurveTree& tree = curve.tree;
        for (std::size_t i = 0; i < leaves; ++i) {
          area += tree.side[i] * tree.side[i];
          REQUIRE(curve.mass[i] <= total / (4.0 * p.samples) * (1 + 1e-6));
          if (i == 0) continue;
          REQUIRE(tree.key[i] > tree.key[i - 1]);
          const double reach = 0.5 * (tree.side[i] + tree.side[i - 1]) + 1e-9;
          apart +=
              std::abs(tree.u[i] + 0.5 * tree.side[i] - tree.u[i - 1] - 0.5 * tree.side[i - 1]) > reach ||
              std::abs(tree.v[i] + 0.5 * tree.side[i] - tree.v[i - 1] - 0.5 * tree.side[i - 1]) > reach;
        }
        CHECK(area == Approx(1).epsilon(1e-9));
        CHECK(apart == 0);
        if (warp) continue;
        // Masses against a fine midpoint rule, relative to what a leaf may weigh.
        for (std::size_t i = 0; i < leaves; i += leaves / 50) {
          double sum = 0;
          for (int k = 0; k < 400; ++k) {
            const SurfaceJet jet = jet_at(*surface, tree.u[i] + (k / 20 + 0.5) / 20 * tree.side[i],
                                          tree.v[i] + (k % 20 + 0.5) / 20 * tree.side[i]);
            sum += area_element(jet.du, jet.dv) * tree.side[i] * tree.side[i] / 400;
          }
          REQUIRE(std::abs(curve.mass[i] - sum) < 1.5e-3 * total / (4.0 * p.samples));
        }
      }
}

TEST_CASE("sample_surface: samples follow the curve, each in its own leaf") {
  SurfaceSampleParameters p = parameters_for(2000);
  p.order = OrderKind::curve;
  p.sequence = SequenceKind::regular;
  const auto surface = make_surface("torus");
  const SurfaceCurve curve = build_surface_curve(*surface, p);
  const SurfaceSamples samples = sample_surface(*surface, p);
  std::vector<double> sums(curve.mass.size() + 1, 0.0);
  for (std::size_t i = 0; i < curve.mass.size(); ++i) sums[i + 1] = sums[i] + curve.mass[i];
  for (std::size_t r = 0; r < samples.count(); ++r) {
    REQUIRE(samples.curve_rank[r] == r);
    const std::uint64_t key = curve_key(CurveKind::hilbert, samples.uv[2 * r], samples.uv[2 * r + 1]);
    const auto leaf = static_cast<std::size_t>(
        std::upper_bound(curve.tree.key.begin(), curve.tree.key.end(), key) - curve.tree.key.begin() - 1);
    const double target = (static_cast<double>(r) + 0.5) / 2000 * sums.back();
    REQUIRE(sums[leaf] <= target * (1 + 1e-9));
    REQUIRE(sums[leaf + 1] >= target * (1 - 1e-9));
  }
}

TEST_CASE("sample_surface: at curve vertices the points are leaf centers, 64 leaves per sample") {
  SurfaceSampleParameters p = parameters_for(50);
  p.place = PlaceKind::vertex;
  const auto surface = make_surface("sphere");
  const SurfaceCurve curve = build_surface_curve(*surface, p);
  const SurfaceSamples samples = sample_surface(*surface, p);
  CHECK(samples.leaves >= 64 * 50);
  std::set<std::pair<double, double>> centers;
  for (std::size_t i = 0; i < curve.mass.size(); ++i) centers.emplace(curve.uv[2 * i], curve.uv[2 * i + 1]);
  for (std::size_t i = 0; i < samples.count(); ++i)
    CHECK(centers.count({samples.uv[2 * i], samples.uv[2 * i + 1]}) == 1);
}

TEST_CASE("sample_surface: the same bytes again, on any number of threads, and another seed differs") {
  const auto surface = make_surface("klein-bottle");
  SurfaceSampleParameters p = with_expression(20000, "1 + x^2");
  const auto run = [&] { return sample_surface(*surface, p); };
  const SurfaceSamples first = test::on_threads(4, run), alone = test::on_threads(1, run);
  CHECK(first.points == alone.points);
  CHECK(first.normals == alone.normals);
  CHECK(first.uv == alone.uv);
  CHECK(first.density == alone.density);
  CHECK(first.curve_rank == alone.curve_rank);
  CHECK(first.measure == alone.measure);
  p.seed = 2;
  CHECK(sample_surface(*surface, p).points != first.points);
  CHECK(sample("sphere", parameters_for(10)).uv != sample("torus", parameters_for(10)).uv);
}

TEST_CASE("sample_surface: no bias on the sphere, at its poles and seam") {
  // Equal-area cells: slabs of equal height; the last ones are thin caps around the poles.
  const std::vector<double> z = {-1, -0.998, -0.98, -0.9, -0.5, 0, 0.5, 0.9, 0.98, 0.998, 1};
  constexpr std::size_t sectors = 12;
  std::vector<double> expected;
  for (std::size_t k = 0; k + 1 < z.size(); ++k)
    expected.insert(expected.end(), sectors, (z[k + 1] - z[k]) / 2 / sectors);
  for (const SequenceKind sequence : {SequenceKind::random, SequenceKind::shifted})
    for (const SurfaceDensityKind density : {SurfaceDensityKind::uniform, SurfaceDensityKind::mean}) {
      std::vector<std::uint64_t> counts(expected.size(), 0);
      for (std::uint64_t seed = 1; seed <= 10; ++seed) {
        SurfaceSampleParameters p = parameters_for(10000, seed);
        p.sequence = sequence;
        p.density.kind = density;
        const SurfaceSamples samples = sample("sphere", p);
        CHECK(samples.bound_violations == 0);
        for (std::size_t i = 0; i < samples.count(); ++i) {
          const double angle = std::atan2(samples.points[3 * i + 1], samples.points[3 * i]) / (2 * pi);
          const double turn = angle + 0.5 / sectors - std::floor(angle + 0.5 / sectors);
          const std::size_t sector = std::min(static_cast<std::size_t>(turn * sectors), sectors - 1);
          const auto slab = static_cast<std::size_t>(
              std::upper_bound(z.begin() + 1, z.end() - 1, samples.points[3 * i + 2]) - z.begin() - 1);
          ++counts[slab * sectors + sector];
        }
      }
      CHECK(chi_square_test(counts, expected).p_value > 1e-3);
    }
}

TEST_CASE("sample_surface: no bias on torus and eight, uniform and by curvature, with and without the warp",
          "[statistics]") {
  const char* name = GENERATE("torus", "eight");
  const bool warp = GENERATE(false, true);
  const auto surface = make_surface(name);
  SurfaceSampleParameters p = parameters_for(10000);
  const double reference = reference_of(*surface, p.density.quantile);
  const auto uniform = cell_measures(*surface, [](const SurfaceJet&) { return 1.0; });
  const auto bent = cell_measures(*surface, [&](const SurfaceJet& jet) {
    return 0.02 + 0.98 * std::min(1.0, std::abs(fundamental_forms(jet).mean) / reference);
  });
  for (const SurfaceDensityKind density : {SurfaceDensityKind::uniform, SurfaceDensityKind::mean}) {
    INFO(name << " warp " << warp << " density " << static_cast<int>(density));
    p.reparameterize = warp;
    p.density.kind = density;
    p.sequence = warp ? SequenceKind::shifted : SequenceKind::random;
    const auto counts = cell_counts(*surface, p, 5);
    const bool flat = density == SurfaceDensityKind::uniform;
    CHECK(chi_square_test(counts, flat ? uniform : bent).p_value > 1e-3);
    // The test can fail: the other density's expectation does not fit.
    CHECK(chi_square_test(counts, flat ? bent : uniform).p_value < 1e-6);
  }
}

TEST_CASE("sample_surface: no bias for an expression with kinks and zeros") {
  const auto surface = make_surface("torus");
  SurfaceSampleParameters p = with_expression(10000, "max(0, sin(7*x + 3*y))");
  p.sequence = SequenceKind::random;
  const auto expected = cell_measures(*surface, [](const SurfaceJet& jet) {
    return std::max(0.0, std::sin(7 * jet.position.x + 3 * jet.position.y));
  });
  CHECK(chi_square_test(cell_counts(*surface, p, 8), expected).p_value > 1e-3);
}

TEST_CASE("sample_surface: no bias on a height field, with its kinks", "[statistics]") {
  std::vector<float> heights(12 * 9);
  for (std::size_t k = 0; k < heights.size(); ++k)
    heights[k] = static_cast<float>(0.3 * std::sin(0.9 * static_cast<double>(k % 12)) *
                                    std::cos(static_cast<double>(k / 12)));
  for (const HeightInterpolation kind : {HeightInterpolation::bilinear, HeightInterpolation::bicubic}) {
    HeightFieldParameters shape;
    shape.interpolation = kind;
    const auto field = make_height_field(heights, 12, 9, shape);
    check_samples(*field, sample_surface(*field, parameters_for(1000)), 1000);
    SurfaceSampleParameters p = parameters_for(10000);
    p.sequence = SequenceKind::random;
    const auto expected = cell_measures(*field, [](const SurfaceJet&) { return 1.0; });
    CHECK(chi_square_test(cell_counts(*field, p, 4), expected).p_value > 1e-3);
  }
}

TEST_CASE("sample_surface: the density at the samples integrates correctly") {
  // E[1 / density] = area / measure.
  for (const SurfaceDensityKind kind :
       {SurfaceDensityKind::mean, SurfaceDensityKind::gaussian, SurfaceDensityKind::max}) {
    SurfaceSampleParameters p = parameters_for(20000);
    p.density.kind = kind;
    for (const char* name : {"torus", "monkey-saddle", "eight"}) {
      const SurfaceSamples samples = sample(name, p);
      double sum = 0;
      for (const float density : samples.density) sum += 1.0 / density;
      CHECK(sum / 20000 * samples.measure == Approx(samples.area).epsilon(0.01));
    }
  }
  // A flat surface has no curvature to go by.
  SurfaceSampleParameters p = parameters_for(100);
  p.density.kind = SurfaceDensityKind::gaussian;
  CHECK(sample("stretched-plane", p).measure == Approx(1));
}

TEST_CASE("sample_surface: one sample per stratum has a lower error than random") {
  // Counts in 208 cells: the variance of stratified sets is far below the multinomial one.
  const auto surface = make_surface("torus");
  const auto expected = cell_measures(*surface, [](const SurfaceJet&) { return 1.0; });
  SurfaceSampleParameters p = parameters_for(10000);
  const double stratified = chi_square_test(cell_counts(*surface, p, 1), expected).statistic;
  CHECK(stratified < 0.5 * static_cast<double>(cells_u * cells_v));
}

TEST_CASE("sample_surface: a surface that cannot be sampled says why") {
  const auto plane = make_surface("plane");
  std::string reason;
  CHECK(status_of(*plane, with_expression(10, "0*x")) == Status::zero_density);
  CHECK(status_of(*plane, with_expression(10, "x - 0.5"), &reason) == Status::unreadable);
  CHECK(reason.find("the density is -") != std::string::npos);
  CHECK(reason.find("at u = ") != std::string::npos);
  CHECK(status_of(*plane, with_expression(10, "log(x - 0.5)")) == Status::unreadable);
  CHECK(status_of(AnalyticSurface<Line>(), parameters_for(10)) == Status::zero_area);
  CHECK(status_of(AnalyticSurface<Hole>(), parameters_for(10)) == Status::non_finite);
  std::atomic<bool> stop = true;
  CancelToken cancel;
  cancel.canceled = &stop;
  CHECK_THROWS_AS(sample_surface(*plane, parameters_for(10), cancel), RunCanceled);
}

TEST_CASE("sample_surface: a density without any smoothness ends within its budget") {
  const SurfaceSamples samples = sample("plane", with_expression(500, "1 + sin(123456789*x*y)"));
  CHECK(samples.unresolved_patches > 0);
  CHECK(samples.measure == Approx(1).epsilon(0.02));
}

TEST_CASE("sample_surface: validate lists every problem") {
  CHECK(validate(SurfaceSampleParameters{}).empty());
  SurfaceSampleParameters p;
  p.samples = 0;
  p.jitter = 2;
  p.tolerance = 0;
  p.leaves_per_sample = 0.5;
  p.min_depth = 3;
  p.max_depth = 40;
  p.density = {SurfaceDensityKind::expression, "x +", 0, 9, 2};
  const auto problems = validate(p);
  CHECK(problems.size() == 10);
  CHECK_THROWS_AS(sample("plane", p), std::invalid_argument);
  SurfaceSampleParameters stray;
  stray.density.expression = "x";
  CHECK(validate(stray).size() == 1);
}
