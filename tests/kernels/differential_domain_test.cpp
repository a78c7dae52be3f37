#include "kernels/analyse/differential_domain.h"

#include <oneapi/tbb/task_arena.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "kernels/core/random.h"
#include "support/catch.h"
#include "support/metric_samples.h"

using namespace meander;
using namespace meander::test;

namespace {

using std::numbers::pi;

// The weight of cell k of an axis for a difference q, the slow way.
double axis_weight(double q, std::uint32_t k, const DifferenceParameters& parameters) {
  const double cell = 2 * parameters.range / parameters.cells;
  const auto gauss = [&](double j) {
    const double d = (q - ((j + 0.5) * cell - parameters.range)) / (cell * parameters.kernel);
    return std::abs(d) <= 3 ? std::exp(-0.5 * d * d) : 0;
  };
  double sum = 0;
  for (int j = -1000; j < 2000; ++j) sum += gauss(j);
  return gauss(k) / sum;
}

// Points on the unit sphere: uniform, and their normals are themselves.
std::vector<double> random_sphere(std::size_t count, std::uint64_t seed) {
  const PlanarSamples u = random_samples(count, seed);
  std::vector<double> points;
  for (std::size_t i = 0; i < count; ++i) {
    const double z = 2 * u.x[i] - 1, r = std::sqrt(1 - z * z), a = 2 * pi * u.y[i];
    points.insert(points.end(), {r * std::cos(a), r * std::sin(a), z});
  }
  return points;
}

double total(const std::vector<double>& values) {
  double sum = 0;
  for (const double v : values) sum += v;
  return sum;
}

double largest_difference(const DifferenceMap& a, const DifferenceMap& b) {
  double worst = 0;
  for (std::size_t c = 0; c < a.sum.size(); ++c) worst = std::max(worst, std::abs(a.sum[c] - b.sum[c]));
  return worst;
}

}  // namespace

TEST_CASE("add_differences: equals the sum over all pairs", "[release]") {
  DifferenceParameters parameters;
  parameters.cells = 21;
  parameters.range = 2;
  for (const double kernel : {0.1, 1.0, 2.5}) {
    parameters.kernel = kernel;
    const PlanarSamples set = random_samples(60, 3);
    const double spacing = 0.1;
    DifferenceMap map = make_difference_map(parameters);
    add_differences(map, set.x, set.y, spacing);
    std::vector<double> expected(map.sum.size(), 0.0);
    std::vector<double> wx(21), wy(21);
    for (std::size_t i = 0; i < 60; ++i)
      for (std::size_t j = 0; j < 60; ++j) {
        const double qx = (set.x[i] - set.x[j]) / spacing, qy = (set.y[i] - set.y[j]) / spacing;
        if (i == j || std::max(std::abs(qx), std::abs(qy)) > 4) continue;
        for (std::uint32_t k = 0; k < 21; ++k) {
          if (kernel < 0.5) {  // narrower than a cell: the cell that holds q
            wx[k] = std::floor((qx + 2) * 21 / 4) == k;
            wy[k] = std::floor((qy + 2) * 21 / 4) == k;
          } else {
            wx[k] = axis_weight(qx, k, parameters);
            wy[k] = axis_weight(qy, k, parameters);
          }
        }
        for (std::size_t b = 0; b < 21; ++b)
          for (std::size_t a = 0; a < 21; ++a) expected[21 * b + a] += wx[a] * wy[b];
      }
    REQUIRE(total(expected) > 100);
    for (std::size_t c = 0; c < expected.size(); ++c)
      CHECK(map.sum[c] == Approx(expected[c]).epsilon(1e-11).margin(1e-11));
    for (std::size_t c = 0; c < expected.size(); ++c)
      CHECK(map.sum[c] == Approx(map.sum[expected.size() - 1 - c]).margin(1e-12));
  }
}

