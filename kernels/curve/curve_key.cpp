// The 3-D curve follows Skilling 2004, "Programming the Hilbert curve", as a state machine; the 2-D curves
// use the frame tables of curve_frames.h. Both process several levels a step, by tables built once.
#include "kernels/curve/curve_key.h"

#include <algorithm>
#include <array>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "kernels/curve/curve_frames.h"

namespace meander {

namespace {

constexpr int axis_bits_3d = 21;

// Spreads the low 21 bits of v with two zero bits between any two of them.
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
  return static_cast<std::uint32_t>(static_cast<std::int32_t>(std::clamp(scaled, 0.0, cells - 1.0)));
}

// Four levels of the 2-D curve a step: the 4 + 4 cell bits in, 8 key bits and the next frame out. Indexed by
// frame, then by 16 x (bits of x) + bits of y.
struct FourLevels {
  std::array<std::array<std::uint8_t, 256>, 8> digits, frame;
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

// Skilling's loops work on all lower bits at once: their effect on the bits of one level depends only on
// which axes the higher levels exchanged and inverted. That is the state: where each axis now is, which axes
// are inverted, and the parity that his Gray code carries down.
struct HilbertState {
  std::array<std::uint8_t, 3> axis = {0, 1, 2};
  std::uint8_t inverted = 0;
  std::uint8_t parity = 0;
  friend bool operator==(const HilbertState&, const HilbertState&) = default;
};

// Takes the bits (x << 2 | y << 1 | z) of the cell of one level, moves the state on and returns the digit of
// the key.
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

// The 3-D curve as a finite machine: by state and cell, the digit and the next state.
struct HilbertMachine {
  struct Step {
    std::uint8_t digit;
    std::uint8_t next;
  };
  std::vector<std::array<Step, 8>> states;  // the start first
};

HilbertMachine make_hilbert_machine() {
  HilbertMachine machine;
  std::vector<HilbertState> states = {HilbertState{}};
  for (std::size_t s = 0; s < states.size(); ++s) {
    auto& steps = machine.states.emplace_back();
    for (std::uint8_t cell = 0; cell < 8; ++cell) {
      HilbertState next = states[s];
      steps[cell].digit = next_level(next, cell);
      const auto at = std::find(states.begin(), states.end(), next);
      steps[cell].next = static_cast<std::uint8_t>(at - states.begin());
      if (at == states.end()) states.push_back(next);
    }
  }
  return machine;
}

// The minimal equivalent machine: 24 of 48 states (Moore 1956, partition refinement).
HilbertMachine smallest_machine(const HilbertMachine& machine) {
  const std::size_t count = machine.states.size();
  std::vector<std::uint8_t> group(count, 0);
  for (std::size_t groups = 1;;) {
    std::map<std::string, std::uint8_t> numbers;
    std::vector<std::uint8_t> refined(count);
    for (std::size_t s = 0; s < count; ++s) {
      std::string signature(1, static_cast<char>(group[s]));
      for (const HilbertMachine::Step step : machine.states[s]) {
        signature += static_cast<char>(step.digit);
        signature += static_cast<char>(group[step.next]);
      }
      refined[s] = numbers.emplace(signature, static_cast<std::uint8_t>(numbers.size())).first->second;
    }
    group = refined;
    if (numbers.size() == groups) break;
    groups = numbers.size();
  }
  HilbertMachine smallest;
  smallest.states.resize(1 + *std::max_element(group.begin(), group.end()));
  for (std::size_t s = 0; s < count; ++s) {
    smallest.states[group[s]] = machine.states[s];
    for (HilbertMachine::Step& step : smallest.states[group[s]]) step.next = group[step.next];
  }
  return smallest;
}

// Three levels a step: nine cell bits in; nine key bits and the next state, 512 x state + bits, out of one
// load, because the steps of a key wait for each other.
std::vector<std::array<std::uint16_t, 512>> make_three_levels() {
  const HilbertMachine machine = smallest_machine(make_hilbert_machine());
  std::vector<std::array<std::uint16_t, 512>> steps(machine.states.size());
  for (std::size_t s = 0; s < steps.size(); ++s)
    for (unsigned cells = 0; cells < 512; ++cells) {
      unsigned digits = 0;
      std::size_t state = s;
      for (int level = 6; level >= 0; level -= 3) {
        const HilbertMachine::Step step = machine.states[state][cells >> level & 7u];
        digits = digits << 3 | step.digit;
        state = step.next;
      }
      steps[s][cells] = static_cast<std::uint16_t>(state << 9 | digits);
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

namespace {

// Seven bits of x, of y and of z, with two zero bits between any two, at their positions in the interleaved
// sequence.
struct SpreadBits {
  std::array<std::uint32_t, 128> x, y, z;
};
constexpr SpreadBits spread_bits = [] {
  SpreadBits bits{};
  for (std::uint32_t v = 0; v < 128; ++v) {
    bits.z[v] = static_cast<std::uint32_t>(spread_by_three(v));
    bits.y[v] = bits.z[v] << 1;
    bits.x[v] = bits.z[v] << 2;
  }
  return bits;
}();

const std::vector<std::array<std::uint16_t, 512>>& three_level_steps() {
  static const std::vector<std::array<std::uint16_t, 512>> steps = make_three_levels();
  return steps;
}

using GridCell = std::array<std::uint32_t, 3>;

// The rank along the curve of a cell of the 2^levels grid; levels is a multiple of 3.
template <int levels>
class CellKeys {
 public:
  std::uint64_t operator()(const GridCell& cell) const {
    constexpr int chunk = levels % 7 == 0 ? 7 : 6, digits = 3 * chunk;
    static_assert(levels % chunk == 0 && levels % 3 == 0);
    constexpr std::uint32_t mask = (1u << chunk) - 1;
    std::uint64_t cells = 0;
    for (int shift = levels - chunk; shift >= 0; shift -= chunk)
      cells = cells << digits | spread_bits.x[cell[0] >> shift & mask] |
              spread_bits.y[cell[1] >> shift & mask] | spread_bits.z[cell[2] >> shift & mask];
    std::uint64_t key = 0;
    std::uint32_t at = 0;
    for (int shift = 3 * levels - 9; shift >= 0; shift -= 9) {
      at = step_[(at & ~511u) | (cells >> shift & 511)];
      key = key << 9 | (at & 511u);
    }
    return key;
  }

 private:
  const std::uint16_t* step_ = three_level_steps().front().data();
};

}  // namespace

std::uint64_t hilbert_key_3d(Vector3 p) {
  return CellKeys<axis_bits_3d>()({grid_coordinate(p.x), grid_coordinate(p.y), grid_coordinate(p.z)});
}

void hilbert_keys_3d(const StridedPoints& points, std::span<std::uint64_t> keys) {
  const CellKeys<axis_bits_3d> key_of;
  const float* p = points.first;
  for (std::uint64_t& key : keys) {
    key = key_of({grid_coordinate(static_cast<double>(p[0])), grid_coordinate(static_cast<double>(p[1])),
                  grid_coordinate(static_cast<double>(p[2]))});
    p += points.stride;
  }
}

void coarse_hilbert_keys_3d(const StridedPoints& points, std::span<std::uint64_t> keys) {
  constexpr int levels = coarse_key_bits / 3;
  const CellKeys<levels> key_of;
  const auto coordinate = [](float w) {
    constexpr float cells = 1 << levels;
    return static_cast<std::uint32_t>(
        static_cast<std::int32_t>(std::clamp((w + 1.0f) * (0.5f * cells), 0.0f, cells - 1.0f)));
  };
  const float* p = points.first;
  for (std::uint64_t& key : keys) {
    key = key_of({coordinate(p[0]), coordinate(p[1]), coordinate(p[2])});
    p += points.stride;
  }
}

}  // namespace meander
