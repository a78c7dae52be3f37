// Stable sort of 64-bit keys with their 32-bit payload, least significant digit first.
#pragma once

#include <algorithm>
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

// Sorts by key; equal keys keep their order. `scratch` is resized to the size of `items`. Digits of 11 bits;
// those that all keys share are skipped. O(n), about 2 ns an element and pass; deterministic.
inline void radix_sort(std::vector<KeyIndex>& items, std::vector<KeyIndex>& scratch) {
  constexpr std::size_t bits = 11, digits = (64 + bits - 1) / bits, values = std::size_t{1} << bits;
  const auto digit_of = [](std::uint64_t key, std::size_t digit) {
    return static_cast<std::size_t>(key >> (bits * digit)) & (values - 1);
  };
  std::array<std::array<std::uint32_t, values>, digits> counts{};
  for (const KeyIndex& item : items)
    for (std::size_t digit = 0; digit < digits; ++digit) ++counts[digit][digit_of(item.key, digit)];
  scratch.resize(items.size());
  for (std::size_t digit = 0; digit < digits; ++digit) {
    auto& count = counts[digit];
    if (items.empty() || count[digit_of(items[0].key, digit)] == items.size()) continue;
    std::uint32_t sum = 0;
    for (std::uint32_t& c : count) sum += std::exchange(c, sum);
    for (const KeyIndex& item : items) scratch[count[digit_of(item.key, digit)]++] = item;
    items.swap(scratch);
  }
}

// Sorts words by their bits from `low_bit` on; equal ones keep their order. Digits of 12 bits. O(n).
inline void radix_sort_words(std::vector<std::uint64_t>& words, std::vector<std::uint64_t>& scratch,
                             int low_bit) {
  if (words.size() < 1024) {
    std::stable_sort(words.begin(), words.end(),
                     [low_bit](std::uint64_t a, std::uint64_t b) { return a >> low_bit < b >> low_bit; });
    return;
  }
  constexpr int bits = 12;
  constexpr std::size_t values = std::size_t{1} << bits;
  const auto digits = static_cast<std::size_t>((64 - low_bit + bits - 1) / bits);
  const auto digit_of = [low_bit](std::uint64_t word, std::size_t digit) {
    return (word >> (low_bit + bits * static_cast<int>(digit))) & (values - 1);
  };
  std::vector<std::array<std::uint32_t, values>> counts(digits);
  for (const std::uint64_t word : words)
    for (std::size_t digit = 0; digit < digits; ++digit) ++counts[digit][digit_of(word, digit)];
  scratch.resize(words.size());
  for (std::size_t digit = 0; digit < digits; ++digit) {
    std::array<std::uint32_t, values>& count = counts[digit];
    if (count[digit_of(words[0], digit)] == words.size()) continue;
    std::uint32_t sum = 0;
    for (std::uint32_t& c : count) sum += std::exchange(c, sum);
    for (const std::uint64_t word : words) scratch[count[digit_of(word, digit)]++] = word;
    words.swap(scratch);
  }
}

}  // namespace meander