TEST_CASE("add_differences: white noise on the torus is 1") {
  DifferenceParameters parameters;
  parameters.cells = 64;
  constexpr std::size_t n = 1500;
  const double spacing = 1 / std::sqrt(static_cast<double>(n));
  DifferenceMap map = make_difference_map(parameters);
  for (std::uint64_t s = 0; s < 10; ++s) {
    const PlanarSamples set = random_samples(n, 50 + s);
    add_differences(map, set.x, set.y, spacing, {1, 1});
  }
  CHECK(map.sets == 10);
  const std::vector<double> ratio = normalized_differences(map, expected_differences(parameters, n));
  // 10 n / 2 unordered pairs per unit of q: 64 x 7500 in the map, each counted twice, independent.
  const double pairs = 10 * n / 2.0 * 64;
  CHECK(total(ratio) / static_cast<double>(ratio.size()) == Approx(1).margin(4 / std::sqrt(pairs)));
  // One cell: the kernel gathers 4 pi kernel^2 cells, of 10 n / 64 = 234.4 ordered pairs each, no two of them
  // the same pair.
  double squares = 0;
  for (const double r : ratio) squares += (r - 1) * (r - 1) / static_cast<double>(ratio.size());
  CHECK(squares == Approx(1 / (4 * pi * 234.4)).epsilon(0.15));
  const RadialProfile profile = radial_differences(map, ratio);
  REQUIRE(profile.rings() == 32);
  for (std::size_t k = 0; k < profile.rings(); ++k) {
    const double area = pi * (2.0 * static_cast<double>(k) + 1) * map.cell() * map.cell();
    CHECK(profile.mean[k] == Approx(1).margin(4.5 / std::sqrt(10 * n / 2.0 * area)));
  }
}

TEST_CASE("expected_differences: a bounded rectangle matches many random sets") {
  DifferenceParameters parameters;
  parameters.cells = 48;
  parameters.range = 3;
  constexpr std::size_t n = 150;  // 15 x 10 spacings: the map reaches a third of the way across
  const double width = 1.5, height = 1;
  DifferenceMap map = make_difference_map(parameters);
  constexpr int sets = 600;
  for (std::uint64_t s = 0; s < sets; ++s) {
    PlanarSamples set = random_samples(n, 1000 + s);
    for (double& x : set.x) x *= width;
    add_differences(map, set.x, set.y, std::sqrt(width * height / n));
  }
  const DifferenceMap expected = expected_differences(parameters, n, width, height);
  const std::vector<double> ratio = normalized_differences(map, expected);
  const double middle = expected.sum[24 * 48 + 24], corner = expected.sum[0];
  CHECK(middle == Approx(149.0 * map.cell() * map.cell()).epsilon(0.02));
  CHECK(corner == Approx(149.0 * map.cell() * map.cell() * (1 - 3 / 15.0) * (1 - 3 / 10.0)).epsilon(0.02));
  // Thirds of the map, 4 square units each: 600 x 75 x 4 x ~0.65 unordered pairs.
  for (std::size_t b = 0; b < 3; ++b)
    for (std::size_t a = 0; a < 3; ++a) {
      double sum = 0;
      for (std::size_t j = 0; j < 16; ++j)
        for (std::size_t i = 0; i < 16; ++i) sum += ratio[(16 * b + j) * 48 + 16 * a + i] / 256;
      CHECK(sum == Approx(1).margin(4.5 / std::sqrt(sets * 75 * 4 * 0.65)));
    }
}

TEST_CASE("add_differences: a jittered grid dips at 0, as its pair density says") {
  DifferenceParameters parameters;
  parameters.cells = 65;  // an odd number: one cell lies at 0
  parameters.range = 3.25;
  constexpr std::size_t side = 32;
  constexpr std::size_t n = side * side;
  DifferenceMap map = make_difference_map(parameters);
  constexpr int sets = 40;
  for (std::uint64_t s = 0; s < sets; ++s) {
    const PlanarSamples set = grid_samples(side, 70 + s);
    add_differences(map, set.x, set.y, 1.0 / side, {1, 1});
  }
  const std::vector<double> ratio = normalized_differences(map, expected_differences(parameters, n));
  // Pairs of one cell are missing: 1 - (1 - |qx|)+ (1 - |qy|)+ in units of cells, times n / (n - 1); at 0
  // this is 0, with the kernel (0.1) about 0.15; at distance 1 and beyond it is 1.
  CHECK(ratio[32 * 65 + 32] < 0.25);
  CHECK(ratio[32 * 65 + 32] > 0.08);
  const auto tent = [](double q) { return std::max(0.0, 1 - std::abs(q)); };
  double chi = 0;
  for (std::size_t b = 0; b < 65; ++b)
    for (std::size_t a = 0; a < 65; ++a) {
      double expected = 0;  // under the kernel
      for (int v = -3; v <= 3; ++v)
        for (int u = -3; u <= 3; ++u) {
          const double w = std::exp(-0.5 * (u * u + v * v)) / std::pow(2.506, 2);
          expected += w * (1 - tent((static_cast<double>(a) - 32 + u) * 0.1) *
                                   tent((static_cast<double>(b) - 32 + v) * 0.1));
        }
      // sets n x 0.01 x 4 pi = 5147 pairs count in one cell.
      const double z = (ratio[65 * b + a] / expected - 1) * std::sqrt(5147.0 * expected);
      chi += z * z / (65 * 65);
    }
  CHECK(chi == Approx(1).margin(0.25));
  const RadialProfile profile = radial_differences(map, ratio);
  CHECK(profile.mean[15] == Approx(1).margin(0.01));
  CHECK(profile.mean[0] < 0.3);
}

