// The items of a node of balanced bisection, and how they are divided in two.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "kernels/core/vector_instructions.h"
#include "kernels/partition/balanced_order.h"
#include "kernels/partition/weighted_selection.h"

namespace meander {

// Nodes of more elements than this are cut by a histogram of their coordinates first.
inline constexpr std::size_t small_node = 32;
inline constexpr std::size_t cut_bins = 64;

// What a node of the tree holds.
using NodeItem = CellEntry;

// The bounding box of items, as SSE registers whose fourth lanes mean nothing.
struct ItemBox {
  __m128 least = _mm_set1_ps(INFINITY), most = _mm_set1_ps(-INFINITY);
  void hold(const NodeItem& item) {
    const __m128 at = _mm_loadu_ps(item.at);  // and its name
    least = _mm_min_ps(least, at);
    most = _mm_max_ps(most, at);
  }
};

// The axis of the largest extent, and its range.
struct ItemExtent {
  std::size_t axis = 0;
  float least = 0, most = 0;
  float length() const { return most - least; }
};

inline ItemExtent largest_extent(const ItemBox& box) {
  alignas(16) float least[4], most[4];
  _mm_store_ps(least, box.least);
  _mm_store_ps(most, box.most);
  ItemExtent extent{0, least[0], most[0]};
  for (std::size_t k = 1; k < 3; ++k)
    if (most[k] - least[k] > extent.length()) extent = {k, least[k], most[k]};
  return extent;
}

inline ItemExtent largest_extent(std::span<const NodeItem> items) {
  ItemBox even, odd;  // two chains of minima, which wait for each other less
  std::size_t i = 0;
  for (; i + 1 < items.size(); i += 2) {
    even.hold(items[i]);
    odd.hold(items[i + 1]);
  }
  if (i < items.size()) even.hold(items[i]);
  even.least = _mm_min_ps(even.least, odd.least);
  even.most = _mm_max_ps(even.most, odd.most);
  return largest_extent(even);
}

// A coordinate and the number of its item as one word, in the order of both.
inline std::uint64_t row_entry(float coordinate, std::size_t number) {
  const auto bits = std::bit_cast<std::uint32_t>(coordinate + 0.0f);  // no negative zero
  const std::uint32_t ordered = bits & 0x80000000u ? ~bits : bits | 0x80000000u;
  return std::uint64_t{ordered} << 32 | number;
}
inline std::uint32_t number_of(std::uint64_t entry) { return static_cast<std::uint32_t>(entry); }

struct DivideScratch {
  std::vector<std::uint64_t> row;  // of items that the cut may lie in
  std::vector<std::uint8_t> bin;   // by item
};

// The lower `target` of the mass to `to` and on, the rest before `end`, from there down; how many items
// each. `at` gives the coordinate of an item, all in `range`.
template <class Coordinate>
std::pair<std::size_t, std::size_t> divide(std::span<const NodeItem> items, const Coordinate& at,
                                           const ItemExtent& range, std::uint64_t target, NodeItem* to,
                                           NodeItem* end, DivideScratch& scratch) {
  std::vector<std::uint64_t>& row = scratch.row;
  row.clear();
  NodeItem* low = to;
  NodeItem* high = end - 1;
  std::uint64_t below = 0;
  if (items.size() <= small_node) {
    for (std::size_t i = 0; i < items.size(); ++i) row.push_back(row_entry(at(i), i));
  } else {
    constexpr float least_range = 1e-30f;  // below, the scale would overflow: all in one bin then
    const float scale = range.length() > least_range ? static_cast<float>(cut_bins) / range.length() : 0.0f;
    const auto bin_of = [&](std::size_t i) {
      return std::min(static_cast<int>((at(i) - range.least) * scale), static_cast<int>(cut_bins - 1));
    };
    std::array<std::uint64_t, cut_bins> sum{};
    scratch.bin.resize(items.size());
    for (std::size_t i = 0; i < items.size(); ++i) {
      const int bin = bin_of(i);
      scratch.bin[i] = static_cast<std::uint8_t>(bin);
      sum[static_cast<std::size_t>(bin)] += items[i].mass;
    }
    int crossing = 0;
    while (crossing + 1 < static_cast<int>(cut_bins) &&
           below + sum[static_cast<std::size_t>(crossing)] <= target)
      below += sum[static_cast<std::size_t>(crossing++)];
    for (std::size_t i = 0; i < items.size(); ++i) {
      const int bin = scratch.bin[i];
      if (bin == crossing) {
        row.push_back(row_entry(at(i), i));
        continue;
      }
      // To both ends, of which one moves on: which side it is cannot be predicted, so that no compiler may
      // make a branch of it. Between the two there is always room.
      *low = items[i];
      *high = items[i];
      const std::ptrdiff_t is_below = (bin - crossing) >> 31;  // -1 or 0
      low -= is_below;
      high += ~is_below;
    }
  }
  if (!row.empty()) {
    const auto item_of = [&](std::uint64_t entry) -> const NodeItem& { return items[number_of(entry)]; };
    const SelectedEntry cut =
        select_by_mass(row, target - below, [&](std::uint64_t entry) { return item_of(entry).mass; });
    for (std::size_t i = 0; i < cut.place; ++i) *low++ = item_of(row[i]);
    const NodeItem& divided = item_of(row[cut.place]);
    const std::uint64_t part = std::min(target - below - cut.below, divided.mass);
    if (part > 0) {
      *low = divided;
      (low++)->mass = part;
    }
    if (part < divided.mass) {
      *high = divided;
      (high--)->mass = divided.mass - part;
    }
    for (std::size_t i = cut.place + 1; i < row.size(); ++i) *high-- = item_of(row[i]);
  }
  return {static_cast<std::size_t>(low - to), static_cast<std::size_t>(end - 1 - high)};
}

}  // namespace meander
