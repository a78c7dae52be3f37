#include "kernels/sample/stratum_grid.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace meander {

namespace {

constexpr double finest_cell = 0x1p-50;

// The key of a cell ends in 6 bits for its place in the brick.
std::uint64_t bit_of(std::uint64_t cell) { return std::uint64_t{1} << (cell & 63); }

// The cells of a brick that lie from a to b along one axis.
constexpr std::uint64_t slab(int a, int b, int axis) {
  std::uint64_t cells = 0;
  for (int bit = 0; bit < 64; ++bit) {
    const int at = bit >> (2 * axis) & 3;
    if (at >= a && at <= b) cells |= std::uint64_t{1} << bit;
  }
  return cells;
}
constexpr auto slabs = [] {
  std::array<std::array<std::array<std::uint64_t, 4>, 4>, 3> all{};
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (std::size_t a = 0; a < 4; ++a)
      for (std::size_t b = 0; b < 4; ++b)
        all[axis][a][b] = slab(static_cast<int>(a), static_cast<int>(b), static_cast<int>(axis));
  return all;
}();

}  // namespace

std::uint64_t StratumGrid::brick_key(std::int64_t x, std::int64_t y, std::int64_t z, std::size_t level) {
  // Level, 17 bits each of z, y and x. Bricks 2^17 apart have the same key: what is found there is too far
  // away, and is not kept.
  const auto bits = [](std::int64_t c) { return static_cast<std::uint64_t>(c) & 0x1FFFF; };
  return static_cast<std::uint64_t>(level) << 51 | bits(z) << 34 | bits(y) << 17 | bits(x);
}

// The cells of a brick along one axis.
std::uint64_t StratumGrid::cells_between(std::int64_t first, std::int64_t last, std::size_t axis) {
  return slabs[axis][static_cast<std::size_t>(first)][static_cast<std::size_t>(last)];
}

StratumGrid::StratumGrid(double cell) : bricks_(64) {
  for (std::size_t level = 0; level <= most_level; ++level) {
    cell_[level] = std::ldexp(std::max(cell, finest_cell), static_cast<int>(level));
    per_unit_[level] = 1 / cell_[level];
  }
}

std::size_t StratumGrid::slot_of(std::uint64_t key) const {
  const std::uint64_t hash = key * 0x9E3779B97F4A7C15u;
  std::size_t slot = (hash ^ hash >> 32) & (bricks_.size() - 1);
  while (bricks_[slot].occupied != 0 && bricks_[slot].key != key) slot = (slot + 1) & (bricks_.size() - 1);
  return slot;
}

void StratumGrid::grow() {
  std::vector<Brick> old(2 * bricks_.size());
  old.swap(bricks_);
  for (const Brick& brick : old)
    if (brick.occupied != 0) bricks_[slot_of(brick.key)] = brick;
}

std::int64_t StratumGrid::cell_along(double coordinate, std::size_t level) const {
  return static_cast<std::int64_t>(std::floor(coordinate * per_unit_[level]));
}

StratumGrid::CellBox StratumGrid::cells_around(const PointBox& middle, double around,
                                               std::size_t level) const {
  CellBox cells;
  for (std::size_t k = 0; k < 3; ++k) {
    cells.low[k] = cell_along(middle.low[k] - around, level);
    cells.high[k] = cell_along(middle.high[k] + around, level);
  }
  return cells;
}

void StratumGrid::add(const PointBox& box, float around) {
  double extent = static_cast<double>(around);
  std::array<double, 3> center;
  for (std::size_t k = 0; k < 3; ++k) {
    extent = std::max(extent, double(box.high[k]) - double(box.low[k]));
    center[k] = 0.5 * (double(box.low[k]) + double(box.high[k]));
  }
  std::size_t level = 0;
  while (level < most_level && extent > 2 * half_box * cell_[level]) ++level;
  const std::int64_t x = cell_along(center[0], level), y = cell_along(center[1], level),
                     z = cell_along(center[2], level);
  const std::uint64_t key = brick_key(x >> 2, y >> 2, z >> 2, level);
  const std::uint64_t cell = key << 6 | static_cast<std::uint64_t>((z & 3) << 4 | (y & 3) << 2 | (x & 3));
  levels_ |= std::uint64_t{1} << level;
  std::size_t slot = slot_of(key);
  if (bricks_[slot].occupied == 0) {
    if (2 * ++brick_count_ > bricks_.size()) {
      grow();
      slot = slot_of(key);
    }
    bricks_[slot].key = key;
  }
  bricks_[slot].occupied |= bit_of(cell);
  cell_of_.push_back(cell);
}

void StratumGrid::build() {
  std::uint32_t cells = 0;
  for (Brick& brick : bricks_) {
    brick.first = cells;
    cells += static_cast<std::uint32_t>(std::popcount(brick.occupied));
  }
  const auto number_of = [&](std::uint64_t cell) {
    const Brick& brick = bricks_[slot_of(cell >> 6)];
    return brick.first + static_cast<std::uint32_t>(std::popcount(brick.occupied & (bit_of(cell) - 1)));
  };
  // begin_[c + 1] is where cell c begins while it is filled, then where it ends.
  begin_.assign(std::size_t{cells} + 2, 0);
  for (std::uint64_t& cell : cell_of_) {
    cell = number_of(cell);
    ++begin_[cell + 2];
  }
  for (std::size_t c = 2; c < begin_.size(); ++c) begin_[c] += begin_[c - 1];
  strata_.resize(cell_of_.size());
  for (std::uint32_t stratum = 0; stratum < cell_of_.size(); ++stratum)
    strata_[begin_[cell_of_[stratum] + 1]++] = stratum;
  cell_of_ = {};
}

}  // namespace meander