TEST_CASE("add_density_differences: constant spacing is the uniform case") {
  const PlanarSamples set = random_samples(400, 6);
  DifferenceMap uniform = make_difference_map(), density = uniform, anisotropic = uniform;
  add_differences(uniform, set.x, set.y, 0.05);
  add_density_differences(density, set.x, set.y, std::vector<double>(400, 0.05));
  std::vector<double> inverse;
  for (int i = 0; i < 400; ++i) inverse.insert(inverse.end(), {20, 0, 0, 20});
  add_anisotropic_differences(anisotropic, set.x, set.y, inverse);
  CHECK(largest_difference(uniform, density) < 1e-11);
  CHECK(largest_difference(uniform, anisotropic) < 1e-11);
}

TEST_CASE("add_density_differences: the scale of space and of the density cancels") {
  PlanarSamples set = random_samples(500, 12);
  for (double& x : set.x) x = std::sqrt(x);  // density 2 x
  std::vector<double> phi, phi_scaled;
  for (const double x : set.x) {
    phi.push_back(2 * x);
    phi_scaled.push_back(1e6 * x);
  }
  const auto spacing = spacing_from_density(phi, 1, 0.2);
  CHECK(spacing[0] == Approx(std::sqrt(1 / (500 * phi[0]))));
  const auto same = spacing_from_density(phi_scaled, 5e5, 0.2);
  for (std::size_t i = 0; i < 500; ++i) CHECK(same[i] == Approx(spacing[i]).epsilon(1e-14));
  DifferenceMap a = make_difference_map(), b = a;
  add_density_differences(a, set.x, set.y, spacing);
  PlanarSamples large = set;
  std::vector<double> large_spacing = spacing;
  for (std::size_t i = 0; i < 500; ++i) {
    large.x[i] *= 4096;
    large.y[i] *= 4096;
    large_spacing[i] *= 4096;
  }
  add_density_differences(b, large.x, large.y, large_spacing);
  CHECK(largest_difference(a, b) < 1e-11);
}

TEST_CASE("add_density_differences: white noise of a slowly varying density is 1") {
  // Density 1 + 0.8 sin(2 pi x) on the torus, by inversion (bisection). At 64 spacings a period the spacing
  // hardly changes within the range of 2, so that the expectation is 1 but for a few per cent.
  DifferenceParameters parameters;
  parameters.cells = 32;
  parameters.range = 2;
  constexpr std::size_t n = 4096;
  DifferenceMap map = make_difference_map(parameters);
  constexpr int sets = 4;
  for (std::uint64_t s = 0; s < sets; ++s) {
    PlanarSamples set = random_samples(n, 400 + s);
    std::vector<double> phi;
    for (double& x : set.x) {
      double low = 0, high = 1;
      for (int step = 0; step < 50; ++step) {
        const double t = 0.5 * (low + high);
        (t + 0.8 * (1 - std::cos(2 * pi * t)) / (2 * pi) < x ? low : high) = t;
      }
      x = low;
      phi.push_back(1 + 0.8 * std::sin(2 * pi * x));
    }
    add_density_differences(map, set.x, set.y, spacing_from_density(phi, 1, 1), {1, 1});
  }
  const std::vector<double> ratio = normalized_differences(map, expected_differences(parameters, n));
  const RadialProfile profile = radial_differences(map, ratio, 2);
  for (std::size_t k = 0; k < profile.rings(); ++k) {
    const double area = 2 * pi * profile.radius[k] * 2 * map.cell() * map.cell();
    CHECK(profile.mean[k] == Approx(1).margin(0.04 + 4 / std::sqrt(sets * n / 2.0 * area)));
  }
}

