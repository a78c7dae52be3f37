// Separating the sheets of an overlapping chart.
#pragma once

#include <algorithm>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace meander {

// Two triangles of a chart that cover one point, the smaller number first.
struct Conflict {
  std::uint32_t first = 0, second = 0;
  auto operator<=>(const Conflict&) const = default;
};

// More of them say no more about a chart that covers itself all over.
constexpr std::size_t most_conflicts(std::size_t triangles) { return (std::size_t{1} << 17) + 8 * triangles; }
// Upper bound of their bytes, with what separate_sheets makes of them.
constexpr double conflict_bytes(double triangles) {
  constexpr double bytes_per_triangle = 128, bytes_of_few = 2.0 * 1024 * 1024;
  return triangles * bytes_per_triangle + bytes_of_few;
}

// The different conflicts among those that are added, which are mostly the same ones again and again.
class ConflictSet {
 public:
  // For a chart with this many triangles.
  explicit ConflictSet(std::size_t triangles);
  // Two triangles in either order. Once half of most_conflicts are found to be different, no more are added.
  void add(std::uint32_t a, std::uint32_t b) {
    if (is_full_) return;
    const Conflict conflict{std::min(a, b), std::max(a, b)};
    if (recent_.empty()) recent_.resize(recent_conflicts);  // no triangle conflicts with itself
    Conflict& recent = recent_[(conflict.first * 0x9e3779b1u + conflict.second * 0x85ebca6bu) >> 20];
    if (recent == conflict) return;
    recent = conflict;
    if (conflict_.size() == room_) leave_out_repeats();
    conflict_.push_back(conflict);
  }
  // Each once, ascending by both numbers. Leaves the set empty.
  std::vector<Conflict> take();

 private:
  static constexpr std::size_t recent_conflicts = std::size_t{1} << 12;
  void leave_out_repeats();
  std::vector<Conflict> recent_;    // by hash: neighboring rays find the same ones
  std::vector<Conflict> conflict_;  // the different ones, ascending, and what has come since
  std::size_t most_, room_ = 0;
  bool is_full_ = false;
};

struct SheetParameters {
  std::uint32_t max_sheets = 16;  // 1..16
  double min_mass = 0;            // regions of at most this mass stay in sheet 0
};

// Sheet number (0 .. max_sheets - 1) of every triangle, so that conflicting triangles lie in different sheets
// wherever possible, except in regions of at most min_mass.
//   opposite: 3 T half-edges of the chart; mass: T; conflicts: in any order, repeats allowed.
// Connected regions are grown breadth first, from the lowest triangle that has none, without ever joining two
// conflicting triangles; triangles without any conflict and those with one never share a region, so that a
// part of the chart that overlaps is moved to another sheet as a whole and nothing else is. Then the regions,
// the heaviest first, take the lowest sheet in which they conflict with nothing. Regions that are too light,
// or find no sheet, stay in sheet 0. O(T + C). Deterministic.
std::vector<std::uint8_t> separate_sheets(std::span<const std::uint32_t> opposite,
                                          std::span<const double> mass, std::span<const Conflict> conflicts,
                                          const SheetParameters& parameters);

}  // namespace meander
