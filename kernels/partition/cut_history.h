// The cuts above a cell of balanced bisection: which side of each it lies on (docs/METHODS.md 7.7).
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

namespace meander {

// The sides of the cuts across coordinate axes, and how many there were across each. Cuts between sheets or
// groups are not among them.
struct CutHistory {
  std::uint32_t side = 0;  // bit k: the upper side of the last cut but k, of 32
  // The sides of the last 8 cuts across the axes other than this one, likewise; 0 where there were none.
  std::array<std::uint8_t, 3> side_across_others{};
  std::array<std::uint8_t, 3> cuts{};

  void cut(std::size_t across, bool upper) {
    const std::uint32_t bit = upper ? 1u : 0u;
    side = side << 1 | bit;
    for (std::size_t k = 0; k < 3; ++k)
      if (k == across)
        ++cuts[k];
      else
        side_across_others[k] = static_cast<std::uint8_t>(std::uint32_t{side_across_others[k]} << 1 | bit);
  }
};

// The leaves that the lower part of a node of 2 or more gets: the power of two nearest to half of them, the
// larger one of two; between a third and two thirds. So nearly all cells lie in nodes of 2^k leaves, which
// are cut in halves throughout: there the digits of samples (docs/METHODS.md 7.7) form a net, and the sides
// of neighbors agree.
inline std::uint32_t lower_leaves(std::uint32_t leaves) {
  const std::uint32_t power = std::bit_floor(leaves);
  return leaves < power + power / 2 ? power / 2 : power;
}

}  // namespace meander