TEST_CASE("add_anisotropic_differences: a stretched set equals the set it came from") {
  // p = S u, so J^-1 = S^-1 / spacing brings the differences of u back.
  const PlanarSamples set = random_samples(400, 15);
  const double s[4] = {3, 1, -0.5, 0.4};
  const double determinant = s[0] * s[3] - s[1] * s[2];
  PlanarSamples stretched;
  std::vector<double> inverse;
  for (std::size_t i = 0; i < 400; ++i) {
    stretched.x.push_back(s[0] * set.x[i] + s[1] * set.y[i]);
    stretched.y.push_back(s[2] * set.x[i] + s[3] * set.y[i]);
    for (const double value : {s[3], -s[1], -s[2], s[0]}) inverse.push_back(20 * value / determinant);
  }
  DifferenceMap a = make_difference_map(), b = a;
  add_differences(a, set.x, set.y, 0.05);
  add_anisotropic_differences(b, stretched.x, stretched.y, inverse);
  CHECK(total(a.sum) > 1000);
  CHECK(largest_difference(a, b) < 1e-9);
}

TEST_CASE("geodesic_length: exact on spheres, planes, and in its limit") {
  const std::vector<double> points = random_sphere(400, 2);
  const auto at = [&](std::size_t i) { return Vector3{points[3 * i], points[3 * i + 1], points[3 * i + 2]}; };
  const Vector3 center{1, 2, 3};
  for (std::size_t i = 0; i + 1 < 400; ++i) {
    const Vector3 n = at(i), m = at(i + 1);
    const double angle = std::atan2(norm(cross(n, m)), dot(n, m));
    const double length = geodesic_length(center + 5.0 * n, n, center + 5.0 * m, m);
    if (angle < 3) {
      CHECK(length == Approx(5 * angle).epsilon(1e-12));
      CHECK(geodesic_length(center + 5.0 * m, m, center + 5.0 * n, n) == Approx(length).epsilon(1e-14));
    }
    // Nearby: no cancellation.
    const Vector3 near = (1 / norm(n + 1e-6 * m)) * (n + 1e-6 * m);
    CHECK(geodesic_length(n, n, near, near) == Approx(distance(n, near)).epsilon(1e-12));
  }
  CHECK(geodesic_length({0, 0, 0}, {0, 0, 1}, {3, 4, 0}, {0, 0, 1}) == 5);
  // A circular cylinder along its section is a circle too.
  CHECK(geodesic_length({1, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 1, 0}) == Approx(pi / 2));
  // Equal cosines c: d / sqrt(1 - c^2).
  const double c = 0.6;
  CHECK(geodesic_length({2, 0, 0}, {c, 0.8, 0}, {0, 0, 0}, {c, 0, 0.8}) == Approx(2 / 0.8));
  CHECK(geodesic_length({1, 1, 1}, {1, 0, 0}, {1, 1, 1}, {0, 1, 0}) == 0);
  CHECK(geodesic_length({1, 0, 0}, {1, 0, 0}, {0, 0, 0}, {1, 0, 0}) ==
        std::numeric_limits<double>::infinity());
  // Against the formula as it is written.
  for (const double c1 : {-0.9, -0.2, 0.0, 0.5})
    for (const double c2 : {-0.6, 0.3, 0.95}) {
      const Vector3 n{c1, std::sqrt(1 - c1 * c1), 0}, m{c2, 0, std::sqrt(1 - c2 * c2)};
      CHECK(geodesic_length({2, 0, 0}, n, {0, 0, 0}, m) ==
            Approx(2 * (std::asin(c1) - std::asin(c2)) / (c1 - c2)).epsilon(1e-13));
    }
}

