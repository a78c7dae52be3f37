// 3-D: Skilling 2004, "Programming the Hilbert curve", as a table of his states. 2-D: frame tables of
// curve_frames.h. Both Hilbert keys take several levels a step: the levels form one chain of dependent
// look-ups, whose length is the cost.
#include "kernels/curve/curve_key.h"

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

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

// Spreads the bits of v so that a zero bit stands between any two of them.
constexpr std::uint64_t spread_by_two(std::uint64_t v) {
  v = (v | v << 16) & 0x0000FFFF0000FFFF;
  v = (v | v << 8) & 0x00FF00FF00FF00FF;
  v = (v | v << 4) & 0x0F0F0F0F0F0F0F0F;
  v = (v | v << 2) & 0x3333333333333333;
  v = (v | v << 1) & 0x5555555555555555;
  return v;
}

// For every frame and the cell bits (y, x) of four levels: eight bits of curve digits, and the frame below
// them in the bits above.
using PlaneSteps = std::array<std::array<std::uint16_t, 256>, 8>;

PlaneSteps make_plane_steps() {
  const FrameTable& table = frame_table(CurveKind::hilbert);
  PlaneSteps steps{};
  for (std::size_t start = 0; start < static_cast<std::size_t>(table.frames); ++start)
    for (std::uint32_t cells = 0; cells < 256; ++cells) {
      std::size_t frame = start;
      std::uint32_t digits = 0;
      for (int level = 3; level >= 0; --level) {
        const std::uint8_t digit = table.digit_of_cell[frame][cells >> 2 * level & 3];
        digits = digits << 2 | digit;
        frame = table.child_frame[frame][digit];
      }
      steps[start][cells] = static_cast<std::uint16_t>(frame << 8 | digits);
    }
  return steps;
}

std::uint64_t hilbert_key_2d(double u, double v) {
  static const PlaneSteps steps = make_plane_steps();
  constexpr double cells = 4294967296.0;  // 32 levels
  const auto ix = static_cast<std::uint32_t>(std::clamp(u * cells, 0.0, cells - 1.0));
  const auto iy = static_cast<std::uint32_t>(std::clamp(v * cells, 0.0, cells - 1.0));
  const std::uint64_t path = spread_by_two(iy) << 1 | spread_by_two(ix);
  std::uint64_t key = 0;
  std::size_t frame = 0;
  for (int shift = 56; shift >= 0; shift -= 8) {
    const std::uint16_t step = steps[frame][path >> shift & 0xFF];
    key = key << 8 | (step & 0xFF);
    frame = step >> 8;
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

namespace {

// What Skilling's transformation of the higher bits does to the lower ones: bit of axis i = bit of axis
// source[i] of the point, inverted where flip[i]; and the parity of his Gray code.
struct SpaceState {
  std::array<std::uint8_t, 3> source{0, 1, 2};
  std::array<bool, 3> flip{};
  bool gray = false;
  friend bool operator==(const SpaceState&, const SpaceState&) = default;
};

// The curve digit of one level (bits x, y, z of the cell, x highest), and the state below it.
std::uint32_t space_level(SpaceState& state, std::uint32_t cell) {
  std::array<bool, 3> bit;
  for (std::size_t i = 0; i < 3; ++i) bit[i] = ((cell >> (2 - state.source[i]) & 1) != 0) != state.flip[i];
  const bool gray = state.gray;
  for (std::size_t i = 0; i < 3; ++i) {
    if (bit[i]) {
      state.flip[0] = !state.flip[0];
    } else {
      std::swap(state.source[0], state.source[i]);
      std::swap(state.flip[0], state.flip[i]);
    }
  }
  bit[1] = bit[1] != bit[0];
  bit[2] = bit[2] != bit[1];
  state.gray = gray != bit[2];
  std::uint32_t digit = 0;
  for (const bool b : bit) digit = digit << 1 | static_cast<std::uint32_t>(b != gray);
  return digit;
}

// For every state that occurs and the cell bits of three levels: nine bits of curve digits, and the state
// below them in the bits above.
std::vector<std::array<std::uint16_t, 512>> make_space_steps() {
  std::vector<SpaceState> states(1);
  std::vector<std::array<std::uint16_t, 512>> steps;
  for (std::size_t s = 0; s < states.size(); ++s) {
    steps.emplace_back();
    for (std::uint32_t cells = 0; cells < 512; ++cells) {
      SpaceState state = states[s];
      std::uint32_t digits = 0;
      for (int level = 2; level >= 0; --level)
        digits = digits << 3 | space_level(state, cells >> 3 * level & 7);
      const auto found = std::find(states.begin(), states.end(), state);
      const auto number = static_cast<std::uint32_t>(found - states.begin());
      if (found == states.end()) states.push_back(state);
      steps[s][cells] = static_cast<std::uint16_t>(number << 9 | digits);
    }
  }
  return steps;
}

}  // namespace

std::uint64_t hilbert_key_3d(Vector3 p) {
  static const std::vector<std::array<std::uint16_t, 512>> steps = make_space_steps();
  const std::uint64_t path = spread_by_three(grid_coordinate(p.x)) << 2 |
                             spread_by_three(grid_coordinate(p.y)) << 1 |
                             spread_by_three(grid_coordinate(p.z));
  const auto* table = steps.data();
  std::uint64_t key = 0;
  std::size_t state = 0;
  for (int shift = 54; shift >= 0; shift -= 9) {
    const std::uint16_t step = table[state][path >> shift & 0x1FF];
    key = key << 9 | (step & 0x1FF);
    state = step >> 9;
  }
  return key;
}

}  // namespace meander
