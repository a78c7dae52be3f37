// 3-D: Skilling 2004, "Programming the Hilbert curve". 2-D: frame tables of curve_frames.h.
#include "kernels/curve/curve_key.h"

#include <algorithm>
#include <array>

#include "kernels/curve/curve_frames.h"

namespace meander {

namespace {

constexpr int axis_bits_3d = 21;

// Spreads the low 21 bits of v so that two zero bits stand between any two of them.
constexpr std::uint64_t spread_by_three(std::uint64_t v) {
  v &= 0x1FFFFF;
  v = (v | v << 32) & 0x1F00000000FFFF;
  v = (v | v << 16) & 0x1F0000FF0000FF;
  v = (v | v << 8) & 0x100F00F00F00F00F;
  v = (v | v << 4) & 0x10C30C30C30C30C3;
  v = (v | v << 2) & 0x1249249249249249;
  return v;
}

std::uint32_t grid_coordinate(double w) {
  constexpr double cells = 1 << axis_bits_3d;
  const double scaled = (w + 1.0) * 0.5 * cells;
  return static_cast<std::uint32_t>(std::clamp(scaled, 0.0, cells - 1.0));
}

// Binary digits of the cell, one curve digit a level, by the orientation table.
std::uint64_t hilbert_key_2d(double u, double v) {
  constexpr int levels = 32;
  constexpr double cells = 4294967296.0;
  const auto ix = static_cast<std::uint32_t>(std::clamp(u * cells, 0.0, cells - 1.0));
  const auto iy = static_cast<std::uint32_t>(std::clamp(v * cells, 0.0, cells - 1.0));
  const FrameTable& table = frame_table(CurveKind::hilbert);
  std::uint64_t key = 0;
  std::uint8_t frame = 0;
  for (int level = levels - 1; level >= 0; --level) {
    const std::uint32_t cell = (ix >> level & 1u) + 2 * (iy >> level & 1u);
    const std::uint8_t digit = table.digit_of_cell[frame][cell];
    key = key << 2 | digit;
    frame = table.child_frame[frame][digit];
  }
  return key;
}

std::uint64_t base_three_key(CurveKind kind, double u, double v) {
  constexpr int levels = 20;
  constexpr double cells = 3486784401.0;  // 3^20
  auto ix = static_cast<std::uint32_t>(std::clamp(u * cells, 0.0, cells - 1.0));
  auto iy = static_cast<std::uint32_t>(std::clamp(v * cells, 0.0, cells - 1.0));
  std::array<std::uint8_t, levels> x{}, y{};
  for (int level = levels - 1; level >= 0; --level) {
    x[static_cast<std::size_t>(level)] = static_cast<std::uint8_t>(ix % 3);
    y[static_cast<std::size_t>(level)] = static_cast<std::uint8_t>(iy % 3);
    ix /= 3;
    iy /= 3;
  }
  const FrameTable& table = frame_table(kind);
  std::uint64_t key = 0;
  std::uint8_t frame = 0;
  for (std::size_t level = 0; level < levels; ++level) {
    const std::uint8_t digit = table.digit_of_cell[frame][x[level] + 3u * y[level]];
    key = key * 9 + digit;
    frame = table.child_frame[frame][digit];
  }
  return key;
}

}  // namespace

std::uint64_t curve_key(CurveKind kind, double u, double v) {
  return kind == CurveKind::hilbert ? hilbert_key_2d(u, v) : base_three_key(kind, u, v);
}

std::uint64_t hilbert_key_3d(Vector3 p) {
  std::array<std::uint32_t, 3> axis = {grid_coordinate(p.x), grid_coordinate(p.y), grid_coordinate(p.z)};
  constexpr std::uint32_t top = 1u << (axis_bits_3d - 1);
  for (std::uint32_t bit = top; bit > 1; bit >>= 1) {
    const std::uint32_t low = bit - 1;
    for (std::uint32_t& a : axis) {
      if (a & bit) {
        axis[0] ^= low;
      } else {
        const std::uint32_t swap = (axis[0] ^ a) & low;
        axis[0] ^= swap;
        a ^= swap;
      }
    }
  }
  axis[1] ^= axis[0];
  axis[2] ^= axis[1];
  std::uint32_t gray = 0;
  for (std::uint32_t bit = top; bit > 1; bit >>= 1)
    if (axis[2] & bit) gray ^= bit - 1;
  for (std::uint32_t& a : axis) a ^= gray;
  return spread_by_three(axis[0]) << 2 | spread_by_three(axis[1]) << 1 | spread_by_three(axis[2]);
}

}  // namespace meander