TEST_CASE("add_surface_differences: a plane in space equals the plane") {
  const PlanarSamples set = random_samples(400, 18);
  // Axes (0.6, 0.8, 0) and (0, 0, 1); normal (0.8, -0.6, 0).
  std::vector<double> points, normals, frames;
  for (std::size_t i = 0; i < 400; ++i) {
    points.insert(points.end(), {0.6 * set.x[i], 0.8 * set.x[i], set.y[i]});
    normals.insert(normals.end(), {1.6, -1.2, 0});
    const double sign = i % 2 == 0 ? 7 : -1;  // any length, either sign
    frames.insert(frames.end(), {sign * 0.6, sign * 0.8, 0});
  }
  DifferenceMap plane = make_difference_map(), surface = plane, random = plane, again = plane, other = plane;
  add_differences(plane, set.x, set.y, 0.05);
  const std::vector<double> spacing(400, 0.05);
  add_surface_differences(surface, points, normals, spacing, frames);
  CHECK(largest_difference(plane, surface) < 1e-9);
  // Random frames keep the lengths: the same sums within the circle of the range, up to the kernel at its
  // rim.
  add_surface_differences(random, points, normals, spacing);
  add_surface_differences(again, points, normals, spacing);
  SurfaceDifferenceParameters seed;
  seed.seed = 2;
  add_surface_differences(other, points, normals, spacing, {}, seed);
  CHECK(largest_difference(random, again) == 0);
  CHECK(largest_difference(random, other) > 0.1);
  const auto within = [](const DifferenceMap& map, double radius) {
    double sum = 0;
    for (std::size_t c = 0; c < map.sum.size(); ++c) {
      const double x = static_cast<double>(c % 128) - 63.5, y = static_cast<double>(c / 128) - 63.5;
      if (std::sqrt(x * x + y * y) * map.cell() < radius) sum += map.sum[c];
    }
    return sum;
  };
  for (const double radius : {1.0, 2.0, 3.9})
    CHECK(within(random, radius) == Approx(within(plane, radius)).epsilon(0.02));
}

TEST_CASE("add_surface_differences: white noise on the sphere has the density of its geodesic circles") {
  DifferenceParameters parameters;
  parameters.cells = 32;
  constexpr std::size_t n = 1000;
  DifferenceMap map = make_difference_map(parameters), reference = map;
  const double spacing = std::sqrt(4 * pi / n);
  const std::vector<double> spacings(n, spacing);
  constexpr int sets = 10;
  for (std::uint64_t s = 0; s < sets; ++s) {
    const std::vector<double> points = random_sphere(n, 700 + s), others = random_sphere(n, 900 + s);
    SurfaceDifferenceParameters frames;
    frames.seed = s;
    add_surface_differences(map, points, points, spacings, {}, frames);
    add_surface_differences(reference, others, others, spacings, {}, frames);
  }
  const std::vector<double> flat = normalized_differences(map, expected_differences(parameters, n));
  const RadialProfile profile = radial_differences(map, flat, 2);
  for (std::size_t k = 0; k < profile.rings(); ++k) {
    const double r = profile.radius[k] * map.cell() * spacing;  // geodesic, on the unit sphere
    const double area = 2 * pi * profile.radius[k] * 2 * map.cell() * map.cell();
    CHECK(profile.mean[k] == Approx(std::sin(r) / r).margin(4.5 / std::sqrt(sets * n / 2.0 * area)));
  }
  // Against random sets of the same kind it is 1.
  const RadialProfile relative = radial_differences(map, normalized_differences(map, reference), 4);
  for (std::size_t k = 0; k < relative.rings(); ++k) {
    const double area = 2 * pi * relative.radius[k] * 4 * map.cell() * map.cell();
    CHECK(relative.mean[k] == Approx(1).margin(6.5 / std::sqrt(sets * n / 2.0 * area)));
  }
}

TEST_CASE("add_surface_differences: the other side of a thin plate does not count") {
  const PlanarSamples set = random_samples(300, 30);
  std::vector<double> one_side, one_normals, points, normals;
  for (std::size_t i = 0; i < 300; ++i)
    for (const double side : {1.0, -1.0}) {
      points.insert(points.end(), {set.x[i], set.y[i] + (side < 0 ? 0.013 : 0), 1e-4 * side});
      normals.insert(normals.end(), {0, 0, side});
      if (side < 0) continue;
      one_side.insert(one_side.end(), {set.x[i], set.y[i], 1e-4});
      one_normals.insert(one_normals.end(), {0, 0, 1});
    }
  DifferenceMap one = make_difference_map(), both = one, unfiltered = one;
  const std::vector<double> x_axes(1800, 1.0);  // (1, 1, 1) projects to the diagonal on both sides
  add_surface_differences(one, one_side, one_normals, std::vector<double>(300, 0.05),
                          std::span(x_axes).first(900));
  add_surface_differences(both, points, normals, std::vector<double>(600, 0.05), x_axes);
  CHECK(total(both.sum) == Approx(2 * total(one.sum)).epsilon(1e-9));
  SurfaceDifferenceParameters all;
  all.min_normal_cosine = -1;
  add_surface_differences(unfiltered, points, normals, std::vector<double>(600, 0.05), x_axes, all);
  CHECK(total(unfiltered.sum) > 3 * total(one.sum));
}

