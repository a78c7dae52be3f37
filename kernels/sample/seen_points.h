// Tells equal points apart from new ones.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace meander {

// Open-addressing set of stored points; equality is that of the float32 coordinates.
class SeenPoints {
 public:
  explicit SeenPoints(std::size_t count) : slots_(std::bit_ceil(2 * count + 1), free_slot) {}

  // True when no equal point was in the set yet; `points` holds the coordinates of all points inserted
  // before.
  bool insert(const std::vector<float>& points, std::uint32_t index) {
    const float* p = &points[3 * std::size_t{index}];
    std::uint64_t hash = std::bit_cast<std::uint32_t>(p[0]);
    hash = (hash * 0x9E3779B97F4A7C15u) ^ std::bit_cast<std::uint32_t>(p[1]);
    hash = (hash * 0x9E3779B97F4A7C15u) ^ std::bit_cast<std::uint32_t>(p[2]);
    hash *= 0x9E3779B97F4A7C15u;
    std::size_t slot = (hash ^ hash >> 32) & (slots_.size() - 1);
    for (; slots_[slot] != free_slot; slot = (slot + 1) & (slots_.size() - 1)) {
      const float* q = &points[3 * std::size_t{slots_[slot]}];
      if (p[0] == q[0] && p[1] == q[1] && p[2] == q[2]) return false;
    }
    slots_[slot] = index;
    return true;
  }

 private:
  static constexpr std::uint32_t free_slot = 0xFFFFFFFFu;
  std::vector<std::uint32_t> slots_;
};

}  // namespace meander
