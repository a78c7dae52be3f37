// Positions along space-filling curves as integer keys (docs/METHODS.md 5.2).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "kernels/core/vector3.h"

namespace meander {

enum class CurveKind : std::uint8_t { hilbert, peano, peano_meander };

// The levels that a key resolves: 32 of 2 bits for Hilbert, 20 of base 9 for the Peano curves.
constexpr int curve_key_levels(CurveKind kind) { return kind == CurveKind::hilbert ? 32 : 20; }

// Rank along the curve over [0, 1]^2 of the finest cell that holds (u, v), which are clamped to [0, 1). Keys
// of a coarser level are prefixes: key / (4^k or 9^k). Pure; O(levels).
std::uint64_t curve_key(CurveKind kind, double u, double v);

// Rank along the 3-D Hilbert curve over [-1, 1]^3 of the cell of the 2^21 grid that holds p, clamped (63
// bits). Skilling 2004, "Programming the Hilbert curve". Pure.
std::uint64_t hilbert_key_3d(Vector3 p);

// Points in memory: x, y, z of the first at `first`, those of the next point `stride` floats on.
struct StridedPoints {
  const float* first;
  std::size_t stride;
};
// The same for many points, one key each. Pure; cheaper than single keys, because the steps of several keys
// overlap.
void hilbert_keys_3d(const StridedPoints& points, std::span<std::uint64_t> keys);

// Ranks of the cells of the 2^12 grid (36 bits). They are the leading bits of hilbert_keys_3d, except where
// rounding to float moves a point into the next cell. Pure; half the cost.
inline constexpr int coarse_key_bits = 36;
void coarse_hilbert_keys_3d(const StridedPoints& points, std::span<std::uint64_t> keys);

}  // namespace meander
