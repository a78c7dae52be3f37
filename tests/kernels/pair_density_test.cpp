#include "kernels/analyse/pair_density.h"

#include <cmath>
#include <numbers>
#include <stdexcept>

#include "support/catch.h"
#include "tests/support/metric_samples.h"

using namespace meander;
using namespace meander::test;

namespace {

using std::numbers::pi;

DifferenceParameters fine_map(double kernel = 1) {
  DifferenceParameters parameters;
  parameters.range = 3.5;
  parameters.cells = 224;
  parameters.kernel = kernel;
  return parameters;
}

// In either unit, in the principal axes.
struct Maps {
  DifferenceMap area, spacings;
  explicit Maps(const DifferenceParameters& parameters)
      : area(make_difference_map(parameters)), spacings(area) {}
};

void add(Maps& maps, const PlanarSamples& set, const std::vector<TangentTensor>& field,
         std::span<const std::uint8_t> counted = {}) {
  TensorDifferenceParameters parameters;
  parameters.counted = counted;
  add_anisotropic_differences(maps.spacings, set.x, set.y, field, parameters);
  parameters.units = DifferenceUnits::area;
  add_anisotropic_differences(maps.area, set.x, set.y, field, parameters);
}

std::vector<TangentTensor> constant_field(TangentTensor log_s, std::size_t samples) {
  const double scale = std::log(sample_spacing_scale(1, samples));
  return std::vector<TangentTensor>(samples, log_s + TangentTensor{scale, 0, scale});
}

// The reference of the open square: independent samples in the same field.
Maps random_reference(TangentTensor log_s, std::size_t samples, std::uint64_t sets,
                      const DifferenceParameters& parameters) {
  Maps maps(parameters);
  for (std::uint64_t s = 0; s < sets; ++s) {
    const PlanarSamples set = random_samples(samples, 900 + s);
    add(maps, set, constant_field(log_s, set.x.size()));
  }
  return maps;
}

DipParameters measured() {
  DipParameters parameters;
  parameters.measured_reference = true;
  return parameters;
}

// The dip of a Gaussian of these standard deviations, in an otherwise white map.
DifferenceMap gaussian_dip(const DifferenceParameters& parameters, double depth, double first, double second,
                           double angle) {
  DifferenceMap map = expected_differences(parameters, 100000);
  for (std::size_t c = 0; c < map.sum.size(); ++c) {
    const double x = (static_cast<double>(c % map.side()) + 0.5) * map.cell() - parameters.range;
    const double y = (static_cast<double>(c / map.side()) + 0.5) * map.cell() - parameters.range;
    const double u = (std::cos(angle) * x + std::sin(angle) * y) / first;
    const double v = (std::cos(angle) * y - std::sin(angle) * x) / second;
    map.sum[c] *= 1 - depth * std::exp(-0.5 * (u * u + v * v));
  }
  return map;
}

// Samples on a cylinder around the z axis of circumference 1 and height 1, jittered in a constant metric.
struct CylinderSamples {
  std::vector<double> points, normals, axes, s1, s2;
  TangentSamples view() const { return {points, normals, axes, s1, s2}; }
};
CylinderSamples cylinder(const PlanarSamples& set, TangentTensor log_s) {
  CylinderSamples surface;
  const double scale = sample_spacing_scale(1, set.x.size()), radius = 0.5 / pi;
  const TensorAxes axes = spacings_of(log_s);
  for (std::size_t i = 0; i < set.x.size(); ++i) {
    const double c = std::cos(2 * pi * set.x[i]), s = std::sin(2 * pi * set.x[i]);
    surface.points.insert(surface.points.end(), {radius * c, radius * s, set.y[i]});
    surface.normals.insert(surface.normals.end(), {c, s, 0.0});
    surface.axes.insert(surface.axes.end(), {-s * axes.x, c * axes.x, axes.y});
    surface.s1.push_back(scale * axes.first);
    surface.s2.push_back(scale * axes.second);
  }
  return surface;
}

}  // namespace

