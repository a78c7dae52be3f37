#include "kernels/describe/shape_functions.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <stdexcept>

#include "kernels/core/vector3.h"
#include "support/catch.h"
#include "support/threads.h"

using namespace meander;

namespace {

const RandomKey functions_key = make_random_key(11, {});

std::vector<float> random_points(std::size_t n, double height = 0.5) {
  std::vector<float> points;
  for (std::size_t i = 0; i < n; ++i) {
    const UnitPair a = random_pair(functions_key, Stream::point_set, i, 0),
                   b = random_pair(functions_key, Stream::point_set, i, 1);
    points.push_back(static_cast<float>(a.first));
    points.push_back(static_cast<float>(2 * a.second));
    points.push_back(static_cast<float>(height * b.first));
  }
  return points;
}

Vector3 at(const std::vector<float>& points, std::size_t i) {
  return {points[3 * i], points[3 * i + 1], points[3 * i + 2]};
}

double angle_at(Vector3 a, Vector3 b, Vector3 c) {
  return std::acos(std::clamp(dot(b - a, c - a) / (norm(b - a) * norm(c - a)), -1.0, 1.0));
}

// Values of all tuples of different points.
std::vector<double> all_values(const std::vector<float>& p, ShapeFunction function) {
  const std::size_t n = p.size() / 3;
  std::vector<double> values;
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = i + 1; j < n; ++j)
      for (std::size_t k = j + 1; k < n; ++k) {
        const Vector3 a = at(p, i), b = at(p, j), c = at(p, k);
        if (function == ShapeFunction::angle) {
          values.insert(values.end(), {angle_at(a, b, c), angle_at(b, c, a), angle_at(c, a, b)});
        } else if (function == ShapeFunction::triangle) {
          values.push_back(std::sqrt(triangle_area(a, b, c)));
        } else {
          for (std::size_t l = k + 1; l < n; ++l)
            values.push_back(std::cbrt(std::abs(dot(b - a, cross(c - a, at(p, l) - a))) / 6));
        }
      }
  return values;
}

// Largest difference of the cumulative shares from those of the values: edges that move a little between
// values matter little to it.
double cumulative_error(const ShapeHistogram& histogram, std::vector<double> values) {
  std::sort(values.begin(), values.end());
  double sum = 0, error = 0;
  const std::size_t bins = histogram.shares.size();
  for (std::size_t b = 0; b + 1 < bins; ++b) {
    sum += histogram.shares[b];
    const double edge = histogram.range * static_cast<double>(b + 1) / static_cast<double>(bins);
    const auto below = std::lower_bound(values.begin(), values.end(), edge) - values.begin();
    error = std::max(error, std::abs(sum - static_cast<double>(below) / static_cast<double>(values.size())));
  }
  return error;
}

double mean_of(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

}  // namespace

TEST_CASE("shape functions: those of random tuples converge to those of all tuples") {
  const std::vector<float> points = random_points(30);
  for (const ShapeFunction function :
       {ShapeFunction::angle, ShapeFunction::triangle, ShapeFunction::tetrahedron}) {
    INFO(name_of(function));
    const std::vector<double> values = all_values(points, function);
    const ShapeHistogram histogram = shape_function_histogram(points, function, functions_key);
    // The Kolmogorov distance of 2^17 draws exceeds 0.0054 once in 1000 times.
    CHECK(cumulative_error(histogram, values) < 0.0054);
    CHECK(histogram.scale == Approx(mean_of(values)).epsilon(0.006));
    CHECK(mean_of(histogram.shares) * 32 == Approx(1));
  }
}

TEST_CASE("tuples: reach every point and never the same one twice") {
  // Corners of a regular tetrahedron: every angle is pi / 3, every area and volume the same.
  const std::vector<float> corners = {1, 1, 1, 1, -1, -1, -1, 1, -1, -1, -1, 1};
  const ShapeFunctionParameters parameters{.bins = 32, .tuples = 1 << 12};
  const auto mean = [&](ShapeFunction function) {
    return shape_function_histogram(corners, function, functions_key, parameters).scale;
  };
  CHECK(mean(ShapeFunction::angle) == Approx(std::numbers::pi / 3).epsilon(1e-12));
  CHECK(mean(ShapeFunction::triangle) == Approx(std::sqrt(2 * std::sqrt(3.0))).epsilon(1e-12));
  CHECK(mean(ShapeFunction::tetrahedron) == Approx(std::cbrt(8.0 / 3)).epsilon(1e-12));
  CHECK(mean(ShapeFunction::centroid) == Approx(std::sqrt(3.0)).epsilon(1e-12));
}

