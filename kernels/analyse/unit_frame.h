// Coordinates of a mesh brought to the range [-1, 1], so that no scale or offset of a file can overflow or be
// lost in float32.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <stdexcept>

#include "kernels/core/vector3.h"

namespace meander {

// p = center + unit * w; unit is a power of two.
struct UnitFrame {
  Vector3 center;
  double unit = 1;
  double diagonal = 0;  // of the bounding box, units of p

  Vector3 to_unit(Vector3 p) const { return (1 / unit) * (p - center); }
  Vector3 from_unit(Vector3 w) const { return center + unit * w; }
};

// The frame of all corners of the triangles. Throws std::invalid_argument without triangles, for vertex
// numbers that are not there and corners that are not finite or beyond 1e300. O(T).
inline UnitFrame unit_frame(std::span<const double> x, std::span<const double> y, std::span<const double> z,
                            std::span<const std::uint32_t> triangles) {
  if (x.size() != y.size() || x.size() != z.size())
    throw std::invalid_argument("as many x as y and z of vertices");
  if (triangles.empty() || triangles.size() % 3 != 0)
    throw std::invalid_argument("a mesh is three vertex numbers a triangle, and at least one triangle");
  constexpr double infinity = std::numeric_limits<double>::infinity();
  Vector3 low{infinity, infinity, infinity}, high{-infinity, -infinity, -infinity};
  for (const std::uint32_t v : triangles) {
    if (v >= x.size()) throw std::invalid_argument("a triangle names a vertex that is not there");
    if (!(std::abs(x[v]) <= 1e300 && std::abs(y[v]) <= 1e300 && std::abs(z[v]) <= 1e300))
      throw std::invalid_argument("corners must be finite, and at most 1e300");
    low = {std::min(low.x, x[v]), std::min(low.y, y[v]), std::min(low.z, z[v])};
    high = {std::max(high.x, x[v]), std::max(high.y, y[v]), std::max(high.z, z[v])};
  }
  UnitFrame frame;
  frame.center = 0.5 * (low + high);
  const Vector3 size = high - low;
  const double longest = std::max({size.x, size.y, size.z});
  // Half of the longest side is below 2^exponent.
  if (longest > 0) frame.unit = std::ldexp(1.0, std::max(std::ilogb(longest), -1020));
  frame.diagonal = frame.unit * norm((1 / frame.unit) * size);
  return frame;
}

}  // namespace meander
