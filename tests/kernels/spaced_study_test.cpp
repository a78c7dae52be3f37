// What is promised of spaced samples beside their quality as whole sets: every prefix of a progressive set,
// counts and spacing under a density and under a tensor field. Figures are printed with -s;
// docs/METHODS.md 7.5 quotes them.
#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "kernels/analyse/metric_neighbors.h"
#include "kernels/analyse/region_counts.h"
#include "support/anisotropic_models.h"
#include "support/catch.h"
#include "support/grid_regions.h"
#include "support/sampled_model.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;

namespace {

constexpr std::array<const char*, 6> meshes = {"bunny_closed.off", "maxplanck_25k.off", "fandisk.off",
                                               "igea_full.ply",    "hand_3k.off",       "dragon_100k.ply"};

// ---- prefixes ----

struct PrefixFigures {
  std::size_t first = 0;
  double mean_rho = 0, least_rho = 1, error = 0, fresh = 0;  // fresh: of a stratified set of as many points
};

// Prefixes of `seeds` progressive sets of n points.
std::vector<PrefixFigures> prefixes(SpacedModel& model, SpacedModel& control, std::uint32_t n,
                                    const std::vector<std::size_t>& sizes, std::uint64_t seeds) {
  const std::vector<RotatedBox> boxes = model.boxes(400);
  std::vector<PrefixFigures> figures;
  for (const std::size_t size : sizes) figures.push_back({size});
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    const std::vector<double> all = model.points(n, seed);
    for (PrefixFigures& f : figures) {
      const std::span<const double> points = std::span(all).first(3 * f.first);
      const double rho = model.rho(points), share = 1 / static_cast<double>(seeds);
      f.mean_rho += share * rho;
      f.least_rho = std::min(f.least_rho, rho);
      f.error += share * std::pow(box_error_ratio(boxes, points), 2);
      const std::vector<double> fresh = control.points(static_cast<std::uint32_t>(f.first), 1000 + seed);
      f.fresh += share * std::pow(box_error_ratio(boxes, fresh), 2);
    }
  }
  for (PrefixFigures& f : figures) {
    f.error = std::sqrt(f.error);
    f.fresh = std::sqrt(f.fresh);
  }
  return figures;
}

std::vector<std::size_t> powers_of_two(std::uint32_t below) {
  std::vector<std::size_t> sizes;
  for (std::size_t size = 64; size < below; size *= 2) sizes.push_back(size);
  return sizes;
}

void check_prefixes(const PolygonMesh& mesh, const std::string& name, const char* method, std::uint32_t n,
                    std::uint64_t seeds) {
  SpacedModel model(mesh, method, SequenceKind::spaced, OrderKind::progressive),
      control(mesh, method, SequenceKind::stratified, OrderKind::progressive);
  for (const PrefixFigures& f : prefixes(model, control, n, powers_of_two(n), seeds)) {
    INFO(name << ", " << method << ", first " << f.first << " of " << n << ": rho " << f.mean_rho << " ("
              << f.least_rho << "), error " << f.error << ", fresh stratified " << f.fresh << ": "
              << f.error / f.fresh);
    CHECK(f.mean_rho >= 0.50);
    CHECK(f.error <= (f.first <= 512 ? 0.95 : 1.02) * f.fresh);
  }
  std::vector<std::size_t> between;
  for (const std::size_t size :
       {70u, 100u, 200u, 300u, 500u, 700u, 1500u, 3000u, 5000u, 7000u, 10000u, 12000u})
    if (size < n) between.push_back(size);
  for (const PrefixFigures& f : prefixes(model, control, n, between, seeds)) {
    INFO(name << ", " << method << ", first " << f.first << " of " << n << ": rho " << f.mean_rho << " ("
              << f.least_rho << "), error " << f.error << ", fresh stratified " << f.fresh << ": "
              << f.error / f.fresh);
    CHECK(f.least_rho >= 0.35);
  }
}

// ---- density ----

// Distance to the nearest sample over that of the hexagonal lattice of the density there: least and mean.
struct LocalSpacing {
  double least = 1e9, mean = 0;
};
LocalSpacing local_spacing(const SpacedModel& model, std::span<const double> points) {
  const Samples& samples = model.state.row.samples;
  double mass = 0;
  for (const double m : model.state.measure.masses) mass += m;
  const std::vector<double> nearest = nearest_distances(points);
  LocalSpacing result;
  for (std::size_t i = 0; i < nearest.size(); ++i) {
    const double share =
        nearest[i] / hexagonal_spacing(mass / static_cast<double>(samples.density[i]), nearest.size());
    result.least = std::min(result.least, share);
    result.mean += share / static_cast<double>(nearest.size());
  }
  return result;
}

struct DensityFigures {
  double p_value = 1, dispersion = 0, least = 1e9, mean = 0, whole_p = 1;
  std::uint32_t near = 0;  // sets with a distance below half of the wanted one
};