TEST_CASE("differences: one thread and many give the same bits") {
  const PlanarSamples set = random_samples(3000, 77);
  const std::vector<double> points = random_sphere(3000, 78), spacing(3000, 0.03);
  DifferenceMap many = make_difference_map(), one = many;
  const auto add = [&](DifferenceMap& map) {
    add_differences(map, set.x, set.y, 0.01);
    add_surface_differences(map, points, points, spacing);
  };
  add(many);
  oneapi::tbb::task_arena(1).execute([&] { add(one); });
  CHECK(many.sum == one.sum);
}

TEST_CASE("differences: few samples, and invalid arguments are refused") {
  DifferenceMap map = make_difference_map();
  add_differences(map, {}, {}, 1);
  const std::vector<double> one{0.5}, two{0.5, 0.6}, bad{std::nan(""), 0};
  add_differences(map, one, one, 1);
  CHECK(map.sets == 2);
  CHECK(total(map.sum) == 0);
  add_differences(map, two, two, 1);
  CHECK(total(map.sum) == Approx(2));
  CHECK_THROWS_AS(add_differences(map, one, two, 1), std::invalid_argument);
  CHECK_THROWS_AS(add_differences(map, two, bad, 1), std::invalid_argument);
  CHECK_THROWS_AS(add_differences(map, two, two, 0), std::invalid_argument);
  CHECK_THROWS_AS(add_differences(map, two, two, 0.1, {1, 0}), std::invalid_argument);  // reach 0.59
  CHECK_NOTHROW(add_differences(map, two, two, 0.08, {1, 0}));
  CHECK_THROWS_AS(add_density_differences(map, two, two, one), std::invalid_argument);
  CHECK_THROWS_AS(add_anisotropic_differences(map, two, two, two), std::invalid_argument);
  CHECK_THROWS_AS(add_anisotropic_differences(map, one, one, std::vector<double>{1, 2, 2, 4}),
                  std::invalid_argument);
  const std::vector<double> point{0, 0, 0}, zero{0, 0, 0}, up{0, 0, 1};
  CHECK_THROWS_AS(add_surface_differences(map, point, zero, one), std::invalid_argument);
  CHECK_THROWS_AS(add_surface_differences(map, point, up, two), std::invalid_argument);
  CHECK_THROWS_AS(add_surface_differences(map, two, two, one), std::invalid_argument);
  CHECK(map.sets == 4);
  DifferenceParameters parameters;
  parameters.range = 0;
  CHECK_THROWS_AS(make_difference_map(parameters), std::invalid_argument);
  parameters = {};
  parameters.cells = 1;
  CHECK_THROWS_AS(make_difference_map(parameters), std::invalid_argument);
  parameters = {};
  parameters.kernel = 65;
  CHECK_THROWS_AS(make_difference_map(parameters), std::invalid_argument);
  parameters.kernel = 2;
  CHECK_THROWS_AS(normalized_differences(map, expected_differences(parameters, 4)), std::invalid_argument);
  CHECK_THROWS_AS(normalized_differences(make_difference_map(), map), std::invalid_argument);
  CHECK_THROWS_AS(radial_differences(map, map.sum, 0.5), std::invalid_argument);
  CHECK_THROWS_AS(spacing_from_density(std::vector<double>{0.0}, 1, std::numeric_limits<double>::infinity()),
                  std::invalid_argument);
  CHECK(spacing_from_density(std::vector<double>{0.0}, 1, 0.5)[0] == 0.5);
  CHECK_THROWS_AS(spacing_from_density(std::vector<double>{-1.0}, 1, 1), std::invalid_argument);
}
