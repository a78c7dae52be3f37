#include <oneapi/tbb/task_arena.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "kernels/analyse/differential_domain.h"
#include "support/catch.h"
#include "tests/support/metric_samples.h"
#include "tests/support/tangent_arrays.h"

using namespace meander;
using namespace meander::test;

namespace {

// log S with s1 s2 = the area per sample of `samples` in the unit square.
TangentTensor scaled(TangentTensor log_s, std::size_t samples) {
  const double add = std::log(sample_spacing_scale(1, samples));
  return log_s + TangentTensor{add, 0, add};
}

// A field whose ratio, direction and density vary over the square.
std::vector<TangentTensor> varying_field(const PlanarSamples& set) {
  std::vector<TangentTensor> field;
  for (std::size_t i = 0; i < set.x.size(); ++i)
    field.push_back(
        scaled(log_spacing(1 + 3 * set.x[i], 2 * set.y[i]) + TangentTensor{0.3 * set.y[i], 0, 0.3 * set.y[i]},
               set.x.size()));
  return field;
}

// In a plane spanned by two unit vectors.
TangentArrays in_space(const PlanarSamples& set, const std::vector<TangentTensor>& field, Vector3 x,
                       Vector3 y) {
  TangentArrays surface;
  for (std::size_t i = 0; i < set.x.size(); ++i) {
    const TensorAxes axes = spacings_of(field[i]);
    const double sign = i % 3 == 0 ? -1.7 : 0.4;  // neither sign nor length of e1 matters
    surface.add(set.x[i] * x + set.y[i] * y + Vector3{1, 2, 3}, 2.5 * cross(x, y),
                sign * (axes.x * x + axes.y * y), axes.first, axes.second);
  }
  return surface;
}

double largest(const DifferenceMap& a, const DifferenceMap& b) {
  double worst = 0;
  for (std::size_t c = 0; c < a.sum.size(); ++c) worst = std::max(worst, std::abs(a.sum[c] - b.sum[c]));
  return worst;
}

double total(const DifferenceMap& map) {
  double sum = 0;
  for (const double v : map.sum) sum += v;
  return sum;
}

DifferenceParameters small_map() {
  DifferenceParameters parameters;
  parameters.cells = 32;
  parameters.range = 2;
  return parameters;
}

}  // namespace

TEST_CASE("add_anisotropic_differences: tensors act as their inverse Jacobians") {
  const PlanarSamples set = random_samples(300, 5);
  const std::vector<TangentTensor> field = varying_field(set);
  std::vector<double> inverse;
  for (const TangentTensor& log_s : field) {
    const TangentTensor m = exponential(-1.0 * log_s);
    inverse.insert(inverse.end(), {m.xx, m.xy, m.xy, m.yy});
  }
  DifferenceMap expected = make_difference_map(small_map()), map = expected;
  add_anisotropic_differences(expected, set.x, set.y, inverse);
  TensorDifferenceParameters parameters;
  parameters.principal_axes = false;
  add_anisotropic_differences(map, set.x, set.y, field, parameters);
  REQUIRE(total(map) > 1000);
  CHECK(largest(map, expected) < 1e-10);
}

TEST_CASE("add_anisotropic_differences: isotropic tensors give the uniform map in either unit") {
  const PlanarSamples set = jittered_samples(400, {}, 0.3, 5);
  const std::vector<TangentTensor> field(set.x.size(), scaled({}, set.x.size()));
  DifferenceMap expected = make_difference_map(small_map());
  add_differences(expected, set.x, set.y, sample_spacing_scale(1, set.x.size()));
  for (const DifferenceUnits units : {DifferenceUnits::spacings, DifferenceUnits::area}) {
    DifferenceMap map = make_difference_map(small_map());
    TensorDifferenceParameters parameters;
    parameters.units = units;
    add_anisotropic_differences(map, set.x, set.y, field, parameters);
    CHECK(largest(map, expected) < 1e-9);
  }
}

