// Rotations, fixed and random.
#pragma once

#include <array>
#include <cmath>

#include "kernels/core/random.h"
#include "kernels/core/vector3.h"

namespace meander {

// The rows of a rotation matrix.
using Rotation = std::array<Vector3, 3>;
constexpr Vector3 rotated(const Rotation& rows, const Vector3& v) {
  return {dot(rows[0], v), dot(rows[1], v), dot(rows[2], v)};
}

// The rotation of a unit quaternion.
constexpr Rotation rotation_of(double x, double y, double z, double w) {
  return {Vector3{1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)},
          Vector3{2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)},
          Vector3{2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)}};
}

// A rotation uniform on all rotations: the unit quaternion along a uniform point of the ball (Marsaglia 1972,
// "Choosing a point from the surface of a sphere"). Pure, by arithmetic and a root alone: the same on every
// machine.
inline Rotation random_rotation(RandomKey key, Stream stream) {
  // A draw falls into the ball with probability .31: all of 128 miss it once in 10^20.
  constexpr std::uint32_t max_draws = 128;
  double x = 0, y = 0, z = 0, w = 1;
  for (std::uint32_t draw = 0; draw < max_draws; ++draw) {
    const UnitPair a = random_pair(key, stream, 0, 2 * draw), b = random_pair(key, stream, 0, 2 * draw + 1);
    const double q[4] = {2 * a.first - 1, 2 * a.second - 1, 2 * b.first - 1, 2 * b.second - 1};
    const double squared = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
    if (squared > 1 || squared < 1e-6) continue;
    const double scale = 1 / std::sqrt(squared);
    x = scale * q[0];
    y = scale * q[1];
    z = scale * q[2];
    w = scale * q[3];
    break;
  }
  return rotation_of(x, y, z, w);
}

}  // namespace meander
