// Ear clipping of one polygon in the plane, and the search for the corners that keep a corner from being an
// ear.
#pragma once

#include <cstddef>
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

// Splits the polygon, counter-clockwise and with K >= 3 corners, into K - 2 triangles, which are appended.
// Corners are tested in turn, the one behind a clipped one is passed over: that makes fewer slivers than a
// fan. Where no ear is left, as the polygon crosses itself, what remains is fanned from its first corner.
// Pure. Cost: each test looks for a reflex corner in a triangle, in a tree of about O(sqrt K) steps from 33
// corners on, and is not repeated before the reflex corner that it found is gone: 3 to 20 us a corner
// for outlines of 10^5. Adversarial polygons, whose corners all wait for one reflex corner after the
// other, take O(K^2) tests; the token is checked every 256. Throws what it throws. Eberly 2002,
// "Triangulation by ear clipping".
void clip_ears(std::span<const PlanePoint> polygon, std::vector<std::uint32_t>& triangles,
               const CancelToken& cancel = {});

}  // namespace meander
