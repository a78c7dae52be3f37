#include "kernels/analyse/spacing.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "kernels/analyse/kd_tree.h"
#include "kernels/core/random.h"
#include "support/catch.h"
#include "support/test_meshes.h"

using namespace meander;

namespace {

std::vector<double> random_numbers(std::size_t count, std::uint64_t seed) {
  const RandomKey key = make_random_key(seed, {});
  std::vector<double> numbers(count);
  for (std::size_t i = 0; i < count; ++i) numbers[i] = random_pair(key, Stream::sequence, i).first;
  return numbers;
}

double largest(const std::vector<double>& distances) {
  return *std::max_element(distances.begin(), distances.end());
}

double around(double d, double period) { return period > 0 ? d - period * std::round(d / period) : d; }

}  // namespace

TEST_CASE("nearest_distances: the plane matches all pairs, bit for bit") {
  for (const std::size_t n : {std::size_t{2}, std::size_t{9}, std::size_t{700}}) {
    std::vector<double> x = random_numbers(n, n), y = random_numbers(n, n + 1);
    for (std::size_t i = 0; i < n / 3; ++i) y[i] = 0.5;  // many on a line
    for (std::size_t i = 0; i + 1 < n / 20; i += 2) x[i + 1] = x[i];
    const auto found = nearest_distances(x, y);
    for (std::size_t i = 0; i < n; ++i) {
      double best = std::numeric_limits<double>::infinity();
      for (std::size_t j = 0; j < n; ++j)
        if (j != i) best = std::min(best, (x[i] - x[j]) * (x[i] - x[j]) + (y[i] - y[j]) * (y[i] - y[j]));
      REQUIRE(found[i] == std::sqrt(best));
    }
  }
}

TEST_CASE("nearest_distances: space matches all pairs, bit for bit") {
  const std::size_t n = 600;
  std::vector<double> points = random_numbers(3 * n, 4);
  for (std::size_t i = 0; i < n; ++i) points[3 * i] *= 1e-3;  // flat
  const auto found = nearest_distances(points);
  const auto squared = [&](const std::vector<double>& a, std::size_t i, std::size_t j) {
    double sum = 0;
    for (std::size_t k = 0; k < 3; ++k)
      sum += (a[3 * i + k] - points[3 * j + k]) * (a[3 * i + k] - points[3 * j + k]);
    return sum;
  };
  for (std::size_t i = 0; i < n; ++i) {
    double best = std::numeric_limits<double>::infinity();
    for (std::size_t j = 0; j < n; ++j)
      if (j != i) best = std::min(best, squared(points, i, j));
    REQUIRE(found[i] == std::sqrt(best));
  }
  const std::vector<double> reference = random_numbers(3 * 200, 8);
  const auto to_samples = distances_to_samples(points, reference);
  for (std::size_t i = 0; i < 200; ++i) {
    double best = std::numeric_limits<double>::infinity();
    for (std::size_t j = 0; j < n; ++j) best = std::min(best, squared(reference, i, j));
    REQUIRE(to_samples[i] == std::sqrt(best));
  }
}

TEST_CASE("nearest_distances: the torus matches all pairs") {
  for (const auto& [px, py] : {std::pair{1.0, 1.0}, std::pair{1.0, 0.0}, std::pair{0.0, 0.4}}) {
    const std::size_t n = 60;
    std::vector<double> x = random_numbers(n, 21), y = random_numbers(n, 22);
    x[3] += 5;  // other images of the same points
    y[4] -= 3;
    const auto found = nearest_distances(x, y, px, py);
    const auto to = distances_to_samples(x, y, y, x, px, py);
    for (std::size_t i = 0; i < n; ++i) {
      double best = std::numeric_limits<double>::infinity(), best_to = best;
      for (std::size_t j = 0; j < n; ++j) {
        if (j != i) best = std::min(best, std::hypot(around(x[i] - x[j], px), around(y[i] - y[j], py)));
        best_to = std::min(best_to, std::hypot(around(y[i] - x[j], px), around(x[i] - y[j], py)));
      }
      CHECK(found[i] == Approx(best).margin(1e-14));
      CHECK(to[i] == Approx(best_to).margin(1e-14));
    }
  }
}

TEST_CASE("spacing: closed forms of lattices on the torus") {
  // Square lattice: rho = sqrt(sqrt(3) / 2) = 0.9306, coverage radius half the diagonal of a cell.
  constexpr int m = 20;
  std::vector<double> x, y, fine_x, fine_y;
  for (int i = 0; i < m * m; ++i) {
    x.push_back((i % m + 0.25) / m);
    y.push_back((i / m + 0.75) / m);
  }
  for (int i = 0; i < 16 * m * m; ++i) {
    fine_x.push_back((i % (4 * m)) / (4.0 * m));
    fine_y.push_back(i / (4 * m) / (4.0 * m));
  }
  const Spacing square = spacing_of(nearest_distances(x, y, 1, 1), 1);
  CHECK(square.min == Approx(1.0 / m));
  CHECK(square.mean == Approx(1.0 / m));
  CHECK(square.rho == Approx(std::sqrt(std::sqrt(3.0) / 2)));
  CHECK(largest(distances_to_samples(x, y, fine_x, fine_y, 1, 1)) == Approx(std::sqrt(0.5) / m));

  // Hexagonal lattice with distance 1 / 20 on a torus 1 x 12 sqrt(3) / 20: rho = 1.
  x.clear();
  y.clear();
  const double height = 24 * std::sqrt(0.75) / m;
  for (int j = 0; j < 24; ++j)
    for (int i = 0; i < m; ++i) {
      x.push_back((i + 0.5 * (j % 2)) / m);
      y.push_back(j * std::sqrt(0.75) / m);
    }
  const Spacing hexagonal = spacing_of(nearest_distances(x, y, 1, height), height);
  CHECK(hexagonal.rho == Approx(1).epsilon(1e-12));
  // Its deep holes, the centers of the triangles.
  const std::vector<double> hole_x{0.5 / m}, hole_y{std::sqrt(1.0 / 12) / m};
  CHECK(largest(distances_to_samples(x, y, hole_x, hole_y, 1, height)) == Approx(1 / std::sqrt(3.0) / m));
}