TEST_CASE("dips: a Gaussian is found with its parameters") {
  DifferenceParameters parameters = fine_map(1e-3);
  const DifferenceMap expected = expected_differences(parameters, 100000);
  for (const double ratio : {1.0, 2.0, 8.0}) {
    const double first = 0.4 * std::sqrt(ratio), second = 0.4 / std::sqrt(ratio);
    const DifferenceMap map = gaussian_dip(parameters, 0.8, first, second, -0.6);
    const Dip moments = dip_moments(map, expected);
    REQUIRE(moments.found);
    CHECK(moments.first == Approx(first).epsilon(5e-3));
    CHECK(moments.second == Approx(second).epsilon(5e-3));
    CHECK(moments.ratio == Approx(ratio).epsilon(2e-3));
    CHECK(moments.depth == Approx(0.8).epsilon(3e-3));
    CHECK(moments.signal_to_noise > 50);
    const Dip contour = dip_contour(map, expected);
    REQUIRE(contour.found);
    // exp(-r^2 / 2) = 1/2
    CHECK(contour.first == Approx(std::sqrt(2 * std::log(2.0)) * first).epsilon(0.01));
    CHECK(contour.ratio == Approx(ratio).epsilon(0.01));
    if (ratio == 1) continue;
    CHECK(moments.angle == Approx(-0.6).margin(1e-3));
    CHECK(contour.angle == Approx(-0.6).margin(0.01));
  }
  // The kernel's spread is taken off.
  parameters = fine_map(4);
  const double kernel = 4 * 7.0 / 224;
  const Dip wide =
      dip_moments(gaussian_dip(parameters, 0.8, std::hypot(0.8, kernel), std::hypot(0.2, kernel), 1),
                  expected_differences(parameters, 100000));
  REQUIRE(wide.found);
  CHECK(wide.ratio == Approx(4).epsilon(0.01));
}

TEST_CASE("dips: no dip, a peak, and dips beyond the map are not found") {
  const DifferenceParameters parameters = fine_map();
  const DifferenceMap expected = expected_differences(parameters, 100000);
  CHECK_FALSE(dip_moments(expected, expected).found);
  CHECK(dip_moments(expected, expected).signal_to_noise == 0);
  const Dip peak = dip_moments(gaussian_dip(parameters, -0.5, 0.4, 0.4, 0), expected);
  CHECK_FALSE(peak.found);
  CHECK(peak.signal_to_noise < -50);
  CHECK_FALSE(dip_moments(gaussian_dip(parameters, 0.5, 30, 30, 0), expected).found);
  CHECK_FALSE(dip_contour(gaussian_dip(parameters, 0.5, 30, 30, 0), expected).found);
}

TEST_CASE("dip_moments: random samples have none, and their signal has unit variance") {
  double squares = 0;
  constexpr int repeats = 24;
  DifferenceParameters parameters;
  for (std::uint64_t seed = 0; seed < repeats; ++seed) {
    DifferenceMap map = make_difference_map(parameters);
    const PlanarSamples set = random_samples(1500, 40 + seed);
    add_differences(map, set.x, set.y, 1 / std::sqrt(1500.0));
    const Dip dip = dip_moments(map, expected_differences(parameters, 1500, 1, 1));
    CHECK_FALSE(dip.found);
    CHECK(dip.ratio == 0);
    CHECK(std::abs(dip.signal_to_noise) < 4);
    CHECK(std::abs(dip.depth) < 0.1);
    squares += dip.signal_to_noise * dip.signal_to_noise / repeats;
  }
  CHECK(squares == Approx(1).margin(0.9));  // of 24: standard deviation 0.29; the kernel takes a little
  CHECK(squares > 0.3);
}

TEST_CASE("dip_moments: jittered samples of a constant tensor have its ratio and direction", "[statistics]") {
  const DifferenceParameters parameters = fine_map();
  constexpr std::size_t n = 4096;
  for (const double ratio : {1.0, 2.0, 4.0, 8.0})
    for (const double angle : {0.5, 2.2}) {
      INFO("ratio " << ratio << " angle " << angle);
      const TangentTensor log_s = log_spacing(ratio, angle);
      DifferenceMap map = make_difference_map(parameters);
      TensorDifferenceParameters in_plane;
      in_plane.units = DifferenceUnits::area;
      in_plane.principal_axes = false;
      for (std::uint64_t s = 0; s < 2; ++s) {
        const PlanarSamples set = jittered_samples(n, log_s, 0.2 + 0.7 * static_cast<double>(s), 10 * s + 7);
        add_anisotropic_differences(map, set.x, set.y, constant_field(log_s, set.x.size()), in_plane);
      }
      const Dip dip = dip_moments(map, expected_differences(parameters, n, 1, 1));
      REQUIRE(dip.found);
      CHECK(dip.signal_to_noise > 20);
      CHECK(dip.ratio == Approx(ratio).epsilon(0.1));
      CHECK(dip.depth == Approx(0.83).margin(0.1));
      // Second moments of (1 - |x|)(1 - |y|): 1/6; the Gaussian that fits best is a little wider.
      CHECK(dip.first * dip.second == Approx(0.195).epsilon(0.12));
      if (ratio > 1) CHECK(std::abs(std::sin(dip.angle - angle)) < 0.06);
    }
}

