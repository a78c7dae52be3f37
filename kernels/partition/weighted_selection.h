// The entry of a row at which a given mass is reached, without sorting the row.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

namespace meander {

struct SelectedEntry {
  std::size_t place;    // in the row
  std::uint64_t below;  // the mass of all entries before it
};

// Puts the entry at which the sum of masses, in ascending order of the entries, exceeds `target` in its
// place: lower entries before it, higher ones behind it, in no order. The last one where the sum never does.
// `mass` gives that of an entry. Entries are distinct, and there is at least one. Weighted quickselect (Hoare
// 1961): O(N) on average, O(N log N) at most.
template <class Mass>
SelectedEntry select_by_mass(std::span<std::uint64_t> row, std::uint64_t target, const Mass& mass,
                             int most_rounds) {
  constexpr std::size_t short_row = 8;
  std::size_t first = 0, last = row.size();
  std::uint64_t below = 0;
  for (int rounds = most_rounds; last - first > short_row; --rounds) {
    if (rounds == 0) {
      std::sort(row.begin() + static_cast<std::ptrdiff_t>(first),
                row.begin() + static_cast<std::ptrdiff_t>(last));
      last = first;  // nothing is left to be put in order
      break;
    }
    // Not of the ends: rows that are in order, one way or the other, are common.
    const std::size_t quarter = (last - first) / 4;
    const std::uint64_t a = row[first + quarter], b = row[first + 2 * quarter], c = row[first + 3 * quarter];
    const std::uint64_t pivot = std::max(std::min(a, b), std::min(std::max(a, b), c));
    // Which part an entry belongs to cannot be predicted: no branches. The pivot is not the least, so that
    // neither part is empty.
    std::size_t low = first;
    std::uint64_t lower = 0;
    for (std::size_t i = first; i < last; ++i) {
      const std::uint64_t entry = row[i];
      const std::uint64_t is_low = entry < pivot;
      row[i] = row[low];
      row[low] = entry;
      low += is_low;
      lower += mass(entry) & -is_low;
    }
    if (target < below + lower) {
      last = low;
    } else {
      below += lower;
      first = low;
    }
  }
  // The least of what is left, again and again.
  for (; first + 1 < row.size(); ++first) {
    std::uint64_t least = row[first];
    std::size_t place = first;
    for (std::size_t i = first + 1; i < last; ++i) {
      const bool is_less = row[i] < least;
      least = is_less ? row[i] : least;
      place = is_less ? i : place;
    }
    row[place] = row[first];
    row[first] = least;
    const std::uint64_t next = mass(least);
    if (target < below + next) break;
    below += next;
  }
  return {first, below};
}
template <class Mass>
SelectedEntry select_by_mass(std::span<std::uint64_t> row, std::uint64_t target, const Mass& mass) {
  return select_by_mass(row, target, mass, 3 * static_cast<int>(std::bit_width(row.size())));
}

}  // namespace meander