TEST_CASE("spacing: random points in the plane have mean distance half the spacing") {
  // E = 1 / (2 sqrt(density)), standard deviation sqrt((4 - pi) / (4 pi)) = 0.2614 of sqrt(1 / density).
  constexpr std::size_t n = 20000;
  const auto distances = nearest_distances(random_numbers(n, 31), random_numbers(n, 32), 1, 1);
  const Spacing spacing = spacing_of(distances, 1);
  CHECK(spacing.mean * std::sqrt(static_cast<double>(n)) ==
        Approx(0.5).margin(5 * 0.2614 / std::sqrt(static_cast<double>(n))));
  CHECK(spacing.rho < 0.1);
}

TEST_CASE("spacing: the vertices of an icosahedron") {
  const PolygonMesh mesh = test::icosphere(0);
  std::vector<double> points;
  for (std::size_t i = 0; i < mesh.x.size(); ++i)
    points.insert(points.end(), {mesh.x[i], mesh.y[i], mesh.z[i]});
  const double edge = 1 / std::sin(2 * std::numbers::pi / 5);
  const Spacing spacing = spacing_of(nearest_distances(points), 4 * std::numbers::pi);
  CHECK(spacing.min == Approx(edge));
  CHECK(spacing.rho == Approx(edge / std::sqrt(8 * std::numbers::pi / (std::sqrt(3.0) * 12))));
}

TEST_CASE("spacing: invariant to motion and order, and scales with the unit") {
  const std::size_t n = 300;
  const std::vector<double> x = random_numbers(n, 41), y = random_numbers(n, 42);
  const auto plain = nearest_distances(x, y);
  std::vector<double> turned_x(n), turned_y(n);
  for (std::size_t i = 0; i < n; ++i) {  // the 3-4-5 rotation, scaled by 1000, in reverse order
    turned_x[n - 1 - i] = 1000 * (0.6 * x[i] - 0.8 * y[i]) + 7;
    turned_y[n - 1 - i] = 1000 * (0.8 * x[i] + 0.6 * y[i]) - 3;
  }
  const auto turned = nearest_distances(turned_x, turned_y);
  for (std::size_t i = 0; i < n; ++i) CHECK(turned[n - 1 - i] == Approx(1000 * plain[i]).margin(1e-9));
  CHECK(spacing_of(turned, 1e6).rho == Approx(spacing_of(plain, 1).rho).epsilon(1e-9));
}

TEST_CASE("KdTree: balls contain the right points, borders included") {
  const std::vector<double> points = random_numbers(2 * 500, 51);
  const KdTree<2> tree(points);
  for (const double radius : {0.0, 0.03, 0.2, 2.0})
    for (std::size_t q = 0; q < 20; ++q) {
      const std::array<double, 2> query{points[2 * q], points[2 * q + 1]};
      std::vector<std::uint32_t> found, expected;
      tree.in_ball(query, radius * radius, [&](std::uint32_t i, const auto&) { found.push_back(i); });
      for (std::uint32_t i = 0; i < 500; ++i) {
        const double dx = query[0] - points[2 * i], dy = query[1] - points[2 * i + 1];
        if (dx * dx + dy * dy <= radius * radius) expected.push_back(i);
      }
      std::sort(found.begin(), found.end());
      CHECK(found == expected);
    }
}

TEST_CASE("spacing: repeated points are counted, and invalid arguments refused") {
  const std::vector<double> three{0, 0, 1}, same{2, 2, 2}, none, one{1};
  CHECK(nearest_distances(three, same) == std::vector<double>{0, 0, 1});
  const std::vector<double> equal(200, 0.25);
  CHECK(spacing_of(nearest_distances(equal, equal), 1).mean == 0);
  CHECK_THROWS_AS(nearest_distances(one, one), std::invalid_argument);
  CHECK_THROWS_AS(nearest_distances(three, one), std::invalid_argument);
  CHECK_THROWS_AS(nearest_distances(std::vector<double>{1, 2, 3, 4}), std::invalid_argument);
  CHECK_THROWS_AS(nearest_distances(three, same, -1, 0), std::invalid_argument);
  CHECK_THROWS_AS(nearest_distances(std::vector<double>{0, 0, std::nan("")}, same), std::invalid_argument);
  CHECK_THROWS_AS(distances_to_samples(none, none, one, one), std::invalid_argument);
  CHECK(distances_to_samples(one, one, none, none).empty());
  CHECK_THROWS_AS(hexagonal_spacing(0, 3), std::invalid_argument);
  CHECK_THROWS_AS(hexagonal_spacing(1, 0), std::invalid_argument);
  CHECK_THROWS_AS(spacing_of(none, 1), std::invalid_argument);
}