TEST_CASE("add_anisotropic_differences: equals the sum over all pairs in frames and units") {
  const PlanarSamples set = random_samples(120, 8);
  const std::vector<TangentTensor> field = varying_field(set);
  std::vector<std::uint8_t> counted(set.x.size());
  for (std::size_t i = 0; i < counted.size(); ++i) counted[i] = i % 4 == 0;
  DifferenceParameters cells = small_map();
  cells.kernel = 0.1;  // one cell each
  for (const bool by_area : {false, true}) {
    DifferenceMap map = make_difference_map(cells);
    TensorDifferenceParameters parameters;
    parameters.units = by_area ? DifferenceUnits::area : DifferenceUnits::spacings;
    parameters.counted = counted;
    add_anisotropic_differences(map, set.x, set.y, field, parameters);
    std::vector<double> expected(map.sum.size(), 0.0);
    for (std::size_t i = 0; i < set.x.size(); ++i)
      for (std::size_t j = 0; j < set.x.size(); ++j) {
        if (i == j || !counted[i]) continue;
        const auto inverse = [&](std::size_t k) {
          const double half = 0.5 * trace(field[k]);
          return exponential(by_area ? TangentTensor{-half, 0, -half} : -1.0 * field[k]);
        };
        const TangentTensor mean = 0.5 * (inverse(i) + inverse(j));
        const double dx = set.x[i] - set.x[j], dy = set.y[i] - set.y[j];
        const double qx = mean.xx * dx + mean.xy * dy, qy = mean.xy * dx + mean.yy * dy;
        // Kept within reach of the map's corner and the kernel from both.
        const auto length = [&](TangentTensor m) {
          return std::hypot(m.xx * dx + m.xy * dy, m.xy * dx + m.yy * dy);
        };
        if (std::max(length(inverse(i)), length(inverse(j))) > std::sqrt(2.0) * (2 + 3 * 0.1 / 8)) continue;
        const TensorAxes axes = tensor_axes(field[i]);
        const double u = axes.x * qx + axes.y * qy, v = axes.x * qy - axes.y * qx;
        // Both at the difference and opposite to it: half each.
        for (const double sign : {-1.0, 1.0}) {
          const double a = std::floor((sign * u + 2) * 8), b = std::floor((sign * v + 2) * 8);
          if (a >= 0 && a < 32 && b >= 0 && b < 32)
            expected[static_cast<std::size_t>(b) * 32 + static_cast<std::size_t>(a)] += 0.5;
        }
      }
    for (std::size_t c = 0; c < expected.size(); ++c) CHECK(map.sum[c] == Approx(expected[c]).margin(1e-9));
    CHECK(total(map) > 300);
  }
}

TEST_CASE("add_anisotropic_surface_differences: a plane in space gives the map of the plane") {
  const PlanarSamples set = random_samples(300, 6);
  const std::vector<TangentTensor> field = varying_field(set);
  std::vector<std::uint8_t> counted(set.x.size());
  for (std::size_t i = 0; i < counted.size(); ++i) counted[i] = set.x[i] > 0.5;
  for (const DifferenceUnits units : {DifferenceUnits::spacings, DifferenceUnits::area})
    for (const bool all : {true, false}) {
      TensorDifferenceParameters parameters;
      parameters.units = units;
      if (!all) parameters.counted = counted;
      DifferenceMap expected = make_difference_map(small_map()), map = expected, turned = expected;
      add_anisotropic_differences(expected, set.x, set.y, field, parameters);
      add_anisotropic_surface_differences(map, in_space(set, field, {1, 0, 0}, {0, 1, 0}).view(), parameters);
      CHECK(total(map) > 500);
      CHECK(largest(map, expected) < 1e-8);
      const Vector3 x = {0.6, 0, 0.8}, y = {0.48, 0.8, -0.36};
      add_anisotropic_surface_differences(turned, in_space(set, field, x, y).view(), parameters);
      CHECK(largest(turned, expected) < 1e-8);
    }
}

TEST_CASE("add_anisotropic_surface_differences: isotropic spacings on a sphere, for any threads") {
  const PlanarSamples u = random_samples(3000, 7);
  TangentArrays sphere;
  std::vector<double> spacing;
  const double s = sample_spacing_scale(4 * std::numbers::pi, 3000);
  for (std::size_t i = 0; i < u.x.size(); ++i) {
    const double z = 2 * u.x[i] - 1, r = std::sqrt(1 - z * z), a = 2 * std::numbers::pi * u.y[i];
    const Vector3 p = {r * std::cos(a), r * std::sin(a), z};
    sphere.add(p, p, {-p.y, p.x, 0}, s, s);
  }
  spacing = sphere.s1;
  DifferenceMap expected = make_difference_map(small_map()), map = expected, serial = expected;
  add_surface_differences(expected, sphere.points, sphere.normals, spacing, sphere.axes);
  add_anisotropic_surface_differences(map, sphere.view());
  CHECK(total(map) > 10000);
  CHECK(largest(map, expected) < 1e-8);
  oneapi::tbb::task_arena one(1);
  one.execute([&] { add_anisotropic_surface_differences(serial, sphere.view()); });
  CHECK(serial.sum == map.sum);
}

TEST_CASE("add_anisotropic_surface_differences: random samples of a sphere are white in any field") {
  DifferenceParameters parameters = small_map();
  DifferenceMap map = make_difference_map(parameters);
  constexpr std::size_t n = 3000;
  for (std::uint64_t seed = 0; seed < 2; ++seed) {
    const PlanarSamples u = random_samples(n, 17 + seed);
    TangentArrays sphere;
    const double s = sample_spacing_scale(4 * std::numbers::pi, n);
    for (std::size_t i = 0; i < n; ++i) {
      const double z = 2 * u.x[i] - 1, r = std::sqrt(1 - z * z), a = 2 * std::numbers::pi * u.y[i];
      const Vector3 p = {r * std::cos(a), r * std::sin(a), z};
      // Along meridians, about the x axis (where the field is isotropic).
      const double half = 0.5 * std::log(1 + 3 * (1 - p.x * p.x));
      sphere.add(p, p, Vector3{1, 0, 0} - p.x * p, s * std::exp(half), s * std::exp(-half));
    }
    add_anisotropic_surface_differences(map, sphere.view());
  }
  const std::vector<double> g = normalized_differences(map, expected_differences(parameters, n));
  const RadialProfile profile = radial_differences(map, g, 2);
  // Unordered pairs of a ring: n per unit of q-area in two sets. The field bends within the range and
  // curvature takes off 1 - d^2 / 6: a few per cent.
  for (std::size_t k = 0; k < profile.rings(); ++k) {
    const double width = 2 * map.cell(),
                 area = std::numbers::pi * (2.0 * static_cast<double>(k) + 1) * width * width;
    CHECK(profile.mean[k] == Approx(1).margin(0.04 + 4 / std::sqrt(n * area)));
  }
}

