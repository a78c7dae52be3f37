// The coordinate frame of a bounding box.
#pragma once

#include <array>

#include "kernels/core/vector3.h"

namespace meander {

// p = center + unit * w with every coordinate of w in [-1, 1]. unit is a power of two, more than half of the
// longest side of the box and at most the whole side, down to the smallest positive double.
struct BoxFrame {
  Vector3 center;
  double unit = 1;
  double diagonal = 0;  // of the box
};

// box: min x, y, z, max x, y, z. Throws ItemError: zero_area for a single point; non_finite where the
// diagonal overflows double.
BoxFrame box_frame(const std::array<double, 6>& box);

}  // namespace meander
