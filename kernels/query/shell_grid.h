// What can be reached from outside of a surface that is not closed, through gaps that are wide enough.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "kernels/core/vector3.h"
#include "kernels/query/triangle_tree.h"

namespace meander {

// Cells along the longest side.
inline constexpr std::size_t shell_cells = 128;

enum class ShellCell : std::uint8_t { enclosed, surface, outside };

// Cells over the box of a surface, two more on every side.
struct ShellGrid {
  Vector3 low;
  double cell = 0;                     // side of a cell
  std::array<std::size_t, 3> count{};  // along x, y, z
  std::vector<ShellCell> kind;         // x first
};

// Marks the cells that triangles meet, and floods the others from outside, side by side: what is not reached
// is enclosed. Gaps narrower than a cell are closed by the cells of their borders. The longest side of the
// box has `max_cells` - 4 cells, 12 to 252 (else std::invalid_argument), or half as many as often as marking
// would look at more than 2^27 cells. O(cells + cells that triangles meet): some 20 ms for 128.
ShellGrid build_shell_grid(const TriangleTree& tree, std::size_t max_cells = shell_cells);

// Upper bound of its bytes while it is made: the cells, and those that wait while it is flooded.
constexpr double shell_grid_bytes(std::size_t max_cells = shell_cells) {
  const auto side = static_cast<double>(max_cells);
  return 13 * side * side * side;
}

// Whether a point lies in a cell of the surface.
bool is_surface_cell(const ShellGrid& grid, Vector3 point);

struct ShellSide {
  bool inside = false, certain = false;
};

// The side of a point: that of its cell; in a cell of the surface that of the cells around it, up to two
// away, to whose middle a segment leads that no triangle crosses. Where there are both kinds, a gap narrower
// than a cell leads to the point: it is uncertain. Where there is none, it is taken as enclosed, and
// uncertain. Up to 124 segments, most often one or two. likely: as of is_free_segment.
ShellSide shell_side(const ShellGrid& grid, const TriangleTree& tree, Vector3 point,
                     std::span<const std::uint32_t> likely = {});

}  // namespace meander
