#include "kernels/rays/sheets.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "kernels/mesh/prepared_mesh.h"

namespace meander {

namespace {

// Conflicts of triangle t: other[begin[t]] .. other[begin[t + 1] - 1], ascending.
struct ConflictLists {
  std::vector<std::uint32_t> begin, other;

  std::span<const std::uint32_t> of(std::size_t t) const {
    return {other.data() + begin[t], begin[t + 1] - begin[t]};
  }
};

ConflictLists list_conflicts(std::span<const Conflict> conflicts, std::size_t triangles) {
  ConflictLists lists;
  lists.begin.assign(triangles + 1, 0);
  lists.other.resize(2 * conflicts.size());
  for (const Conflict c : conflicts) {
    ++lists.begin[c.first + 1];
    ++lists.begin[c.second + 1];
  }
  for (std::size_t t = 0; t < triangles; ++t) lists.begin[t + 1] += lists.begin[t];
  std::vector<std::uint32_t> at(lists.begin.begin(), lists.begin.end() - 1);
  for (const Conflict c : conflicts) {
    lists.other[at[c.first]++] = c.second;
    lists.other[at[c.second]++] = c.first;
  }
  return lists;
}

struct Regions {
  std::vector<std::uint32_t> of_triangle;  // T
  std::vector<double> mass;
};

Regions grow_regions(std::span<const std::uint32_t> opposite, std::span<const double> mass,
                     const ConflictLists& conflicts) {
  const std::size_t triangles = mass.size();
  Regions regions;
  regions.of_triangle.assign(triangles, no_index);
  std::vector<std::uint32_t> refused_by(triangles, no_index), queue;
  for (std::uint32_t seed = 0; seed < triangles; ++seed) {
    if (regions.of_triangle[seed] != no_index) continue;
    const auto region = static_cast<std::uint32_t>(regions.mass.size());
    const bool overlaps = !conflicts.of(seed).empty();
    double sum = 0;
    queue.assign(1, seed);
    regions.of_triangle[seed] = region;
    for (std::size_t i = 0; i < queue.size(); ++i) {
      sum += mass[queue[i]];
      for (std::uint32_t k = 0; k < 3; ++k) {
        const std::uint32_t half_edge = opposite[3 * std::size_t{queue[i]} + k];
        if (half_edge == no_index) continue;
        const std::uint32_t t = half_edge / 3;
        if (regions.of_triangle[t] != no_index || refused_by[t] == region) continue;
        const auto own = conflicts.of(t);
        const bool refused = own.empty() == overlaps || std::any_of(own.begin(), own.end(), [&](auto other) {
                               return regions.of_triangle[other] == region;
                             });
        if (refused) {
          refused_by[t] = region;
        } else {
          regions.of_triangle[t] = region;
          queue.push_back(t);
        }
      }
    }
    regions.mass.push_back(sum);
  }
  return regions;
}

// Fewer are not put in order.
constexpr std::size_t least_room = 1 << 14;

}  // namespace

ConflictSet::ConflictSet(std::size_t triangles) : most_(most_conflicts(triangles)) {}

// As many may come next as there are different ones, so that N of them take O(N log C).
void ConflictSet::leave_out_repeats() {
  std::sort(conflict_.begin(), conflict_.end());
  conflict_.erase(std::unique(conflict_.begin(), conflict_.end()), conflict_.end());
  is_full_ = 2 * conflict_.size() > most_;
  room_ = std::max(least_room, 2 * conflict_.size());
  conflict_.reserve(room_);
}

std::vector<Conflict> ConflictSet::take() {
  leave_out_repeats();
  recent_.clear();
  is_full_ = false;
  room_ = 0;
  return std::exchange(conflict_, {});
}

std::vector<std::uint8_t> separate_sheets(std::span<const std::uint32_t> opposite,
                                          std::span<const double> mass, std::span<const Conflict> conflicts,
                                          const SheetParameters& parameters) {
  const std::size_t triangles = mass.size();
  const ConflictLists lists = list_conflicts(conflicts, triangles);
  const Regions regions = grow_regions(opposite, mass, lists);
  const std::size_t count = regions.mass.size();

  std::vector<std::uint32_t> begin(count + 1, 0), member(triangles);
  for (const std::uint32_t r : regions.of_triangle) ++begin[r + 1];
  for (std::size_t r = 0; r < count; ++r) begin[r + 1] += begin[r];
  std::vector<std::uint32_t> at(begin.begin(), begin.end() - 1);
  for (std::uint32_t t = 0; t < triangles; ++t) member[at[regions.of_triangle[t]]++] = t;

  std::vector<std::uint32_t> order(count);
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return regions.mass[a] != regions.mass[b] ? regions.mass[a] > regions.mass[b] : a < b;
  });
  // Sheets of the regions placed so far, as sets of one bit each; 0 while a region has none.
  std::vector<std::uint32_t> sheet_bit(count, 0);
  const std::uint32_t all = (std::uint64_t{1} << parameters.max_sheets) - 1;
  for (const std::uint32_t r : order) {
    sheet_bit[r] = 1;
    if (!(regions.mass[r] > parameters.min_mass)) continue;
    std::uint32_t taken = 0;
    for (std::uint32_t i = begin[r]; i < begin[r + 1]; ++i)
      for (const std::uint32_t other : lists.of(member[i]))
        if (regions.of_triangle[other] != r) taken |= sheet_bit[regions.of_triangle[other]];
    const std::uint32_t open = all & ~taken;
    if (open != 0) sheet_bit[r] = open & (~open + 1);
  }
  std::vector<std::uint8_t> sheet(triangles);
  for (std::size_t t = 0; t < triangles; ++t) {
    std::uint8_t number = 0;
    while ((sheet_bit[regions.of_triangle[t]] >> number & 1u) == 0) ++number;
    sheet[t] = number;
  }
  return sheet;
}

}  // namespace meander
