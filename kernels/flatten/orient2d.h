// The orientation of three points in the plane, with an exact sign.
#pragma once

namespace meander {

// Positive when a, b, c turn counter-clockwise, negative when clockwise, 0 when collinear: the sign is exact
// (floating-point filter, then expansion arithmetic; Shewchuk 1997, "Adaptive precision floating-point
// arithmetic and fast robust geometric predicates"), the value approximates twice the signed area.
// Coordinates must be finite; products must neither overflow nor underflow (magnitudes 0 or within 1e-140 ..
// 1e140).
double orient2d(double ax, double ay, double bx, double by, double cx, double cy);

}  // namespace meander