TEST_CASE("dip_contour: gives the same ratios, less exactly") {
  const DifferenceParameters parameters = fine_map(2);
  for (const double ratio : {1.0, 4.0}) {
    const TangentTensor log_s = log_spacing(ratio, 0.5);
    DifferenceMap map = make_difference_map(parameters);
    TensorDifferenceParameters in_area;
    in_area.units = DifferenceUnits::area;
    for (std::uint64_t s = 0; s < 2; ++s) {
      const PlanarSamples set = jittered_samples(4096, log_s, 0.2 + 0.7 * static_cast<double>(s), 10 * s + 7);
      add_anisotropic_differences(map, set.x, set.y, constant_field(log_s, set.x.size()), in_area);
    }
    const Dip dip = dip_contour(map, expected_differences(parameters, 4096));
    REQUIRE(dip.found);
    CHECK(dip.ratio == Approx(ratio).epsilon(0.25));
    if (ratio > 1) CHECK(std::abs(dip.angle) < 0.1);  // the principal axes of the map
  }
}

TEST_CASE("dip_moments: in units of spacings the dip is round for every ratio") {
  const DifferenceParameters parameters = fine_map();
  for (const double ratio : {3.0, 8.0}) {
    INFO("ratio " << ratio);
    const TangentTensor log_s = log_spacing(ratio, 0.5);
    const PlanarSamples set = jittered_samples(3000, log_s, 0.2, 12);
    Maps maps(parameters);
    add(maps, set, constant_field(log_s, set.x.size()));
    // Long windows leave the open square: only a reference of the same field takes that into account.
    const Maps reference = random_reference(log_s, set.x.size(), 2, parameters);
    const Dip dip = dip_moments(maps.spacings, reference.spacings, measured());
    REQUIRE(dip.found);
    CHECK(dip.ratio == Approx(1).margin(0.15));
    const Dip area = dip_moments(maps.area, reference.area, measured());
    REQUIRE(area.found);
    CHECK(area.ratio == Approx(ratio).epsilon(0.15));
    CHECK(std::abs(area.angle) < 0.06);  // long along e1, the x axis of the map
  }
}

TEST_CASE("dip_moments: a field of varying ratio, by classes and scale-free", "[slow]") {
  // x' = 8^u: strata of the unit square in (u, v) become longer along x; s1 = 8^u, s2 = 1.
  const double k = std::log(8.0);
  const auto stretched = [&](PlanarSamples set) {
    for (double& x : set.x) x = std::expm1(k * x) / k;
    return set;
  };
  const auto field_of = [&](const PlanarSamples& set) {
    std::vector<TangentTensor> field;
    const double scale = std::log(sample_spacing_scale(1, set.x.size()));
    for (const double x : set.x) field.push_back({std::log1p(k * x) + scale, 0, scale});
    return field;
  };
  const DifferenceParameters parameters = fine_map();
  const std::vector<double> edges = {std::sqrt(2.0), std::sqrt(8.0), std::sqrt(32.0)};
  std::vector<Maps> maps(5, Maps(parameters)), reference(5, Maps(parameters));
  const auto add_set = [&](std::vector<Maps>& to, const PlanarSamples& set) {
    const std::vector<TangentTensor> field = field_of(set);
    std::vector<double> s1, s2;
    for (const TangentTensor& t : field) {
      s1.push_back(std::exp(t.xx));
      s2.push_back(std::exp(t.yy));
    }
    const std::vector<std::uint32_t> classes = ratio_classes(s1, s2, edges);
    for (std::uint32_t c = 0; c < 4; ++c) {
      std::vector<std::uint8_t> counted;
      for (const std::uint32_t of : classes) counted.push_back(of == c);
      add(to[c], set, field, counted);
    }
    add(to[4], set, field);
  };
  for (std::uint64_t s = 0; s < 12; ++s) {
    add_set(maps, stretched(jittered_samples(4096, {}, 0.5 * static_cast<double>(s), s + 1)));
    add_set(reference, stretched(random_samples(4096, s + 70)));
  }
  const Dip all = dip_moments(maps[4].spacings, reference[4].spacings, measured());
  REQUIRE(all.found);
  CHECK(all.ratio == Approx(1).margin(0.15));
  for (std::size_t c = 0; c < 4; ++c) {
    INFO("class " << c);
    const Dip spacings = dip_moments(maps[c].spacings, reference[c].spacings, measured());
    REQUIRE(spacings.found);
    CHECK(spacings.ratio == Approx(1).margin(0.15));
    const Dip area = dip_moments(maps[c].area, reference[c].area, measured());
    REQUIRE(area.found);
    // The means of the logarithm in the classes: 2^(1/4), 2, 4, 2^(11/4).
    const double ratio = c == 0   ? std::exp2(0.25)
                         : c == 3 ? std::exp2(2.75)
                                  : std::exp2(static_cast<double>(c));
    CHECK(area.ratio == Approx(ratio).epsilon(0.15));
  }
}

