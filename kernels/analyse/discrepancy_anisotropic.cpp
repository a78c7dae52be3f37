#include "kernels/analyse/discrepancy_anisotropic.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "kernels/analyse/point_index.h"
#include "kernels/analyse/require.h"
#include "kernels/core/random.h"

namespace meander {

namespace {

using Point = std::array<double, 2>;
// The index wants points in [0, 1]^2: the window is this disk.
constexpr Point middle = {0.5, 0.5};
constexpr double rim = 0.5;
constexpr double window_area = std::numbers::pi / 4;

// The random numbers of one shape, in the order of drawing. Kinds share none.
class ShapeNumbers {
 public:
  ShapeNumbers(std::uint64_t seed, std::uint8_t kind, std::uint32_t number)
      : key_(make_random_key(seed, {&kind, 1})), number_(number) {}
  UnitPair next() { return random_pair(key_, Stream::test_shapes, number_, counter_++); }
  Point next_in_window() {
    const UnitPair u = next();
    const double r = rim * std::sqrt(u.first), angle = 2 * std::numbers::pi * u.second;
    return {middle[0] + r * std::cos(angle), middle[1] + r * std::sin(angle)};
  }

 private:
  RandomKey key_;
  std::uint32_t number_, counter_ = 0;
};

double error_of(const PointIndex<2>& points, std::size_t inside, double area) {
  return std::abs(static_cast<double>(inside) / static_cast<double>(points.count()) - area / window_area);
}

double disk_error(const PointIndex<2>& points, ShapeNumbers numbers) {
  const Point center = numbers.next_in_window();
  const double most = rim - std::hypot(center[0] - middle[0], center[1] - middle[1]);
  const double radius = std::max(0.0, most) * numbers.next().first;
  return error_of(points, count_in_disk(points, center, radius), std::numbers::pi * radius * radius);
}

double box_error(const PointIndex<2>& points, ShapeNumbers numbers) {
  // About one draw in eight fits; that 10^4 fail does not happen.
  for (int tries = 0; tries < 10000; ++tries) {
    const Point center = numbers.next_in_window();
    const UnitPair sides = numbers.next();
    const double angle = 0.5 * std::numbers::pi * numbers.next().first;
    const Point along = {std::cos(angle), std::sin(angle)}, across = {-along[1], along[0]};
    const double half_along = rim * sides.first, half_across = rim * sides.second;
    const double u = along[0] * (center[0] - middle[0]) + along[1] * (center[1] - middle[1]);
    const double v = across[0] * (center[0] - middle[0]) + across[1] * (center[1] - middle[1]);
    if (std::hypot(std::abs(u) + half_along, std::abs(v) + half_across) > rim) continue;
    const double at_along = along[0] * center[0] + along[1] * center[1];
    const double at_across = across[0] * center[0] + across[1] * center[1];
    const std::array<HalfSpace<2>, 4> shape = {{{along, half_along + at_along},
                                                {{-along[0], -along[1]}, half_along - at_along},
                                                {across, half_across + at_across},
                                                {{-across[0], -across[1]}, half_across - at_across}}};
    return error_of(points, count_inside(points, shape), 4 * half_along * half_across);
  }
  return 0;
}

double triangle_error(const PointIndex<2>& points, ShapeNumbers numbers) {
  Point a = numbers.next_in_window(), b = numbers.next_in_window();
  const Point c = numbers.next_in_window();
  const double doubled = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]);
  if (doubled == 0) return 0;
  if (doubled < 0) std::swap(a, b);
  const auto left_of = [](Point from, Point to) -> HalfSpace<2> {
    const double dx = to[0] - from[0], dy = to[1] - from[1], length = std::hypot(dx, dy);
    const Point normal = {dy / length, -dx / length};
    return {normal, normal[0] * from[0] + normal[1] * from[1]};
  };
  const std::array<HalfSpace<2>, 3> shape = {left_of(a, b), left_of(b, c), left_of(c, a)};
  return error_of(points, count_inside(points, shape), 0.5 * std::abs(doubled));
}

}  // namespace

