// Points of space-filling curves by position: the inverse of curve_key (docs/METHODS.md 5).
#pragma once

#include <cstdint>

#include "kernels/curve/curve_key.h"

namespace meander {

struct CurvePoint {
  double u = 0, v = 0;
};

// Center of the cell of rank `rank` among the 4^level (Hilbert) or 9^level (Peano curves) cells of a level
// along the curve over [0, 1]^2. level: 0 .. curve_key_levels(kind); rank must be below the number of cells
// (higher digits are ignored). Exact for Hilbert up to level 31, rounded beyond. Pure; O(level).
CurvePoint curve_cell_center(CurveKind kind, std::uint64_t rank, int level);

// The continuous curve H(t), t clamped to [0, 1): the center of the cell that holds t at level 26 (Hilbert)
// or 16 (Peano curves), as far as the 53 bits of t reach. So curve_key(kind, H(t)), cut to that level, is
// floor(t 4^26) or floor(t 9^16). Measure-preserving: uniform t gives uniform points. Pure.
CurvePoint curve_point(CurveKind kind, double t);

}  // namespace meander
