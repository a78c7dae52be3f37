// The triangles of a surface under a tree of bounding boxes, for questions about rotated boxes.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "kernels/analyse/box_discrepancy.h"
#include "kernels/mesh/bounds_tree.h"

namespace meander {

struct BoxTriangles {
  BoundsTree tree;              // along the 3-D Hilbert curve
  std::vector<double> corners;  // 9 per position of the tree: coordinates of the three corners

  std::size_t count() const { return tree.count(); }
  Vector3 corner(std::size_t position, std::size_t k) const {
    const double* at = corners.data() + 9 * position + 3 * k;
    return {at[0], at[1], at[2]};
  }
};

// x, y, z: V finite positions; triangles: 3 T vertex numbers. O(T log T).
BoxTriangles build_box_triangles(std::span<const double> x, std::span<const double> y,
                                 std::span<const double> z, std::span<const std::uint32_t> triangles);

// Coordinates in the frame of a box, whose faces are at +-half[k].
inline std::array<double, 3> to_box(const RotatedBox& box, Vector3 p) {
  const Vector3 offset = p - box.center;
  return {dot(box.axes[0], offset), dot(box.axes[1], offset), dot(box.axes[2], offset)};
}

}  // namespace meander