// Of single sets: the smallest p-value and the largest dispersion; and the p-value of the counts of all sets
// together, which bias makes small.
DensityFigures density_figures(SpacedModel& model, std::uint32_t n, std::uint64_t seeds) {
  const std::vector<std::uint32_t> region = grid_regions(model.state.surface, 4);
  DensityFigures figures;
  std::vector<std::uint32_t> all;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    const std::vector<double> points = model.points(n, seed);
    const std::vector<std::uint32_t>& triangle = model.state.row.samples.triangle;
    const RegionCounts counts = region_counts(region, model.state.measure.masses, triangle, 64);
    figures.p_value = std::min(figures.p_value, counts.test.p_value);
    figures.dispersion = std::max(figures.dispersion, counts.dispersion);
    all.insert(all.end(), triangle.begin(), triangle.end());
    const LocalSpacing spacing = local_spacing(model, points);
    figures.least = std::min(figures.least, spacing.least);
    figures.near += spacing.least < 0.5;
    figures.mean += spacing.least / static_cast<double>(seeds);
  }
  figures.whole_p = region_counts(region, model.state.measure.masses, all, 64).test.p_value;
  return figures;
}

void check_density(SpacedModel& model, const std::string& name, std::uint32_t n, std::uint64_t seeds) {
  const DensityFigures f = density_figures(model, n, seeds);
  INFO(name << ", " << n << ": smallest distance over the one wanted there " << f.mean << " (" << f.least
            << ", below .5 in " << f.near << " of " << seeds << "), regions: p " << f.p_value
            << ", dispersion " << f.dispersion << ", all sets together p " << f.whole_p);
  CHECK(f.p_value > 1e-4);
  CHECK(f.dispersion < 1);
  CHECK(f.whole_p > 1e-4);
  CHECK(f.mean >= 0.53);
  CHECK(f.near <= (seeds + 9) / 10);  // 6 of the 360 sets of the slow case
  CHECK(f.least >= 0.43);
}

// A mesh whose density is one plus `rise` at its top and 1 at its bottom.
SpacedModel ramped(PolygonMesh mesh, const char* method, OrderKind order, double rise) {
  ScalarAttribute weight{"weight", {}};
  const auto [low, high] = std::minmax_element(mesh.z.begin(), mesh.z.end());
  for (const double z : mesh.z) weight.values.push_back(1 + rise * (z - *low) / (*high - *low));
  mesh.vertex_attributes.push_back(weight);
  SpacedModel model(mesh, method, SequenceKind::spaced, order);
  model.parameters.density.kind = DensityKind::vertex_attribute;
  model.parameters.density.attribute = "weight";
  run_stages(charting_stages(model.parameters), model.state);
  return model;
}

const char* name_of_order(OrderKind order) { return order == OrderKind::curve ? "along" : "progressive"; }

// ---- tensor fields ----

// Round the axis of the sphere, up to four times as long as wide; the torus wound around both ways.
ChartedModel sphere_of_ellipses() {
  const PolygonMesh mesh = icosphere(5);
  const auto formula = [](Vector3 p) {
    const double ratio = 1 + 3 * (1 - p.z * p.z);
    return std::pair{Vector3{-p.y, p.x, 0}, std::array<double, 2>{std::sqrt(ratio), 1 / std::sqrt(ratio)}};
  };
  return charted(mesh, anisotropic(TensorKind::table),
                 std::make_shared<TensorTable>(table_of(mesh, formula)));
}
ChartedModel torus_of_ellipses() {
  const PolygonMesh mesh = torus(120, 60);
  const auto formula = [](Vector3 p) {
    const double r = std::hypot(p.x, p.y);
    const Vector3 around = {-p.y / r, p.x / r, 0}, radial = {p.x / r, p.y / r, 0};
    const Vector3 across = -p.z / 0.4 * radial + Vector3{0, 0, (r - 1) / 0.4};
    return std::pair{around + across, std::array<double, 2>{1.5, 0.5}};
  };
  return charted(mesh, anisotropic(TensorKind::table),
                 std::make_shared<TensorTable>(table_of(mesh, formula)));
}

struct EllipseLimits {
  double axis = 0.10;     // of the ratio of axes, in units of spacings
  double classes = 0.10;  // in units of area, where the field asks for ratios above 2.5
  double mean_rho = 0.5, least_rho = 0.45;
};

// Axis ratios: of the samples, and of those with long ellipses over what is wanted.
struct EllipseFigures {
  double round = 0, stretched = 1;
};
EllipseFigures ellipse_figures(ChartedModel& model, SequenceKind sequence, std::uint32_t n,
                               std::uint32_t sets) {
  DipStudy study;
  study.samples = n;
  study.sets = sets;
  study.sequence = sequence;
  EllipseFigures figures;
  const DipFound round = dip_of(model, study);
  REQUIRE(round.dip.found);
  figures.round = axis_ratio(round.dip);
  study.units = DifferenceUnits::area;
  study.low = 2.5;
  const DipFound stretched = dip_of(model, study);
  if (stretched.share < 0.05) return figures;
  REQUIRE(stretched.dip.found);
  figures.stretched = axis_ratio(stretched.dip) / stretched.wanted;
  return figures;
}

