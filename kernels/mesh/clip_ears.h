// Ear clipping of one polygon in the plane.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "kernels/core/cancel.h"

namespace meander {

struct PlanePoint {
  double x, y;
};

// Twice the signed area of a triangle, positive when it turns left.
inline double turn(PlanePoint a, PlanePoint b, PlanePoint c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

// Splits a counter-clockwise polygon of K >= 3 corners into K - 2 triangles, which are appended. Corners are
// tested in turn, and the corner behind a clipped one is passed over: that makes fewer slivers than a fan.
// Where no ear is left, because the polygon crosses itself, the rest is fanned from its first corner. Pure.
// Throws timeout / RunCanceled from `cancel`, checked every 256 tests. Eberly 2002, "Triangulation by ear
// clipping".
//
// Cost: each test looks for a reflex corner in a triangle, from 33 corners on in a tree of about O(sqrt K)
// steps, and is not repeated before the reflex corner that it found is gone. Adversarial polygons, whose
// corners all wait for one reflex corner after the other, take O(K^2) tests.
void clip_ears(std::span<const PlanePoint> polygon, std::vector<std::uint32_t>& triangles,
               const CancelToken& cancel = {});

}  // namespace meander
