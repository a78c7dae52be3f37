// Positions along space-filling curves as integer keys (docs/METHODS.md 5.2).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "kernels/core/vector3.h"

namespace meander {

enum class CurveKind : std::uint8_t { hilbert, peano, peano_meander };

// Digits that a key resolves: 32 levels of 2 bits for Hilbert, 20 levels of base 9 for the Peano curves.
constexpr int curve_key_levels(CurveKind kind) { return kind == CurveKind::hilbert ? 32 : 20; }

// Rank of the cell of the finest level that holds (u, v) along the curve over [0, 1]^2. u, v are clamped to
// [0, 1). Keys of a coarser level are prefixes: key / (4^k or 9^k). Pure; 30 ns (Peano curves 100 ns).
std::uint64_t curve_key(CurveKind kind, double u, double v);

// Rank of the cell of the 2^21 grid that holds p along the 3-D Hilbert curve over [-1, 1]^3 (63 bits);
// clamped. Skilling 2004, "Programming the Hilbert curve". Pure; about 16 ns.
std::uint64_t hilbert_key_3d(Vector3 p);

// Points in memory: x, y, z of the first at `first`, those of the next `stride` floats on.
struct StridedPoints {
  const float* first;
  std::size_t stride;
};
// The same of many points, one key each. Pure; about 12 ns a key, because the steps of several keys overlap.
void hilbert_keys_3d(const StridedPoints& points, std::span<std::uint64_t> keys);

// Ranks of the cells of the 2^12 grid (36 bits): the leading bits of the former but where rounding to float
// moves a point into the next cell. Pure; about 6 ns a key.
inline constexpr int coarse_key_bits = 36;
void coarse_hilbert_keys_3d(const StridedPoints& points, std::span<std::uint64_t> keys);

}  // namespace meander
