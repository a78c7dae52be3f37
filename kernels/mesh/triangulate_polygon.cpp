#include "kernels/mesh/triangulate_polygon.h"

#include <cmath>

namespace meander {

namespace {

struct Point2 {
  double x, y;
};

double turn(Point2 a, Point2 b, Point2 c) { return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x); }

// Newell's normal: exact for planar polygons, the best fit for others; its length is twice the projected
// area.
Vector3 newell_normal(std::span<const Vector3> p) {
  Vector3 n;
  for (std::size_t i = 0; i < p.size(); ++i) {
    const Vector3 a = p[i] - p[0], b = p[(i + 1) % p.size()] - p[0];
    n = n + cross(a, b);
  }
  return n;
}

// Drops the coordinate along which the normal is longest, keeping the polygon counter-clockwise.
std::vector<Point2> project(std::span<const Vector3> p, Vector3 n) {
  const double ax = std::abs(n.x), ay = std::abs(n.y), az = std::abs(n.z);
  std::vector<Point2> flat(p.size());
  for (std::size_t i = 0; i < p.size(); ++i) {
    const Vector3 q = p[i] - p[0];
    if (az >= ax && az >= ay) {
      flat[i] = n.z > 0 ? Point2{q.x, q.y} : Point2{q.y, q.x};
    } else if (ax >= ay) {
      flat[i] = n.x > 0 ? Point2{q.y, q.z} : Point2{q.z, q.y};
    } else {
      flat[i] = n.y > 0 ? Point2{q.z, q.x} : Point2{q.x, q.z};
    }
  }
  return flat;
}

// Every corner turns left (or not at all) and the boundary goes round once: a star polygon turns left twice
// round.
bool is_convex(std::span<const Point2> p) {
  const std::size_t n = p.size();
  int sign_changes = 0;
  double last = 0;
  for (std::size_t i = 0; i < n; ++i) {
    if (turn(p[i], p[(i + 1) % n], p[(i + 2) % n]) < 0) return false;
    const double dx = p[(i + 1) % n].x - p[i].x;
    if (dx == 0) continue;
    if (last * dx < 0) ++sign_changes;
    last = dx;
  }
  return sign_changes <= 2;
}

bool inside(Point2 q, Point2 a, Point2 b, Point2 c) {
  return turn(a, b, q) >= 0 && turn(b, c, q) >= 0 && turn(c, a, q) >= 0;
}

bool same(Point2 a, Point2 b) { return a.x == b.x && a.y == b.y; }

// An ear: a left turn whose triangle holds no reflex corner of the rest.
bool is_ear(std::span<const Point2> p, std::span<const std::uint32_t> ring, std::size_t i) {
  const std::size_t n = ring.size();
  const Point2 a = p[ring[(i + n - 1) % n]], b = p[ring[i]], c = p[ring[(i + 1) % n]];
  if (turn(a, b, c) <= 0) return false;
  for (std::size_t j = 0; j < n; ++j) {
    const Point2 q = p[ring[j]];
    // A bridge to a hole visits its ends twice: a copy of the ear's own corner does not block it.
    if (same(q, a) || same(q, b) || same(q, c)) continue;
    if (turn(p[ring[(j + n - 1) % n]], q, p[ring[(j + 1) % n]]) > 0) continue;
    if (inside(q, a, b, c)) return false;
  }
  return true;
}

void clip_ears(std::span<const Point2> p, std::vector<std::uint32_t>& triangles) {
  std::vector<std::uint32_t> ring(p.size());
  for (std::size_t i = 0; i < ring.size(); ++i) ring[i] = static_cast<std::uint32_t>(i);
  std::size_t i = 0, misses = 0;
  while (ring.size() > 3 && misses < ring.size()) {
    const std::size_t n = ring.size();
    i %= n;
    if (!is_ear(p, ring, i)) {
      ++i;
      ++misses;
      continue;
    }
    triangles.insert(triangles.end(), {ring[(i + n - 1) % n], ring[i], ring[(i + 1) % n]});
    ring.erase(ring.begin() + static_cast<std::ptrdiff_t>(i));
    // Skipping a corner keeps the triangles well shaped; a fan from one corner would make slivers.
    ++i;
    misses = 0;
  }
  for (std::size_t k = 1; k + 1 < ring.size(); ++k)
    triangles.insert(triangles.end(), {ring[0], ring[k], ring[k + 1]});
}

}  // namespace

bool triangulate_polygon(std::span<const Vector3> corners, std::vector<std::uint32_t>& triangles) {
  const auto count = static_cast<std::uint32_t>(corners.size());
  if (count > 3) {
    const Vector3 normal = newell_normal(corners);
    if (dot(normal, normal) > 0) {
      const std::vector<Point2> flat = project(corners, normal);
      if (!is_convex(flat)) {
        clip_ears(flat, triangles);
        return true;
      }
    }
  }
  for (std::uint32_t k = 1; k + 1 < count; ++k) triangles.insert(triangles.end(), {0, k, k + 1});
  return false;
}

}  // namespace meander
