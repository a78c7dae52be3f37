#include "kernels/describe/shell_harmonics.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "kernels/core/random.h"
#include "kernels/core/rotation.h"
#include "support/catch.h"

using namespace meander;

namespace {

using std::numbers::pi;
constexpr std::size_t degrees = highest_harmonic_degree + 1;
const RandomKey harmonics_key = make_random_key(17, {});

Vector3 direction(std::uint64_t i) {
  const UnitPair u = random_pair(harmonics_key, Stream::point_set, i, 7);
  const double z = 2 * u.first - 1, s = std::sqrt(1 - z * z), turn = 2 * pi * u.second;
  return {s * std::cos(turn), s * std::sin(turn), z};
}

void add(std::vector<float>& points, Vector3 point) {
  for (const double value : {point.x, point.y, point.z}) points.push_back(static_cast<float>(value));
}

// A box of three different sides, denser towards one corner.
std::vector<float> surface_of_box(std::size_t n) {
  std::vector<float> points;
  for (std::size_t i = 0; i < n; ++i) {
    const UnitPair a = random_pair(harmonics_key, Stream::point_set, i, 0),
                   b = random_pair(harmonics_key, Stream::point_set, i, 1);
    add(points, {a.first * a.first, 0.7 * a.second * a.first, 0.4 * b.first});
  }
  return points;
}

std::vector<float> changed(const std::vector<float>& points, const Rotation& turn, double scale,
                           Vector3 shift) {
  std::vector<float> result;
  for (std::size_t i = 0; i < points.size(); i += 3)
    add(result, scale * rotated(turn, {points[i], points[i + 1], points[i + 2]}) + shift);
  return result;
}

double largest_difference(const std::vector<float>& a, const std::vector<float>& b) {
  REQUIRE(a.size() == b.size());
  double largest = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    largest = std::max(largest, std::abs(double{a[i]} - double{b[i]}));
  return largest;
}

double value(const std::vector<float>& values, std::size_t shell, std::size_t degree) {
  return values.at((shell - 1) * degrees + degree);
}

double legendre(std::uint32_t degree, double t) {
  double before = 0, here = 1;
  for (std::uint32_t l = 0; l < degree; ++l) {
    const double next = ((2.0 * l + 1) * t * here - l * before) / (l + 1.0);
    before = here;
    here = next;
  }
  return here;
}

// The addition theorem over all pairs of points, without any harmonic.
std::vector<float> slow_version(const std::vector<float>& points) {
  const std::size_t n = points.size() / 3;
  std::vector<Vector3> arms;
  Vector3 centroid;
  for (std::size_t i = 0; i < n; ++i) {
    arms.push_back({points[3 * i], points[3 * i + 1], points[3 * i + 2]});
    centroid = centroid + (1 / static_cast<double>(n)) * arms.back();
  }
  double mean = 0;
  for (Vector3& arm : arms) mean += norm(arm = arm - centroid) / static_cast<double>(n);
  std::vector<float> values;
  for (std::uint32_t shell = 1; shell <= harmonic_shells; ++shell) {
    std::vector<double> weights;
    for (const Vector3& arm : arms) {
      const double place =
          std::min<double>(norm(arm) / mean / harmonic_range * harmonic_shells, harmonic_shells);
      weights.push_back(std::max(0.0, 1 - std::abs(place - shell)));
    }
    for (std::uint32_t l = 0; l < degrees; ++l) {
      double sum = 0;
      for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = 0; j < n; ++j) {
          if (weights[i] == 0 || weights[j] == 0) continue;
          const double cosine = dot(arms[i], arms[j]) / (norm(arms[i]) * norm(arms[j]));
          sum += weights[i] * weights[j] * legendre(l, cosine);
        }
      values.push_back(
          static_cast<float>(std::sqrt(std::max(0.0, (2.0 * l + 1) * sum)) / static_cast<double>(n)));
    }
  }
  return values;
}

}  // namespace

