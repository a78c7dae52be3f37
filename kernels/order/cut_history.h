// The cuts above a cell of balanced bisection: which side of each it lies on (docs/METHODS.md 7.7).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace meander {

// The sides of the cuts across coordinate axes, and how many there were across each. Cuts between sheets or
// groups are not among them.
struct CutHistory {
  std::uint32_t side = 0;  // bit k: the upper side of the last cut but k, of 32
  // Of the last 8 cuts across the axes other than this one, likewise; 0 where there were none.
  std::array<std::uint8_t, 3> side_across_others{};
  std::array<std::uint8_t, 3> cuts{};

  void cut(std::size_t across, bool upper) {
    const std::uint32_t bit = upper ? 1u : 0u;
    side = side << 1 | bit;
    for (std::size_t k = 0; k < 3; ++k)
      if (k != across)
        side_across_others[k] = static_cast<std::uint8_t>(std::uint32_t{side_across_others[k]} << 1 | bit);
    ++cuts[across];
  }
};

// The leaves that the lower half of a node gets, of a tree of so many shares: half of them, and of an odd
// number the one left over or not, so that halves of one leaf lie now on this side of their siblings, now on
// that. By the last but one of the other cuts, which is best for small sets; by a hash of all cuts, which is
// best for the prefixes of large ones.
inline std::uint32_t lower_leaves(std::uint32_t leaves, const CutHistory& history, std::size_t axis,
                                  std::uint32_t shares) {
  constexpr std::uint32_t small_set = 2048;
  if (shares <= small_set)
    return leaves / 2 + (leaves & std::uint32_t{history.side_across_others[axis]} >> 1 & 1u);
  std::uint32_t hash = history.side * 0x9E3779B1u ^ leaves * 0x85EBCA6Bu;
  hash = (hash ^ hash >> 15) * 0x2C1B3C6Du;
  hash = (hash ^ hash >> 12) * 0x297A2D39u;
  return leaves / 2 + (leaves & hash >> 31);
}

}  // namespace meander
