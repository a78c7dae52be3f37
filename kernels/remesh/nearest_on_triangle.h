// The point of a triangle nearest to another one.
#pragma once

#include <algorithm>

#include "kernels/core/vector3.h"

namespace meander {

struct TrianglePlace {
  double squared = 0;               // distance
  double weight1 = 0, weight2 = 0;  // barycentric weights of corners 1 and 2
};

// By the regions of the plane around the triangle; a triangle without area is its edges.
inline TrianglePlace nearest_on_triangle(Vector3 p, Vector3 a, Vector3 b, Vector3 c) {
  const Vector3 u = b - a, v = c - a, r = p - a;
  const double uu = dot(u, u), uv = dot(u, v), vv = dot(v, v), ur = dot(u, r), vr = dot(v, r);
  const double det = uu * vv - uv * uv;
  const auto at = [&](double s, double t) {
    const Vector3 d = r - s * u - t * v;
    return TrianglePlace{dot(d, d), s, t};
  };
  if (det > 0) {
    const double s = (vv * ur - uv * vr) / det, t = (uu * vr - uv * ur) / det;
    if (s >= 0 && t >= 0 && s + t <= 1) return at(s, t);
  }
  const auto share = [](double along, double whole) {
    return whole > 0 ? std::clamp(along / whole, 0.0, 1.0) : 0.0;
  };
  TrianglePlace best = at(share(ur, uu), 0);
  const TrianglePlace second = at(0, share(vr, vv));
  if (second.squared < best.squared) best = second;
  const double k = share(dot(c - b, p - b), dot(c - b, c - b));
  const TrianglePlace third = at(1 - k, k);
  return third.squared < best.squared ? third : best;
}

}  // namespace meander