TEST_CASE("shape functions: distances to the centroid are over all points") {
  const std::vector<float> points = random_points(500);
  Vector3 centroid;
  for (std::size_t i = 0; i < 500; ++i) centroid = centroid + (1.0 / 500) * at(points, i);
  std::vector<double> values;
  for (std::size_t i = 0; i < 500; ++i) values.push_back(distance(at(points, i), centroid));
  const ShapeHistogram histogram = shape_function_histogram(points, ShapeFunction::centroid, functions_key);
  CHECK(histogram.scale == Approx(mean_of(values)));
  CHECK(histogram.range == Approx(3 * mean_of(values)));
  CHECK(cumulative_error(histogram, values) < 1e-9);
}

TEST_CASE("shape functions: invariant to position, size, rotation and threads") {
  const std::vector<float> points = random_points(2048);
  std::vector<float> moved;
  for (std::size_t i = 0; i < 2048; ++i) {  // turned by 3-4-5
    const double x = points[3 * i], y = points[3 * i + 1], z = points[3 * i + 2];
    moved.insert(moved.end(), {static_cast<float>(8 * (0.6 * x - 0.8 * y) + 3),
                               static_cast<float>(8 * (0.8 * x + 0.6 * y) - 5), static_cast<float>(8 * z)});
  }
  for (const ShapeFunction function :
       {ShapeFunction::angle, ShapeFunction::centroid, ShapeFunction::triangle, ShapeFunction::tetrahedron}) {
    INFO(name_of(function));
    const ShapeHistogram reference = shape_function_histogram(points, function, functions_key);
    const ShapeHistogram other = shape_function_histogram(moved, function, functions_key);
    CHECK(other.scale / reference.scale == Approx(function == ShapeFunction::angle ? 1 : 8).epsilon(1e-5));
    for (std::size_t b = 0; b < 32; ++b) CHECK(other.shares[b] == Approx(reference.shares[b]).margin(1e-3));
    for (const std::size_t threads : {1u, 4u}) {
      const ShapeHistogram again = test::on_threads(
          threads, [&] { return shape_function_histogram(points, function, functions_key); });
      CHECK(again.shares == reference.shares);
    }
  }
}

TEST_CASE("shape functions: flat sets and single points work, invalid arguments are refused") {
  const std::vector<float> flat = random_points(100, 0);
  const ShapeHistogram volumes = shape_function_histogram(flat, ShapeFunction::tetrahedron, functions_key);
  CHECK(volumes.scale == 0);
  CHECK(volumes.shares[0] == 1);
  CHECK(shape_function_histogram(flat, ShapeFunction::angle, functions_key).scale ==
        Approx(std::numbers::pi / 3).epsilon(0.01));  // the angles of a triangle sum to pi
  const std::vector<float> spot(15, 2.0f);
  for (const ShapeFunction function :
       {ShapeFunction::angle, ShapeFunction::centroid, ShapeFunction::triangle})
    CHECK(shape_function_histogram(spot, function, functions_key).shares[0] == 1);
  const auto of = [&](std::size_t n, const ShapeFunctionParameters& parameters) {
    return shape_function_histogram(random_points(n), ShapeFunction::triangle, functions_key, parameters);
  };
  CHECK_THROWS_AS(of(3, {}), std::invalid_argument);
  CHECK_THROWS_AS(of(9, {.bins = 7}), std::invalid_argument);
  CHECK_THROWS_AS(of(9, {.tuples = 0}), std::invalid_argument);
  std::vector<float> broken = random_points(9);
  broken[4] = std::nanf("");
  CHECK_THROWS_AS(shape_function_histogram(broken, ShapeFunction::angle, functions_key),
                  std::invalid_argument);
}
