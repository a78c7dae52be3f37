// Finds the strata near another one.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace meander {

struct PointBox {
  std::array<float, 3> low, high;
};

// Boxes of strata in a grid of cells in space, each in the cell of its center. A grid of level l has cells
// 2^l times as large as those of level 0; a box lies in the first one whose cells are at least two thirds as
// large as the box, and as what its stratum looks at around it. Cells are kept by bricks of 4 x 4 x 4.
class StratumGrid {
 public:
  // cell: edge of the cells of level 0, > 0, in units of the points, which lie in [-4, 4].
  explicit StratumGrid(double cell);

  // Boxes are added in the order of their strata, 0, 1, ..., then the grid is built. around: the distance in
  // which the stratum will look.
  void add(const PointBox& box, float around);
  void build();

  struct Scratch {
    std::vector<std::uint32_t> slots = std::vector<std::uint32_t>(1024, 0), used;
  };
  // The strata, at most `limit` (<= 512), whose boxes may come within `distance` of `box`, and that
  // keep(stratum, box) says yes to; each once, in a fixed order. torn: the same for each of the places (rows
  // of coordinates) in the box, and for these alone. Of much finer strata only those near the places are
  // found: the number of others in the box has no bound. O(cells + strata) around.
  template <class Keep>
  void find(std::span<const float> x, std::span<const float> y, std::span<const float> z, const PointBox& box,
            bool torn, float distance, std::size_t limit, const Keep& keep, Scratch& scratch,
            std::vector<std::uint32_t>& found) const;

  // The same for boxes of several strata at once: all strata whose boxes may come within `distance` of `box`
  // and that keep(stratum) says yes to. False where there are more than `limit` or some much finer ones, of
  // which only those near places are to be found.
  template <class Keep>
  bool find_around(const PointBox& box, float distance, std::size_t limit, const Keep& keep,
                   std::vector<std::uint32_t>& found) const;

 private:
  struct Brick {
    std::uint64_t key = 0;
    std::uint64_t occupied = 0;  // 0: the slot is free
    std::uint32_t first = 0;     // of its cells in begin_
  };
  struct CellBox {
    std::array<std::int64_t, 3> low, high;
  };

  static constexpr std::size_t most_level = 54;  // its cells are larger than everything
  static constexpr double half_box = 0.75;       // of the largest box of a level, in its cells
  static constexpr double most_cells = 6;        // that a stratum looks across
  static std::uint64_t brick_key(std::int64_t x, std::int64_t y, std::int64_t z, std::size_t level);
  static std::uint64_t cells_between(std::int64_t first, std::int64_t last, std::size_t axis);

  std::size_t slot_of(std::uint64_t key) const;
  void grow();
  std::int64_t cell_along(double coordinate, std::size_t level) const;
  CellBox cells_around(const PointBox& middle, double around, std::size_t level) const;
  template <class Visit>
  void visit_cells(const CellBox& box, std::size_t level, const Visit& visit) const;

  std::array<double, most_level + 1> cell_{}, per_unit_{};  // by level: edge, and its inverse
  std::vector<Brick> bricks_;                               // open addressing
  std::size_t brick_count_ = 0;
  std::uint64_t levels_ = 0;                   // those in use
  std::vector<std::uint64_t> cell_of_;         // by stratum, until it is built
  std::vector<std::uint32_t> begin_, strata_;  // the strata of each cell
};

// Calls visit(stratum) for every stratum of every cell of the box until it returns false.
template <class Visit>
void StratumGrid::visit_cells(const CellBox& box, std::size_t level, const Visit& visit) const {
  const auto slab_of = [&](std::size_t axis, std::int64_t brick) {
    return cells_between(std::max<std::int64_t>(box.low[axis] - 4 * brick, 0),
                         std::min<std::int64_t>(box.high[axis] - 4 * brick, 3), axis);
  };
  for (std::int64_t z = box.low[2] >> 2; z <= box.high[2] >> 2; ++z)
    for (std::int64_t y = box.low[1] >> 2; y <= box.high[1] >> 2; ++y)
      for (std::int64_t x = box.low[0] >> 2; x <= box.high[0] >> 2; ++x) {
        const Brick& brick = bricks_[slot_of(brick_key(x, y, z, level))];
        std::uint64_t cells = brick.occupied & slab_of(0, x) & slab_of(1, y) & slab_of(2, z);
        for (; cells != 0; cells &= cells - 1) {
          const std::uint64_t below = (cells & (~cells + 1)) - 1;
          const std::size_t cell =
              brick.first + static_cast<std::size_t>(std::popcount(brick.occupied & below));
          for (std::uint32_t i = begin_[cell]; i < begin_[cell + 1]; ++i)
            if (!visit(strata_[i])) return;
        }
      }
}

template <class Keep>
void StratumGrid::find(std::span<const float> x, std::span<const float> y, std::span<const float> z,
                       const PointBox& box, bool torn, float distance, std::size_t limit, const Keep& keep,
                       Scratch& scratch, std::vector<std::uint32_t>& found) const {
  found.clear();
  const auto add = [&](std::uint32_t stratum) {
    if (keep(stratum, box)) found.push_back(stratum);
    return found.size() < limit;
  };
  const auto add_new = [&](std::uint32_t stratum, const PointBox& place) {
    if (!keep(stratum, place)) return true;
    std::size_t slot = stratum * 0x9E3779B9u >> 22;
    for (; scratch.slots[slot] != 0; slot = (slot + 1) % scratch.slots.size())
      if (scratch.slots[slot] == stratum + 1) return true;
    scratch.slots[slot] = stratum + 1;
    scratch.used.push_back(static_cast<std::uint32_t>(slot));
    found.push_back(stratum);
    return found.size() < limit;
  };
  for (std::uint64_t left = levels_; left != 0 && found.size() < limit; left &= left - 1) {
    const auto level = static_cast<std::size_t>(std::countr_zero(left));
    const bool finer = distance > most_cells * cell_[level];
    const double around = finer ? 2 * cell_[level] : distance + half_box * cell_[level];
    if (!torn && !finer) {
      visit_cells(cells_around(box, around, level), level, add);
      continue;
    }
    for (std::size_t i = 0; i < x.size() && found.size() < limit; ++i) {
      const std::array<float, 3> at = {x[i], y[i], z[i]};
      const PointBox place = {at, at};
      visit_cells(cells_around(place, around, level), level,
                  [&](std::uint32_t stratum) { return add_new(stratum, place); });
    }
    for (const std::uint32_t slot : scratch.used) scratch.slots[slot] = 0;
    scratch.used.clear();
  }
}

template <class Keep>
bool StratumGrid::find_around(const PointBox& box, float distance, std::size_t limit, const Keep& keep,
                              std::vector<std::uint32_t>& found) const {
  found.clear();
  for (std::uint64_t left = levels_; left != 0; left &= left - 1) {
    const auto level = static_cast<std::size_t>(std::countr_zero(left));
    if (distance > most_cells * cell_[level]) return false;
    visit_cells(cells_around(box, distance + half_box * cell_[level], level), level,
                [&](std::uint32_t stratum) {
                  if (keep(stratum)) found.push_back(stratum);
                  return found.size() <= limit;
                });
    if (found.size() > limit) return false;
  }
  return true;
}

}  // namespace meander
