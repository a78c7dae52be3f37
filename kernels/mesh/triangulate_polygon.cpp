#include "kernels/mesh/triangulate_polygon.h"

#include <cmath>

#include "kernels/mesh/clip_ears.h"

namespace meander {

namespace {

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
std::vector<PlanePoint> project(std::span<const Vector3> p, Vector3 n) {
  const double ax = std::abs(n.x), ay = std::abs(n.y), az = std::abs(n.z);
  std::vector<PlanePoint> flat(p.size());
  for (std::size_t i = 0; i < p.size(); ++i) {
    const Vector3 q = p[i] - p[0];
    if (az >= ax && az >= ay) {
      flat[i] = n.z > 0 ? PlanePoint{q.x, q.y} : PlanePoint{q.y, q.x};
    } else if (ax >= ay) {
      flat[i] = n.x > 0 ? PlanePoint{q.y, q.z} : PlanePoint{q.z, q.y};
    } else {
      flat[i] = n.y > 0 ? PlanePoint{q.z, q.x} : PlanePoint{q.x, q.z};
    }
  }
  return flat;
}

// Whether every corner turns left (or not at all) and the boundary goes around once: a star polygon goes
// around twice.
bool is_convex(std::span<const PlanePoint> p) {
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

}  // namespace

bool triangulate_polygon(std::span<const Vector3> corners, std::vector<std::uint32_t>& triangles,
                         const CancelToken& cancel) {
  const auto count = static_cast<std::uint32_t>(corners.size());
  if (count > 3) {
    const Vector3 normal = newell_normal(corners);
    if (dot(normal, normal) > 0) {
      const std::vector<PlanePoint> flat = project(corners, normal);
      if (!is_convex(flat)) {
        clip_ears(flat, triangles, cancel);
        return true;
      }
    }
  }
  for (std::uint32_t k = 1; k + 1 < count; ++k) triangles.insert(triangles.end(), {0, k, k + 1});
  return false;
}

}  // namespace meander
