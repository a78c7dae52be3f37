// 3-D: Skilling 2004, "Programming the Hilbert curve", as a state machine. 2-D: frame tables of
// curve_frames.h. Both machines read several levels a step from tables made once.
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

// Four levels of the 2-D curve a step: the 4 + 4 cell bits in, 8 key bits and the next frame out.
struct FourLevels {
  std::array<std::array<std::uint8_t, 256>, 8> digits,
      frame;  // by frame, then by 16 x (bits of x) + bits of y
};

FourLevels make_four_levels() {
  const FrameTable& table = frame_table(CurveKind::hilbert);
  FourLevels result{};
  for (std::uint8_t start = 0; start < table.frames; ++start)
    for (unsigned x = 0; x < 16; ++x)
      for (unsigned y = 0; y < 16; ++y) {
        unsigned digits = 0;
        std::uint8_t frame = start;
        for (int level = 3; level >= 0; --level) {
          const std::uint8_t digit = table.digit_of_cell[frame][(x >> level & 1u) + 2 * (y >> level & 1u)];
          digits = digits << 2 | digit;
          frame = table.child_frame[frame][digit];
        }
        result.digits[start][16 * x + y] = static_cast<std::uint8_t>(digits);
        result.frame[start][16 * x + y] = frame;
      }
  return result;
}

std::uint64_t hilbert_key_2d(double u, double v) {
  static const FourLevels steps = make_four_levels();
  constexpr double cells = 4294967296.0;
  const auto ix = static_cast<std::uint32_t>(std::clamp(u * cells, 0.0, cells - 1.0));
  const auto iy = static_cast<std::uint32_t>(std::clamp(v * cells, 0.0, cells - 1.0));
  std::uint64_t key = 0;
  std::uint8_t frame = 0;
  for (int shift = 28; shift >= 0; shift -= 4) {
    const std::uint32_t cell = (ix >> shift & 15u) << 4 | (iy >> shift & 15u);
    key = key << 8 | steps.digits[frame][cell];
    frame = steps.frame[frame][cell];
  }
  return key;
}

// Skilling's loops work on all lower bits at once: what they do to the bits of one level depends only on
// which axes the higher levels exchanged and inverted. That is the state: where each axis now is, which are
// inverted, and the parity that his Gray code carries down.
struct HilbertState {
  std::array<std::uint8_t, 3> axis = {0, 1, 2};
  std::uint8_t inverted = 0;
  std::uint8_t parity = 0;
  friend bool operator==(const HilbertState&, const HilbertState&) = default;
};

// One level: the bits (x << 2 | y << 1 | z) of the cell in, the digit of the key out; moves the state on.
std::uint8_t next_level(HilbertState& state, std::uint8_t cell) {
  std::array<std::uint8_t, 3> bit{};
  for (std::size_t i = 0; i < 3; ++i)
    bit[i] = static_cast<std::uint8_t>((cell >> (2 - state.axis[i]) ^ state.inverted >> i) & 1);
  HilbertState next = state;
  for (std::size_t i = 0; i < 3; ++i) {
    if (bit[i]) {
      next.inverted ^= 1;
    } else if (i > 0) {
      std::swap(next.axis[0], next.axis[i]);
      const std::uint8_t first = next.inverted & 1, other = next.inverted >> i & 1;
      if (first != other) next.inverted = static_cast<std::uint8_t>(next.inverted ^ 1 ^ 1 << i);
    }
  }
  const std::uint8_t g0 = bit[0], g1 = bit[1] ^ g0, g2 = bit[2] ^ g1;
  const auto digit =
      static_cast<std::uint8_t>((g0 ^ state.parity) << 2 | (g1 ^ state.parity) << 1 | (g2 ^ state.parity));
  next.parity = state.parity ^ g2;
  state = next;
  return digit;
}

// Two levels of the 3-D curve a step: six cell bits in, six key bits and the next state out.
struct TwoLevels {
  std::vector<std::array<std::uint8_t, 64>> digits, state;
  std::array<std::uint8_t, 8> first_digit{},
      first_state{};  // a single level from the start: 21 levels are odd
};

TwoLevels make_two_levels() {
  TwoLevels result;
  std::vector<HilbertState> states = {HilbertState{}};
  const auto number = [&](const HilbertState& state) {
    const auto at = std::find(states.begin(), states.end(), state);
    if (at == states.end()) {
      states.push_back(state);
      return static_cast<std::uint8_t>(states.size() - 1);
    }
    return static_cast<std::uint8_t>(at - states.begin());
  };
  for (std::uint8_t cell = 0; cell < 8; ++cell) {
    HilbertState state;
    result.first_digit[cell] = next_level(state, cell);
    result.first_state[cell] = number(state);
  }
  for (std::size_t s = 0; s < states.size(); ++s) {
    auto& digits = result.digits.emplace_back();
    auto& next = result.state.emplace_back();
    for (std::uint8_t cells = 0; cells < 64; ++cells) {
      HilbertState state = states[s];
      const std::uint8_t high = next_level(state, cells >> 3), low = next_level(state, cells & 7);
      digits[cells] = static_cast<std::uint8_t>(high << 3 | low);
      next[cells] = number(state);
    }
  }
  return result;
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
  static const TwoLevels steps = make_two_levels();
  const std::uint64_t cells = spread_by_three(grid_coordinate(p.x)) << 2 |
                              spread_by_three(grid_coordinate(p.y)) << 1 |
                              spread_by_three(grid_coordinate(p.z));
  const std::size_t top = cells >> 60;
  std::uint64_t key = steps.first_digit[top];
  std::uint8_t state = steps.first_state[top];
  for (int shift = 54; shift >= 0; shift -= 6) {
    const std::size_t cell = cells >> shift & 63;
    key = key << 6 | steps.digits[state][cell];
    state = steps.state[state][cell];
  }
  return key;
}

}  // namespace meander
