#include "kernels/analyse/discrepancy_plane.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <vector>

#include "kernels/core/random.h"

namespace meander {

namespace {

using Point = std::array<double, 2>;
using Corners = std::vector<Point>;

void check_points(const PointIndex<2>& points) {
  if (points.count() == 0) throw std::invalid_argument("a discrepancy needs points");
}

std::array<double, 6> random_numbers(const ShapeParameters& parameters, std::uint32_t number) {
  const RandomKey key = make_random_key(parameters.seed, {});
  std::array<double, 6> u;
  for (std::uint32_t i = 0; i < 3; ++i) {
    const UnitPair pair = random_pair(key, Stream::test_shapes, number, i);
    u[2 * i] = pair.first;
    u[2 * i + 1] = pair.second;
  }
  return u;
}

double error_of(const PointIndex<2>& points, std::span<const HalfSpace<2>> shape, double share) {
  return std::abs(static_cast<double>(count_inside(points, shape)) / static_cast<double>(points.count()) -
                  share);
}

// The half-plane to the left of the edge from a to b.
HalfSpace<2> left_of(Point a, Point b) {
  const double dx = b[0] - a[0], dy = b[1] - a[1], length = std::hypot(dx, dy);
  const Point normal = {dy / length, -dx / length};
  return {normal, normal[0] * a[0] + normal[1] * a[1]};
}

// Area of a convex polygon inside the unit square, by clipping (Sutherland and Hodgman 1974).
double area_in_square(Corners corners) {
  for (std::size_t axis = 0; axis < 2; ++axis)
    for (const double side : {0.0, 1.0}) {
      const double sign = side > 0 ? -1 : 1;
      Corners kept;
      for (std::size_t i = 0; i < corners.size(); ++i) {
        const Point& from = corners[i];
        const Point& to = corners[i + 1 == corners.size() ? 0 : i + 1];
        const double d0 = sign * (from[axis] - side), d1 = sign * (to[axis] - side);
        if (d0 >= 0) kept.push_back(from);
        if ((d0 > 0 && d1 < 0) || (d0 < 0 && d1 > 0)) {
          const double t = d0 / (d0 - d1);
          kept.push_back({from[0] + t * (to[0] - from[0]), from[1] + t * (to[1] - from[1])});
        }
      }
      corners = std::move(kept);
    }
  double doubled = 0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Point& a = corners[i];
    const Point& b = corners[i + 1 == corners.size() ? 0 : i + 1];
    doubled += a[0] * b[1] - b[0] * a[1];
  }
  return 0.5 * std::abs(doubled);
}

// Rectangle with half-sides `half` along a unit vector and its left normal.
double rectangle_error(const PointIndex<2>& points, Point center, Point along, Point half) {
  const Point across = {-along[1], along[0]};
  Corners corners;
  for (const auto& [s, t] : {Point{-1, -1}, Point{1, -1}, Point{1, 1}, Point{-1, 1}})
    corners.push_back({center[0] + s * half[0] * along[0] + t * half[1] * across[0],
                       center[1] + s * half[0] * along[1] + t * half[1] * across[1]});
  const double u = along[0] * center[0] + along[1] * center[1];
  const double v = across[0] * center[0] + across[1] * center[1];
  const std::array<HalfSpace<2>, 4> sides = {{{along, half[0] + u},
                                              {{-along[0], -along[1]}, half[0] - u},
                                              {across, half[1] + v},
                                              {{-across[0], -across[1]}, half[1] - v}}};
  return error_of(points, sides, area_in_square(std::move(corners)));
}

}  // namespace

double quarter_circle_discrepancy(std::span<const double> x, std::span<const double> y) {
  if (x.empty() || x.size() != y.size())
    throw std::invalid_argument("a discrepancy needs points, and as many x as y");
  std::vector<double> squared;
  for (std::size_t i = 0; i < x.size(); ++i)
    if (const double s = x[i] * x[i] + y[i] * y[i]; s <= 1) squared.push_back(s);
  std::sort(squared.begin(), squared.end());
  const auto n = static_cast<double>(x.size());
  double most = std::abs(std::numbers::pi / 4 - static_cast<double>(squared.size()) / n);
  for (std::size_t i = 0; i < squared.size(); ++i) {
    const double area = std::numbers::pi / 4 * squared[i], before = static_cast<double>(i) / n;
    most = std::max({most, area - before, before + 1 / n - area});
  }
  return most;
}

ShapeDiscrepancy triangle_discrepancy(const PointIndex<2>& points, const ShapeParameters& parameters) {
  check_points(points);
  return max_over_shapes(parameters, [&](std::uint32_t number, double) {
    const std::array<double, 6> u = random_numbers(parameters, number);
    Point a = {u[0], u[1]}, b = {u[2], u[3]};
    const double doubled = a[0] * b[1] - b[0] * a[1];
    if (doubled == 0) return 0.0;
    if (doubled < 0) std::swap(a, b);
    const std::array<HalfSpace<2>, 3> sides = {left_of({0, 0}, a), left_of(a, b), left_of(b, {0, 0})};
    return error_of(points, sides, 0.5 * std::abs(doubled));
  });
}

ShapeDiscrepancy rotated_box_discrepancy(const PointIndex<2>& points, const ShapeParameters& parameters) {
  check_points(points);
  return max_over_shapes(parameters, [&](std::uint32_t number, double) {
    const std::array<double, 6> u = random_numbers(parameters, number);
    const double angle = 0.5 * std::numbers::pi * u[4];
    return rectangle_error(points, {u[0], u[1]}, {std::cos(angle), std::sin(angle)},
                           {0.5 * u[2], 0.5 * u[3]});
  });
}

ShapeDiscrepancy density_box_discrepancy(const PointIndex<2>& points, PlanarDensity density,
                                         const ShapeParameters& parameters) {
  check_points(points);
  return max_over_shapes(parameters, [&](std::uint32_t number, double) {
    const std::array<double, 6> u = random_numbers(parameters, number);
    const std::array<HalfSpace<2>, 2> sides = {{{{1, 0}, u[0]}, {{0, 1}, u[1]}}};
    return error_of(points, sides, box_share(density, u[0], u[1]));
  });
}

ShapeDiscrepancy metric_box_discrepancy(const PointIndex<2>& points, const PlanarMetric& metric,
                                        const ShapeParameters& parameters) {
  check_points(points);
  const auto [e, f, g] = metric;
  const double determinant = e * g - f * f;
  if (!(e > 0 && determinant > 0 && std::isfinite(e + g)))
    throw std::invalid_argument("the metric is not positive definite");
  // Eigenvalues over the root of the determinant; a length of 1 in the metric is 1 / sqrt(eigenvalue).
  const double angle = 0.5 * std::atan2(2 * f, e - g);  // of the axis with the larger eigenvalue
  const double mean = 0.5 * (e + g) / std::sqrt(determinant);
  const double large = mean + std::sqrt(std::max(0.0, mean * mean - 1));
  const Point along = {std::cos(angle), std::sin(angle)};
  const Point scale = {1 / std::sqrt(large), std::sqrt(large)};
  return max_over_shapes(parameters, [&](std::uint32_t number, double) {
    const std::array<double, 6> u = random_numbers(parameters, number);
    return rectangle_error(points, {u[0], u[1]}, along, {0.5 * u[2] * scale[0], 0.5 * u[3] * scale[1]});
  });
}

}  // namespace meander
