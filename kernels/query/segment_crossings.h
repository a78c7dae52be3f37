// How often a segment crosses a surface, and which way.
#pragma once

#include <cstdint>
#include <span>

#include "kernels/query/triangle_tree.h"

namespace meander {

struct SegmentCrossings {
  int outward = 0;          // crossings along the normals less those against them
  std::uint32_t count = 0;  // all of them
  bool sure = false;  // false where the segment passes an edge or a corner so closely, or ends so close to a
                      // triangle, that rounding decides; the others say nothing then
};

// Crossings of the segment from a to b, in the coordinates of the tree. flipped: a byte for each triangle
// that is to be turned over where it is not 0, or nothing. Signs of volumes in double with a bound of their
// error. Where the surface is closed the winding number at b is that at a less `outward`. O(log T + triangles
// near the box of the segment): for short segments.
SegmentCrossings segment_crossings(const TriangleTree& tree, std::span<const std::uint8_t> flipped, Vector3 a,
                                   Vector3 b);

// Whether it surely crosses no triangle: count is 0 and sure. Ends at the first that it may cross. likely:
// positions in the tree of triangles that are looked at before all others, such as those nearest to the ends.
// They do not change the answer; a segment that is not free most often crosses one of them.
bool is_free_segment(const TriangleTree& tree, Vector3 a, Vector3 b,
                     std::span<const std::uint32_t> likely = {});

}  // namespace meander