TEST_CASE("spherical harmonics: degrees 0 to 2 equal their polynomials") {
  for (std::uint64_t i = 0; i < 20; ++i) {
    const Vector3 d = direction(i);
    const std::vector<double> values = spherical_harmonics(d, 2);
    const double one = std::sqrt(3 / (4 * pi)), two = std::sqrt(15 / (4 * pi));
    const double expected[9] = {std::sqrt(1 / (4 * pi)),
                                one * d.y,
                                one * d.z,
                                one * d.x,
                                two * d.x * d.y,
                                two * d.y * d.z,
                                std::sqrt(5 / (16 * pi)) * (3 * d.z * d.z - 1),
                                two * d.x * d.z,
                                two / 2 * (d.x * d.x - d.y * d.y)};
    REQUIRE(values.size() == 9);
    for (std::size_t k = 0; k < 9; ++k) CHECK(values[k] == Approx(expected[k]).margin(1e-14));
  }
}

TEST_CASE("spherical harmonics: the addition theorem for two directions, including the poles and degree 60") {
  std::vector<Vector3> directions = {{0, 0, 1}, {0, 0, -1}, {1, 0, 0}, {0, -1, 0}};
  for (std::uint64_t i = 0; i < 12; ++i) directions.push_back(direction(i));
  constexpr std::uint32_t highest = 60;
  std::vector<std::vector<double>> values;
  for (const Vector3& d : directions) values.push_back(spherical_harmonics(d, highest));
  for (std::size_t a = 0; a < directions.size(); ++a)
    for (std::size_t b = 0; b <= a; ++b)
      for (std::uint32_t l = 0; l <= highest; ++l) {
        double sum = 0;
        for (std::size_t k = std::size_t{l} * l; k < (l + std::size_t{1}) * (l + 1); ++k)
          sum += values[a][k] * values[b][k];
        const double expected = (2 * l + 1) / (4 * pi) * legendre(l, dot(directions[a], directions[b]));
        if (std::abs(sum - expected) > 1e-10 * (2 * l + 1)) {
          INFO("directions " << a << ", " << b << ", degree " << l);
          CHECK(sum == Approx(expected));
        }
      }
  CHECK(values.size() == 16);
}

TEST_CASE("shell harmonics: two opposite points have even degrees only") {
  // At the mean distance: 8 / 2.5 = 3.2 steps, so .8 of the mass is on shell 3 and .2 on shell 4.
  const std::vector<float> values = shell_harmonics(std::vector<float>{3, 4, 5, 1, 0, 1});
  for (std::size_t shell = 1; shell <= harmonic_shells; ++shell)
    for (std::size_t l = 0; l < degrees; ++l) {
      const double mass = shell == 3 ? 0.8 : shell == 4 ? 0.2 : 0;
      const double expected = l % 2 == 1 ? 0 : mass * std::sqrt(2 * static_cast<double>(l) + 1);
      CHECK(value(values, shell, l) == Approx(expected).margin(1e-6));
    }
}

TEST_CASE("shell harmonics: agree with sums of Legendre polynomials over all pairs") {
  CHECK(largest_difference(shell_harmonics(surface_of_box(150)), slow_version(surface_of_box(150))) < 1e-5);
  CHECK(largest_difference(shell_harmonics(surface_of_box(3)), slow_version(surface_of_box(3))) < 1e-5);
}

TEST_CASE("shell harmonics: a uniform sphere has degree 0, the rest is noise of its points") {
  constexpr std::size_t n = 4000;
  std::vector<float> points;
  for (std::size_t i = 0; i < n; ++i) add(points, 3 * direction(i) + Vector3{1, 2, 3});
  const std::vector<float> values = shell_harmonics(points);
  CHECK(value(values, 3, 0) == Approx(0.8).margin(0.03));
  CHECK(value(values, 4, 0) == Approx(0.2).margin(0.03));
  for (std::size_t shell = 1; shell <= harmonic_shells; ++shell)
    for (std::size_t l = 1; l < degrees; ++l)
      CHECK(value(values, shell, l) < 4 * std::sqrt((2 * static_cast<double>(l) + 1) / n));
}