TEST_CASE("add_anisotropic_surface_differences: samples on other sheets of a fold do not count") {
  const PlanarSamples set = random_samples(300, 6), other = random_samples(300, 16);
  const std::vector<TangentTensor> field(300, scaled(log_spacing(4, 0.3), 300));
  TangentArrays front = in_space(set, field, {1, 0, 0}, {0, 1, 0});
  const TangentArrays back = in_space(other, field, {0, 1, 0}, {1, 0, 0});  // the normal downwards
  DifferenceMap apart = make_difference_map(small_map()), together = apart;
  add_anisotropic_surface_differences(apart, front.view());
  add_anisotropic_surface_differences(apart, back.view());
  const auto append = [](std::vector<double>& to, const std::vector<double>& from) {
    to.insert(to.end(), from.begin(), from.end());
  };
  append(front.points, back.points);
  append(front.normals, back.normals);
  append(front.axes, back.axes);
  append(front.s1, back.s1);
  append(front.s2, back.s2);
  add_anisotropic_surface_differences(together, front.view());
  CHECK(largest(apart, together) < 1e-9);
  TensorDifferenceParameters all;
  all.min_normal_cosine = -1;
  DifferenceMap mixed = make_difference_map(small_map());
  add_anisotropic_surface_differences(mixed, front.view(), all);
  CHECK(total(mixed) > 1.5 * total(together));
}

TEST_CASE("geodesic_vector: exact on the sphere") {
  const TangentFrame frame = frame_along({0, 0, 1}, {1, 1, 0});
  const double angle = 0.7;
  const Vector3 q = {0, std::sin(angle), std::cos(angle)};
  const auto v = geodesic_vector({0, 0, 1}, frame, q, q);
  REQUIRE(v);
  CHECK((*v)[0] == Approx(angle * std::sqrt(0.5)));
  CHECK((*v)[1] == Approx(angle * std::sqrt(0.5)));
  CHECK(*geodesic_vector({0, 0, 1}, frame, {0, 0, 1}, q) == std::array<double, 2>{0, 0});
  CHECK_FALSE(geodesic_vector({0, 0, 1}, frame, {0, 0, 2}, q));
}

TEST_CASE("anisotropic differences: invalid arguments are refused") {
  DifferenceMap map = make_difference_map(small_map());
  const PlanarSamples set = random_samples(3, 6);
  std::vector<TangentTensor> field(3, scaled({}, 3));
  const std::vector<std::uint8_t> two = {1, 1};
  TensorDifferenceParameters parameters;
  parameters.counted = two;
  CHECK_THROWS_AS(add_anisotropic_differences(map, set.x, set.y, field, parameters), std::invalid_argument);
  CHECK_THROWS_AS(
      add_anisotropic_surface_differences(map, in_space(set, field, {1, 0, 0}, {0, 1, 0}).view(), parameters),
      std::invalid_argument);
  parameters = {};
  parameters.min_normal_cosine = 2;
  CHECK_THROWS_AS(
      add_anisotropic_surface_differences(map, in_space(set, field, {1, 0, 0}, {0, 1, 0}).view(), parameters),
      std::invalid_argument);
  TangentArrays bad = in_space(set, field, {1, 0, 0}, {0, 1, 0});
  bad.s2[1] = 0;
  CHECK_THROWS_AS(add_anisotropic_surface_differences(map, bad.view()), std::invalid_argument);
  bad = in_space(set, field, {1, 0, 0}, {0, 1, 0});
  bad.normals[5] = 0;
  CHECK_THROWS_AS(add_anisotropic_surface_differences(map, bad.view()), std::invalid_argument);
  bad.axes.pop_back();
  CHECK_THROWS_AS(add_anisotropic_surface_differences(map, bad.view()), std::invalid_argument);
  field[0].xx = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_AS(add_anisotropic_differences(map, set.x, set.y, field), std::invalid_argument);
  field.pop_back();
  CHECK_THROWS_AS(add_anisotropic_differences(map, set.x, set.y, field), std::invalid_argument);
  CHECK_THROWS_AS(sample_spacing_scale(0, 3), std::invalid_argument);
  CHECK_THROWS_AS(sample_spacing_scale(1, 0), std::invalid_argument);
}
