// What the tests of the curves share.
#pragma once

#include <array>
#include <cstdint>

#include "kernels/curve/curve_tree.h"

namespace meander::test {

inline constexpr std::array curve_kinds = {CurveKind::hilbert, CurveKind::peano, CurveKind::peano_meander};

// Skilling 2004, the loops of the paper (axes to transposed index), then the bits interleaved one by one.
inline std::uint64_t skilling_key(std::array<std::uint32_t, 3> axis) {
  constexpr std::uint32_t top = 1u << 20;
  for (std::uint32_t bit = top; bit > 1; bit >>= 1)
    for (std::uint32_t& a : axis) {
      if ((a & bit) != 0) {
        axis[0] ^= bit - 1;
      } else {
        const std::uint32_t swap = (axis[0] ^ a) & (bit - 1);
        axis[0] ^= swap;
        a ^= swap;
      }
    }
  axis[1] ^= axis[0];
  axis[2] ^= axis[1];
  std::uint32_t gray = 0;
  for (std::uint32_t bit = top; bit > 1; bit >>= 1)
    if ((axis[2] & bit) != 0) gray ^= bit - 1;
  std::uint64_t key = 0;
  for (int level = 20; level >= 0; --level)
    for (const std::uint32_t a : axis) key = key << 1 | ((a ^ gray) >> level & 1);
  return key;
}

}  // namespace meander::test