TEST_CASE("shell harmonics: invariant to motion, size, reflection and order") {
  const std::vector<float> points = surface_of_box(800), reference = shell_harmonics(points);
  REQUIRE(reference.size() == shell_harmonic_values);
  const Rotation none = rotation_of(0, 0, 0, 1), turn = random_rotation(harmonics_key, Stream::point_set);
  CHECK(largest_difference(shell_harmonics(changed(points, turn, 1, {})), reference) < 1e-5);
  CHECK(largest_difference(shell_harmonics(changed(points, none, 1e-9, {})), reference) < 1e-5);
  CHECK(largest_difference(shell_harmonics(changed(points, turn, 7e20, {1e20, -2e20, 0})), reference) < 1e-5);
  CHECK(largest_difference(shell_harmonics(changed(points, none, -1, {1, -2, 3})), reference) < 1e-5);
  std::vector<float> backwards;
  for (std::size_t i = points.size(); i > 0; i -= 3)
    backwards.insert(backwards.end(), {points[i - 3], points[i - 2], points[i - 1]});
  CHECK(largest_difference(shell_harmonics(backwards), reference) < 1e-6);
  // Other points have other values.
  std::vector<float> flat = points;
  for (std::size_t i = 2; i < flat.size(); i += 3) flat[i] *= 0.1f;
  CHECK(largest_difference(shell_harmonics(flat), reference) > 0.05);
}

TEST_CASE("shell harmonics: continuous where a point crosses a shell") {
  // Six points fix centroid and nearly the mean; two opposite ones cross shell 4 (at 1.25 x the mean).
  const auto with = [](double radius) {
    std::vector<float> points;
    for (const double side : {-1.0, 1.0}) {
      add(points, {side, 0, 0});
      add(points, {0, side, 0});
      add(points, {0, 0, side * radius});
    }
    return shell_harmonics(points);
  };
  // The mean is (4 + 2 r) / 6, so the crossing is at r = 1.25 (2 + r) / 3: 10 / 7.
  const double crossing = 10.0 / 7, step = 1e-4;
  const double across = largest_difference(with(crossing - step), with(crossing + step));
  CHECK(across > 0);
  CHECK(across < 40 * step);
}

TEST_CASE("shell harmonics: degenerate points work, invalid arguments are refused") {
  for (const float place : {0.0f, 0.1f, -3e38f}) {
    const std::vector<float> spot(3 * 7, place), one(3, place);
    for (const auto& points : {spot, one}) {
      const std::vector<float> values = shell_harmonics(points);
      REQUIRE(values.size() == shell_harmonic_values);
      CHECK(values[0] == 1);
      CHECK(std::all_of(values.begin() + 1, values.end(), [](float v) { return v == 0; }));
    }
  }
  std::vector<float> line, plane, tiny, far;
  for (int i = 0; i < 50; ++i) {
    const auto x = static_cast<float>(i);
    line.insert(line.end(), {x, 2 * x, 0});
    plane.insert(plane.end(), {x, static_cast<float>(i % 7), 4});
    tiny.insert(tiny.end(), {x * std::numeric_limits<float>::denorm_min(), 0, 0});
  }
  far.assign(3 * 50, 1.0f);
  far.back() = 3e38f;
  for (const auto& points : {line, plane, tiny, far}) {
    const std::vector<float> values = shell_harmonics(points);
    double mass = 0;
    for (std::size_t shell = 1; shell <= harmonic_shells; ++shell) mass += value(values, shell, 0);
    CHECK(mass > 0);
    CHECK(mass < 1 + 1e-6);
    for (std::size_t i = 0; i < values.size(); ++i)
      CHECK(values[i] <=
            1.00001 * std::sqrt(2 * static_cast<double>(i % degrees) + 1) * values[i - i % degrees]);
  }
  CHECK_THROWS_AS(shell_harmonics({}), std::invalid_argument);
  CHECK_THROWS_AS(shell_harmonics(std::vector<float>(4)), std::invalid_argument);
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()})
    CHECK_THROWS_AS(shell_harmonics(std::vector<float>{0, 1, bad}), std::invalid_argument);
}