TEST_CASE("dip_moments: hold on a curved surface", "[statistics]") {
  DifferenceParameters parameters;
  parameters.range = 2.5;
  parameters.cells = 160;
  for (const double ratio : {1.0, 4.0}) {
    INFO("ratio " << ratio);
    const TangentTensor log_s = log_spacing(ratio, 0.5);
    DifferenceMap area = make_difference_map(parameters), spacings = area;
    DifferenceMap random_area = area, random_spacings = area;
    TensorDifferenceParameters in_area;
    in_area.units = DifferenceUnits::area;
    for (std::uint64_t s = 0; s < 2; ++s) {
      const CylinderSamples strata =
          cylinder(jittered_samples(4096, log_s, 0.4 + 0.8 * static_cast<double>(s), s + 4), log_s);
      add_anisotropic_surface_differences(area, strata.view(), in_area);
      add_anisotropic_surface_differences(spacings, strata.view());
      const CylinderSamples noise = cylinder(random_samples(4096, s + 44), log_s);
      add_anisotropic_surface_differences(random_area, noise.view(), in_area);
      add_anisotropic_surface_differences(random_spacings, noise.view());
    }
    const Dip stretched = dip_moments(area, random_area, measured());
    REQUIRE(stretched.found);
    CHECK(stretched.ratio == Approx(ratio).epsilon(0.12));
    if (ratio > 1) CHECK(std::abs(stretched.angle) < 0.06);
    const Dip round = dip_moments(spacings, random_spacings, measured());
    REQUIRE(round.found);
    CHECK(round.ratio == Approx(1).margin(0.15));
    CHECK_FALSE(dip_moments(random_area, expected_differences(parameters, 4096)).found);
  }
}

TEST_CASE("pair density: classes and expectations, and invalid arguments are refused") {
  const std::vector<double> s1 = {1, 2, 3, 8}, s2 = {1, 1, 1, 2}, edges = {2, 3.5};
  CHECK(ratio_classes(s1, s2, edges) == std::vector<std::uint32_t>{0, 1, 1, 2});
  CHECK_THROWS_AS(ratio_classes(s1, edges, edges), std::invalid_argument);
  CHECK_THROWS_AS(ratio_classes(s1, s2, std::vector<double>{2, 2}), std::invalid_argument);

  const DifferenceParameters parameters;
  const DifferenceMap expected = expected_differences(parameters, 100, 25);
  CHECK(expected.sum[0] == Approx(0.25 * 99 * expected.cell() * expected.cell()));
  CHECK_THROWS_AS(expected_differences(parameters, 10, 11), std::invalid_argument);
  CHECK_THROWS_AS(dip_moments(make_difference_map(parameters), expected), std::invalid_argument);
  CHECK_THROWS_AS(dip_moments(expected_differences(fine_map(), 100), expected), std::invalid_argument);
  DipParameters wrong;
  wrong.start = 0;
  CHECK_THROWS_AS(dip_moments(expected, expected, wrong), std::invalid_argument);
  CHECK_THROWS_AS(dip_contour(expected, expected, wrong), std::invalid_argument);
}

TEST_CASE("half_depth_ellipse: a Gaussian is at half its height there") {
  Dip dip;
  dip.first = 0.5;
  dip.second = 0.2;
  dip.angle = 0.7;
  const auto points = half_depth_ellipse(dip, 64);
  REQUIRE(points.size() == 64);
  CHECK(std::atan2(points[0][1], points[0][0]) == Approx(dip.angle));
  for (const auto& [x, y] : points) {
    const double along = std::cos(dip.angle) * x + std::sin(dip.angle) * y,
                 across = std::cos(dip.angle) * y - std::sin(dip.angle) * x;
    const double u = along / dip.first, v = across / dip.second;
    CHECK(std::exp(-0.5 * (u * u + v * v)) == Approx(0.5));
  }
}
