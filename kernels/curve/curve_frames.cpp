// Production rules (origin, axes) of Hilbert, Peano and Peano-meander, and the tables that are generated from
// them once.
#include "kernels/curve/curve_frames.h"

#include <span>
#include <vector>

namespace meander {

namespace {

// Child k of a cell {p + s a + t b}: origin p + (ox a + oy b) / branching, axes (a1 a + a2 b, b1 a + b2 b) /
// branching.
struct Production {
  int ox, oy, a1, a2, b1, b2;
};

constexpr std::array<Production, 4> hilbert_rules = {
    {{0, 0, 0, 1, 1, 0}, {0, 1, 1, 0, 0, 1}, {1, 1, 1, 0, 0, 1}, {2, 1, 0, -1, -1, 0}}};
constexpr std::array<Production, 9> meander_rules = {{{0, 0, 0, 1, 1, 0},
                                                      {0, 1, 0, 1, 1, 0},
                                                      {0, 2, 1, 0, 0, 1},
                                                      {1, 2, 1, 0, 0, 1},
                                                      {2, 2, 1, 0, 0, 1},
                                                      {3, 2, -1, 0, 0, -1},
                                                      {2, 2, 0, -1, -1, 0},
                                                      {2, 1, 0, -1, -1, 0},
                                                      {2, 0, 1, 0, 0, 1}}};

constexpr std::array<Production, 9> make_peano_rules() {
  constexpr int cells[9][2] = {{0, 0}, {0, 1}, {0, 2}, {1, 2}, {1, 1}, {1, 0}, {2, 0}, {2, 1}, {2, 2}};
  std::array<Production, 9> rules{};
  for (std::size_t k = 0; k < 9; ++k) {
    const int i = cells[k][0], j = cells[k][1];
    rules[k] = {i + j % 2, j + i % 2, j % 2 ? -1 : 1, 0, 0, i % 2 ? -1 : 1};
  }
  return rules;
}
constexpr std::array<Production, 9> peano_rules = make_peano_rules();

// Axes a and b of a frame as unit vectors along the coordinate axes; the cell itself is always the unit
// square.
struct Frame {
  int ax, ay, bx, by;
  friend bool operator==(const Frame&, const Frame&) = default;
};

FrameTable generate(int branching, std::span<const Production> rules) {
  FrameTable table;
  table.branching = branching;
  std::vector<Frame> frames = {{1, 0, 0, 1}};
  for (std::size_t f = 0; f < frames.size(); ++f) {
    const Frame frame = frames[f];
    // The origin is the corner from which a and b point into the cell (in units of one child).
    const int px = frame.ax + frame.bx < 0 ? branching : 0;
    const int py = frame.ay + frame.by < 0 ? branching : 0;
    for (std::size_t k = 0; k < rules.size(); ++k) {
      const Production& r = rules[k];
      const Frame child = {r.a1 * frame.ax + r.a2 * frame.bx, r.a1 * frame.ay + r.a2 * frame.by,
                           r.b1 * frame.ax + r.b2 * frame.bx, r.b1 * frame.ay + r.b2 * frame.by};
      const int x = px + r.ox * frame.ax + r.oy * frame.bx + (child.ax + child.bx < 0 ? -1 : 0);
      const int y = py + r.ox * frame.ay + r.oy * frame.by + (child.ay + child.by < 0 ? -1 : 0);
      std::size_t number = 0;
      while (number < frames.size() && !(frames[number] == child)) ++number;
      if (number == frames.size()) frames.push_back(child);
      const auto cell = static_cast<std::uint8_t>(x + branching * y);
      table.digit_of_cell[f][cell] = static_cast<std::uint8_t>(k);
      table.cell_of_digit[f][k] = cell;
      table.child_frame[f][k] = static_cast<std::uint8_t>(number);
    }
    const auto corner = [](int x, int y) {
      return static_cast<std::uint8_t>((x > 0 ? 1 : 0) | (y > 0 ? 2 : 0));
    };
    table.entry[f] = corner(px, py);
    // The Peano curve leaves at the opposite corner, the others at p + a.
    const bool diagonal = rules.size() == 9 && rules[1].a1 == -1;
    table.exit[f] = corner(px + branching * (frame.ax + (diagonal ? frame.bx : 0)),
                           py + branching * (frame.ay + (diagonal ? frame.by : 0)));
  }
  table.frames = static_cast<int>(frames.size());
  return table;
}

}  // namespace

const FrameTable& frame_table(CurveKind kind) {
  static const FrameTable hilbert = generate(2, hilbert_rules);
  static const FrameTable peano = generate(3, peano_rules);
  static const FrameTable meander = generate(3, meander_rules);
  switch (kind) {
    case CurveKind::hilbert:
      return hilbert;
    case CurveKind::peano:
      return peano;
    case CurveKind::peano_meander:
      break;
  }
  return meander;
}

}  // namespace meander
