// Orientation tables of the curves, derived from their production rules (docs/METHODS.md 5.1).
#pragma once

#include <array>
#include <cstdint>

#include "kernels/curve/curve_key.h"

namespace meander {

// A frame is one orientation of the curve inside an axis-parallel cell. There are at most 8: 4 rotations x 2
// mirrors. Frame 0 is the root: it enters at the lower left corner, with axes a = (1, 0), b = (0, 1).
struct FrameTable {
  // 2 for Hilbert, 3 for the Peano curves; a cell has branching^2 children.
  int branching = 0;
  int frames = 0;
  // By frame, the digit (0 .. branching^2 - 1) along the curve of the child at cell x + branching * y, and
  // its inverse.
  std::array<std::array<std::uint8_t, 9>, 8> digit_of_cell{};
  std::array<std::array<std::uint8_t, 9>, 8> cell_of_digit{};
  std::array<std::array<std::uint8_t, 9>, 8> child_frame{};  // by digit
  // The corners where the curve enters and leaves the cell: bit 0 = right, bit 1 = upper.
  std::array<std::uint8_t, 8> entry{}, exit{};
};

const FrameTable& frame_table(CurveKind kind);

}  // namespace meander