// Smallest metric distance over that of the hexagonal lattice, an area per sample being 1.
double metric_rho(const ChartedModel& model, const Samples& samples) {
  const FieldSamples field = field_samples(model, samples);
  const std::vector<double> nearest = metric_nearest_distances(field.view());
  return *std::min_element(nearest.begin(), nearest.end()) / std::sqrt(2 / std::sqrt(3.0));
}

void check_ellipses(ChartedModel& model, const std::string& name, std::uint32_t n, std::uint32_t sets,
                    const EllipseLimits& limits) {
  const EllipseFigures own = ellipse_figures(model, SequenceKind::spaced, n, sets),
                       shifted = ellipse_figures(model, SequenceKind::shifted, n, sets);
  const PreparedMesh& mesh = model.state.surface;
  Density density;
  density.corner = tensor_density(make_tensor_field(model.state.file, mesh, model.parameters.tensor));
  const std::vector<double> masses = triangle_masses(mesh, density);
  const std::vector<std::uint32_t> region = grid_regions(mesh, 4);
  double least = 1e9, mean = 0, control = 0, p_value = 1;
  for (std::uint32_t set = 1; set <= sets; ++set) {
    const Samples& samples = draw(model, n, set, SequenceKind::spaced);
    const double rho = metric_rho(model, samples);
    least = std::min(least, rho);
    mean += rho / sets;
    p_value = std::min(p_value, region_counts(region, masses, samples.triangle, 64).test.p_value);
    control += metric_rho(model, draw(model, n, set, SequenceKind::shifted)) / sets;
  }
  INFO(name << ", " << n << ": axis ratio in spacings " << own.round << " (shifted " << shifted.round
            << "), of long ellipses over the wanted one " << own.stretched << " (shifted "
            << shifted.stretched << "); rho in the metric " << mean << " (" << least << "; shifted "
            << control << "); regions: p " << p_value);
  CHECK(own.round == Approx(1).epsilon(limits.axis));
  CHECK(own.stretched == Approx(1).epsilon(limits.classes));
  CHECK(mean >= limits.mean_rho);
  CHECK(least >= limits.least_rho);
  CHECK(p_value > 1e-4);
}

}  // namespace

TEST_CASE("spaced study: prefixes of a progressive set on a torus", "[statistics]") {
  check_prefixes(torus(60, 40), "torus", "auto", 1024, 6);
}

TEST_CASE("spaced study: prefixes of progressive sets on the meshes of the survey", "[slow]") {
  MEANDER_NEEDS_SHARED_DATA();
  for (const char* const file : meshes)
    for (const char* const method : {"auto", "direct"}) {
      const PolygonMesh mesh = shared_mesh(file);
      check_prefixes(mesh, file, method, 16384, 4);
      check_prefixes(mesh, file, method, 10000, 4);
    }
}

TEST_CASE("spaced study: a density on a sphere, its counts and its spacing", "[statistics]") {
  SpacedModel model = ramped(icosphere(4), "auto", OrderKind::curve, 8);
  check_density(model, "sphere, density 1 to 9", 2048, 4);
}

TEST_CASE("spaced study: densities, their counts and their spacing", "[slow]") {
  for (const char* const method : {"auto", "direct", "conformal"})
    for (const OrderKind order : {OrderKind::curve, OrderKind::progressive}) {
      const std::string setting = std::string(", ") + method + ", " + name_of_order(order);
      SpacedModel sphere = ramped(icosphere(5), method, order, 8),
                  ring = ramped(torus(96, 48), method, order, 3);
      check_density(sphere, "sphere, density 1 to 9" + setting, 4096, 20);
      check_density(ring, "torus, density 1 to 4" + setting, 4096, 20);
      if (!have_shared_data()) continue;
      SpacedModel bunny = ramped(shared_mesh("bunny_closed.off"), method, order, 8);
      check_density(bunny, "bunny, density 1 to 9" + setting, 4096, 20);
    }
}

TEST_CASE("spaced study: ellipses of a tensor field on a sphere", "[statistics]") {
  ChartedModel model = sphere_of_ellipses();
  check_ellipses(model, "sphere", 2048, 2, {});
}

TEST_CASE("spaced study: ellipses of tensor fields", "[slow]") {
  ChartedModel sphere = sphere_of_ellipses(), ring = torus_of_ellipses();
  check_ellipses(sphere, "sphere", 4096, 6, {});
  check_ellipses(ring, "torus", 4096, 6, {0.10, 0.10, 0.45, 0.35});
  if (!have_shared_data()) return;
  // Curvature, which changes within the reach of a sample: what is nearest by the tensors of both ends is not
  // what it is by that of one. Long ellipses of shifted samples fall short as well (docs/LABORATORY.md).
  for (const char* const file : {"bunny_closed.off", "fandisk.off"}) {
    ChartedModel model = charted(shared_mesh(file), anisotropic());
    check_ellipses(model, file, 4096, 6, {0.12, 0.28, 0.22, 0.10});
  }
}
