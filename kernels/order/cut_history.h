// The cuts above a cell of balanced bisection: which side of each it lies on (docs/METHODS.md 7.7).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace meander {

// The last 16 cuts across coordinate axes, and how many there were across each. Cuts between sheets or groups
// are not among them.
struct CutHistory {
  std::uint32_t side = 0;            // bit k: the upper side of the last cut but k
  std::uint32_t axis = 0xFFFFFFFFu;  // 2 bits a cut, likewise; 3: no such cut
  std::array<std::uint8_t, 3> cuts{};

  static constexpr int remembered = 16;

  void cut(std::size_t across, bool upper) {
    side = side << 1 | (upper ? 1u : 0u);
    axis = axis << 2 | static_cast<std::uint32_t>(across);
    ++cuts[across];
  }
  // The sides of the cuts across the other two axes, the last one in bit 0.
  std::uint32_t sides_across_others(std::size_t than) const {
    std::uint32_t sides = 0;
    for (int k = remembered - 1; k >= 0; --k) {
      const std::uint32_t across = axis >> (2 * k) & 3u;
      if (across != than && across != 3u) sides = sides << 1 | (side >> k & 1u);
    }
    return sides;
  }
};

// The leaves that the lower half of a node gets, of a tree of so many shares: half of them, and of an odd
// number the one left over or not, so that halves of one leaf lie now on this side of their siblings, now on
// that. By the last but one of the other cuts, which is best for small sets; by a hash of all cuts, which is
// best for the prefixes of large ones.
inline std::uint32_t lower_leaves(std::uint32_t leaves, const CutHistory& history, std::size_t axis,
                                  std::uint32_t shares) {
  constexpr std::uint32_t small_set = 2048;
  if (shares <= small_set) return leaves / 2 + (leaves & history.sides_across_others(axis) >> 1 & 1u);
  std::uint32_t hash = history.side * 0x9E3779B1u ^ leaves * 0x85EBCA6Bu;
  hash = (hash ^ hash >> 15) * 0x2C1B3C6Du;
  hash = (hash ^ hash >> 12) * 0x297A2D39u;
  return leaves / 2 + (leaves & hash >> 31);
}

}  // namespace meander
