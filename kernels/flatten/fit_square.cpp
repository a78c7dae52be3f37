#include "kernels/flatten/fit_square.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "kernels/flatten/orient2d.h"

namespace meander {

namespace {

constexpr double margin = 0x1p-12;

struct Point {
  double u, v;
  friend bool operator==(const Point&, const Point&) = default;
};

double edge_length(double u, double v) { return std::sqrt(u * u + v * v); }

// Drops points inside the quadrilateral of the extremes in four directions, which cannot be on the hull.
std::vector<Point> hull_candidates(std::span<const double> u, std::span<const double> v) {
  std::size_t extreme[4] = {0, 0, 0, 0};
  for (std::size_t i = 0; i < u.size(); ++i) {
    const auto along = [&](std::size_t j, int k) {
      return k == 0 ? u[j] + v[j] : k == 1 ? v[j] - u[j] : k == 2 ? -u[j] - v[j] : u[j] - v[j];
    };
    for (int k = 0; k < 4; ++k)
      if (along(i, k) > along(extreme[k], k)) extreme[k] = i;
  }
  std::vector<Point> kept;
  for (std::size_t i = 0; i < u.size(); ++i) {
    bool inside = true;
    for (int k = 0; k < 4 && inside; ++k) {
      const std::size_t a = extreme[k], b = extreme[(k + 1) % 4];
      const double cross = (u[b] - u[a]) * (v[i] - v[a]) - (v[b] - v[a]) * (u[i] - u[a]);
      inside = cross > 1e-12 * (std::abs(u[b] - u[a]) + std::abs(v[b] - v[a])) *
                           (std::abs(u[i] - u[a]) + std::abs(v[i] - v[a]));
    }
    if (!inside) kept.push_back({u[i], v[i]});
  }
  return kept;
}

// The hull counter-clockwise, without collinear points (Andrew 1979).
std::vector<Point> convex_hull(std::vector<Point> points) {
  std::sort(points.begin(), points.end(),
            [](Point a, Point b) { return a.u < b.u || (a.u == b.u && a.v < b.v); });
  points.erase(std::unique(points.begin(), points.end()), points.end());
  if (points.size() < 3) return points;
  std::vector<Point> hull;
  const auto half = [&](auto begin, auto end) {
    const std::size_t base = hull.size();
    for (auto p = begin; p != end; ++p) {
      while (hull.size() >= base + 2) {
        const Point &a = hull[hull.size() - 2], &b = hull.back();
        if (orient2d(a.u, a.v, b.u, b.v, p->u, p->v) > 0) break;
        hull.pop_back();
      }
      hull.push_back(*p);
    }
    hull.pop_back();
  };
  half(points.begin(), points.end());
  half(points.rbegin(), points.rend());
  return hull;
}

// Direction of the hull edge whose bounding rectangle has the smallest area (rotating calipers).
Point best_direction(const std::vector<Point>& hull) {
  Point best{1, 0};
  double smallest = std::numeric_limits<double>::infinity();
  const std::size_t n = hull.size();
  std::size_t right = 0, top = 0, left = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const Point a = hull[i], b = hull[(i + 1) % n];
    const double length = edge_length(b.u - a.u, b.v - a.v);
    if (!(length > 0)) continue;
    const Point d{(b.u - a.u) / length, (b.v - a.v) / length};
    const auto along = [&](std::size_t j) { return hull[j % n].u * d.u + hull[j % n].v * d.v; };
    const auto across = [&](std::size_t j) { return hull[j % n].v * d.u - hull[j % n].u * d.v; };
    right = std::max(right, i + 1);
    while (right < i + n && along(right + 1) > along(right)) ++right;
    top = std::max(top, right);
    while (top < i + n && across(top + 1) > across(top)) ++top;
    left = std::max(left, top);
    while (left < i + n && along(left + 1) < along(left)) ++left;
    const double area = (along(right) - along(left)) * (across(top) - across(i));
    if (area < smallest) {
      smallest = area;
      best = d;
    }
  }
  return best;
}

}  // namespace

double fit_square(std::span<double> u, std::span<double> v) {
  const std::vector<Point> hull = convex_hull(hull_candidates(u, v));
  Point d{1, 0};
  if (hull.size() >= 3) {
    d = best_direction(hull);
  } else if (hull.size() == 2) {
    const double length = edge_length(hull[1].u - hull[0].u, hull[1].v - hull[0].v);
    if (length > 0) d = {(hull[1].u - hull[0].u) / length, (hull[1].v - hull[0].v) / length};
  }
  double low_u = std::numeric_limits<double>::infinity(), high_u = -low_u, low_v = low_u, high_v = -low_u;
  for (const Point& p : hull) {
    const double along = p.u * d.u + p.v * d.v, across = p.v * d.u - p.u * d.v;
    low_u = std::min(low_u, along);
    high_u = std::max(high_u, along);
    low_v = std::min(low_v, across);
    high_v = std::max(high_v, across);
  }
  if (high_v - low_v > high_u - low_u) {  // a quarter turn: along' = across, across' = -along
    d = {-d.v, d.u};
    const double old_low_u = low_u;
    low_u = low_v;
    low_v = -high_u;
    high_u = high_v;
    high_v = -old_low_u;
  }
  const double extent = high_u - low_u;
  const double scale = extent > 0 ? (1 - 2 * margin) / extent : 1.0;
  const double center_u = 0.5 * (low_u + high_u), center_v = 0.5 * (low_v + high_v);
  for (std::size_t i = 0; i < u.size(); ++i) {
    const double along = u[i] * d.u + v[i] * d.v, across = v[i] * d.u - u[i] * d.v;
    u[i] = std::clamp(0.5 + scale * (along - center_u), 0.0, 1.0);
    v[i] = std::clamp(0.5 + scale * (across - center_v), 0.0, 1.0);
  }
  return scale;
}

}  // namespace meander