AnisotropicDiscrepancy anisotropic_discrepancy(std::span<const double> x, std::span<const double> y,
                                               TangentTensor log_spacing,
                                               const AnisotropicDiscrepancyParameters& parameters) {
  require(!x.empty() && x.size() == y.size(), "a discrepancy needs points, and as many x as y");
  for (std::size_t i = 0; i < x.size(); ++i)
    require(std::isfinite(x[i]) && std::isfinite(y[i]), "points must be finite");
  require(parameters.windows >= 1 && parameters.windows <= 4096, "1..4096 windows");
  const auto& [origin, a, b] = parameters.domain;
  const double area = a[0] * b[1] - a[1] * b[0];
  require(std::isfinite(area) && area != 0 && std::isfinite(origin[0] + origin[1]), "the domain is flat");
  const double half_trace = 0.5 * trace(log_spacing);
  const TangentTensor unit_log = log_spacing + TangentTensor{-half_trace, 0, -half_trace};
  const TangentTensor s = exponential(unit_log), inverse = exponential(-1.0 * unit_log);
  require(std::isfinite(s.xx + s.xy + s.yy + inverse.xx + inverse.yy), "the tensor is out of range");

  // (s, t) of a point are products of p - origin with the dual vectors of a and b; the ellipse S u, |u| <= 1,
  // reaches |S dual| in each.
  const auto reach = [&](Point dual) {
    return std::hypot(s.xx * dual[0] + s.xy * dual[1], s.xy * dual[0] + s.yy * dual[1]);
  };
  const double reach_a = reach({b[1] / area, -b[0] / area}), reach_b = reach({-a[1] / area, a[0] / area});
  const double radius = 0.5 / std::max(reach_a, reach_b);

  AnisotropicDiscrepancy result;
  result.window_share = std::numbers::pi * radius * radius / std::abs(area);
  std::vector<double> u, v;
  double stable = 0;
  const RandomKey key = make_random_key(parameters.shapes.seed, {});
  // One window where they would all be the same.
  const bool fixed = 1 - 2 * radius * std::min(reach_a, reach_b) < 1e-9;
  const std::uint32_t windows = fixed ? 1 : parameters.windows;
  for (std::uint32_t w = 0; w < windows; ++w) {
    const UnitPair at = windows == 1 ? UnitPair{0.5, 0.5} : random_pair(key, Stream::metric_window, w);
    const double along_a = radius * reach_a + (1 - 2 * radius * reach_a) * at.first;
    const double along_b = radius * reach_b + (1 - 2 * radius * reach_b) * at.second;
    const Point center = {origin[0] + along_a * a[0] + along_b * b[0],
                          origin[1] + along_a * a[1] + along_b * b[1]};
    u.clear();
    v.clear();
    for (std::size_t i = 0; i < x.size(); ++i) {
      const double dx = (x[i] - center[0]) / radius, dy = (y[i] - center[1]) / radius;
      const double pulled_x = inverse.xx * dx + inverse.xy * dy, pulled_y = inverse.xy * dx + inverse.yy * dy;
      if (pulled_x * pulled_x + pulled_y * pulled_y > 1) continue;
      u.push_back(middle[0] + rim * pulled_x);
      v.push_back(middle[1] + rim * pulled_y);
    }
    if (u.empty()) continue;
    const PointIndex<2> points = build_point_index(u, v);
    const auto measure = [&](std::uint8_t kind, const auto& error) {
      const ShapeDiscrepancy most = max_over_shapes(parameters.shapes, [&](std::uint32_t number, double) {
        return error(points, ShapeNumbers(parameters.shapes.seed, kind, number));
      });
      stable += most.stable;
      return most.discrepancy;
    };
    result.disks += measure(1, disk_error);
    result.boxes += measure(2, box_error);
    result.triangles += measure(3, triangle_error);
    result.points += static_cast<double>(u.size());
    ++result.windows;
  }
  if (result.windows == 0) return result;
  const double share = 1.0 / result.windows;
  result.disks *= share;
  result.boxes *= share;
  result.triangles *= share;
  result.points *= share;
  result.windows_stable = stable * share / 3;
  return result;
}

}  // namespace meander
