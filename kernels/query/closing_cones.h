// Cones from the open edges of a surface to the middle of each hole, which close it, roughly.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace meander {

// Triangles that pass every open edge as often the other way as the surface does, hole by hole.
struct ClosingCones {
  std::vector<double> x, y, z;
  std::vector<std::uint32_t> triangles;   // 3 vertex numbers each, the last that of the tip
  std::vector<std::uint32_t> hole_begin;  // H + 1 triangles

  std::size_t holes() const { return hole_begin.size() - 1; }
};

// boundary: seven numbers for each open edge (OrientedSurface). Edges that join at their ends have one cone,
// whose tip is the middle of them, weighted by length. An edge that is passed several times more has as many
// triangles. Holes are in the order of their first edges. O(E log E).
ClosingCones closing_cones(std::span<const double> boundary);

// Upper bound of the bytes that it takes, and that the cones have, for open edges that count once.
constexpr double closing_cones_bytes(double edges) { return 220 * edges + 4096; }

}  // namespace meander
