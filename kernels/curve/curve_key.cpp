// 3-D: Skilling 2004, "Programming the Hilbert curve". 2-D: frame tables of curve_frames.h.
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

// Spreads the 32 bits of v so that one zero bit stands between any two of them.
constexpr std::uint64_t spread_by_two(std::uint64_t v) {
  v = (v | v << 16) & 0x0000FFFF0000FFFF;
  v = (v | v << 8) & 0x00FF00FF00FF00FF;
  v = (v | v << 4) & 0x0F0F0F0F0F0F0F0F;
  v = (v | v << 2) & 0x3333333333333333;
  v = (v | v << 1) & 0x5555555555555555;
  return v;
}

std::uint32_t grid_coordinate(double w) {
  constexpr double cells = 1 << axis_bits_3d;
  const double scaled = (w + 1.0) * 0.5 * cells;
  return static_cast<std::uint32_t>(std::clamp(scaled, 0.0, cells - 1.0));
}

// Several levels of a curve at once: entry[frame][cells of those levels, interleaved, coarsest first] holds
// the digits in the low bits and the frame below them in the high byte. One dependent load a step instead of
// two a level.
template <int bits, int frames>
using StepTable = std::array<std::array<std::uint16_t, std::size_t{1} << bits>, frames>;

constexpr int hilbert_step = 4;  // levels: 8 bits of interleaved cells

StepTable<2 * hilbert_step, 8> make_hilbert_steps() {
  const FrameTable& table = frame_table(CurveKind::hilbert);
  StepTable<2 * hilbert_step, 8> steps{};
  for (std::size_t start = 0; start < static_cast<std::size_t>(table.frames); ++start)
    for (std::size_t cells = 0; cells < steps[start].size(); ++cells) {
      std::size_t frame = start, digits = 0;
      for (int level = hilbert_step - 1; level >= 0; --level) {
        const std::uint8_t digit = table.digit_of_cell[frame][cells >> (2 * level) & 3u];
        digits = digits << 2 | digit;
        frame = table.child_frame[frame][digit];
      }
      steps[start][cells] = static_cast<std::uint16_t>(frame << 8 | digits);
    }
  return steps;
}

std::uint64_t hilbert_key_2d(double u, double v) {
  static const StepTable<2 * hilbert_step, 8> steps = make_hilbert_steps();
  constexpr double cells = 4294967296.0;
  const auto ix = static_cast<std::uint32_t>(std::clamp(u * cells, 0.0, cells - 1.0));
  const auto iy = static_cast<std::uint32_t>(std::clamp(v * cells, 0.0, cells - 1.0));
  const std::uint64_t interleaved = spread_by_two(ix) | spread_by_two(iy) << 1;
  std::uint64_t key = 0;
  std::size_t frame = 0;
  for (int shift = 56; shift >= 0; shift -= 8) {
    const std::uint16_t entry = steps[frame][interleaved >> shift & 0xFF];
    key = key << 8 | (entry & 0xFFu);
    frame = entry >> 8;
  }
  return key;
}

// Skilling's transform as an automaton. What happens to the lower bits of a point is a permutation and a
// reflection of its axes, and one more bit for his Gray code: at most 6 x 8 x 2 states.
struct State3d {
  std::array<std::uint8_t, 3> axis = {0, 1, 2};  // axis[i]: the point's axis that now stands i-th
  std::array<std::uint8_t, 3> flip = {0, 0, 0};  // 1 where its bits are inverted
  std::uint8_t gray = 0;
  friend bool operator==(const State3d&, const State3d&) = default;
};

// Takes the cell of one level (bit 0 = x, 1 = y, 2 = z), moves the state on and returns the octal digit.
std::size_t advance(State3d& state, std::size_t cell) {
  std::array<std::uint8_t, 3> bit{};
  for (std::size_t i = 0; i < 3; ++i)
    bit[i] = static_cast<std::uint8_t>((cell >> state.axis[i] & 1u) ^ state.flip[i]);
  State3d next = state;
  for (std::size_t i = 0; i < 3; ++i) {
    if (bit[i] != 0) {
      next.flip[0] ^= 1;
    } else {
      std::swap(next.axis[0], next.axis[i]);
      std::swap(next.flip[0], next.flip[i]);
    }
  }
  const std::size_t first = bit[0], second = first ^ bit[1], third = second ^ bit[2];
  const std::size_t digit = (first << 2 | second << 1 | third) ^ (state.gray != 0 ? 7u : 0u);
  next.gray = static_cast<std::uint8_t>(state.gray ^ third);
  state = next;
  return digit;
}

constexpr int most_states_3d = 96;
constexpr int step_3d = 3;  // levels: 9 bits of interleaved cells

StepTable<3 * step_3d, most_states_3d> make_steps_3d() {
  StepTable<3 * step_3d, most_states_3d> steps{};
  std::vector<State3d> states = {State3d{}};
  for (std::size_t start = 0; start < states.size(); ++start)
    for (std::size_t cells = 0; cells < steps[start].size(); ++cells) {
      State3d state = states[start];
      std::size_t digits = 0;
      for (int level = step_3d - 1; level >= 0; --level)
        digits = digits << 3 | advance(state, cells >> (3 * level) & 7u);
      const auto found = std::find(states.begin(), states.end(), state);
      const auto number = static_cast<std::size_t>(found - states.begin());
      if (found == states.end()) states.push_back(state);
      steps[start][cells] = static_cast<std::uint16_t>(number << 9 | digits);
    }
  return steps;
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
  static const StepTable<3 * step_3d, most_states_3d> steps = make_steps_3d();
  const std::uint64_t interleaved = spread_by_three(grid_coordinate(p.x)) |
                                    spread_by_three(grid_coordinate(p.y)) << 1 |
                                    spread_by_three(grid_coordinate(p.z)) << 2;
  std::uint64_t key = 0;
  std::size_t state = 0;
  for (int shift = 3 * (axis_bits_3d - step_3d); shift >= 0; shift -= 3 * step_3d) {
    const std::uint16_t entry = steps[state][interleaved >> shift & 0x1FF];
    key = key << 9 | (entry & 0x1FFu);
    state = entry >> 9;
  }
  return key;
}

}  // namespace meander
