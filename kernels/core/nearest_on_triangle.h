// The point of a triangle that is nearest to a given point.
#pragma once

#include <limits>

#include "kernels/core/instruction_set.h"
#include "kernels/core/vector3.h"

namespace meander {

struct TrianglePlace {
  double squared = std::numeric_limits<double>::infinity();  // squared distance
  double weight1 = 0, weight2 = 0;                           // barycentric weights of corners 1 and 2
  Vector3 point;
};

// Sets `point` to the nearest point of the segment a b and returns its weight of b, exact at the ends.
MEANDER_INLINE double nearest_on_segment(Vector3 p, Vector3 a, Vector3 b, Vector3& point) {
  const Vector3 edge = b - a;
  const double length = dot(edge, edge), along = dot(p - a, edge);
  if (!(along > 0)) {
    point = a;
    return 0;
  }
  if (along >= length) {
    point = b;
    return 1;
  }
  point = a + (along / length) * edge;
  return along / length;
}

// Finds the nearest point of the triangle a b c. Every candidate is a point of the triangle whatever rounding
// did to its weights, so the distance found is never too small. Flat and needle-like triangles, whose plane
// is uncertain, fall back on their edges.
MEANDER_INLINE TrianglePlace nearest_on_triangle(Vector3 p, Vector3 a, Vector3 b, Vector3 c) {
  TrianglePlace best;
  const auto offer = [&](Vector3 point, double weight1, double weight2) {
    const Vector3 offset = p - point;
    const double squared = dot(offset, offset);
    if (squared < best.squared) best = {squared, weight1, weight2, point};
  };
  const Vector3 ab = b - a, ac = c - a, ap = p - a;
  const double bb = dot(ab, ab), bc = dot(ab, ac), cc = dot(ac, ac);
  const double pb = dot(ap, ab), pc = dot(ap, ac);
  const double area = bb * cc - bc * bc;
  bool beyond_ab = true, beyond_bc = true, beyond_ac = true;
  if (area > 1e-14 * bb * cc) {
    const double v = (cc * pb - bc * pc) / area, w = (bb * pc - bc * pb) / area;
    const bool is_certain = area > 1e-6 * bb * cc;
    if (v >= 0 && w >= 0 && v + w <= 1) {
      offer(a + v * ab + w * ac, v, w);
      if (is_certain) return best;
    }
    // The nearest point lies on an edge that the point is beyond of, corners included.
    if (is_certain) {
      beyond_ab = w < 0;
      beyond_bc = v + w > 1;
      beyond_ac = v < 0;
    }
  }
  Vector3 point;
  if (beyond_ab) {
    const double on_ab = nearest_on_segment(p, a, b, point);
    offer(point, on_ab, 0);
  }
  if (beyond_bc) {
    const double on_bc = nearest_on_segment(p, b, c, point);
    offer(point, 1 - on_bc, on_bc);
  }
  if (beyond_ac) {
    const double on_ac = nearest_on_segment(p, a, c, point);
    offer(point, 0, on_ac);
  }
  return best;
}

}  // namespace meander
