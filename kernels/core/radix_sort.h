// Stable radix sorts, least significant digit first: 64-bit keys with their 32-bit payload, and words by
// their upper bits.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "kernels/core/large_vector.h"
#include "kernels/core/parallel.h"

namespace meander {

struct KeyIndex {
  std::uint64_t key;
  std::uint32_t index;
};

// Sorts by key; equal keys keep their order. `scratch` is resized to the size of `items`. Digits have 11
// bits; those that all keys share are skipped. O(n), deterministic.
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

namespace radix {

inline constexpr int word_bits = 12;  // of a digit
inline constexpr std::size_t word_values = std::size_t{1} << word_bits;
using Counts = std::array<std::uint32_t, word_values>;

inline std::size_t word_digit(std::uint64_t word, int low_bit) {
  return (word >> low_bit) & (word_values - 1);
}

// Sorts many words by one digit. Each block counts its own words and then knows where they go: behind those
// of the blocks before it.
inline void sort_digit_in_blocks(std::span<const std::uint64_t> words, std::span<std::uint64_t> sorted,
                                 int low_bit) {
  constexpr std::size_t max_blocks = 16;
  const std::size_t block = (words.size() + max_blocks - 1) / max_blocks;
  std::vector<Counts> counts((words.size() + block - 1) / block, Counts{});
  parallel_blocks(words.size(), block, [&](std::size_t begin, std::size_t end) {
    Counts& count = counts[begin / block];
    for (std::size_t i = begin; i < end; ++i) ++count[word_digit(words[i], low_bit)];
  });
  std::uint32_t sum = 0;
  for (std::size_t value = 0; value < word_values; ++value)
    for (Counts& count : counts) sum += std::exchange(count[value], sum);
  parallel_blocks(words.size(), block, [&](std::size_t begin, std::size_t end) {
    Counts& count = counts[begin / block];
    for (std::size_t i = begin; i < end; ++i) sorted[count[word_digit(words[i], low_bit)]++] = words[i];
  });
}

// Sorts in one thread by the `bits` <= 64 - low_bit bits from `low_bit` on, in `digits` digits.
inline void sort_digits(std::vector<std::uint64_t>& words, std::vector<std::uint64_t>& scratch, int low_bit,
                        int bits, int digits) {
  // Digits are no wider than the bits need: with few words, clearing and summing the counts would take longer
  // than moving the words.
  const int width = (bits + digits - 1) / digits;
  const std::size_t values = std::size_t{1} << width;
  const auto digit_of = [=](std::uint64_t word, int digit) {
    return static_cast<std::size_t>(word >> (low_bit + width * digit)) & (values - 1);
  };
  std::vector<std::uint32_t> counts(static_cast<std::size_t>(digits) * values);
  for (const std::uint64_t word : words)
    for (int digit = 0; digit < digits; ++digit)
      ++counts[static_cast<std::size_t>(digit) * values + digit_of(word, digit)];
  for (int digit = 0; digit < digits; ++digit) {
    std::uint32_t* const count = counts.data() + static_cast<std::size_t>(digit) * values;
    if (count[digit_of(words[0], digit)] == words.size()) continue;
    std::uint32_t sum = 0;
    for (std::size_t value = 0; value < values; ++value) sum += std::exchange(count[value], sum);
    for (const std::uint64_t word : words) scratch[count[digit_of(word, digit)]++] = word;
    words.swap(scratch);
  }
}

// Insertion sort of words that are nearly in order; false when it would take more than `max_moves`. Equal
// words keep their order either way.
inline bool sort_nearly_sorted(std::span<std::uint64_t> words, int low_bit, std::size_t max_moves) {
  for (std::size_t i = 1; i < words.size(); ++i) {
    const std::uint64_t word = words[i], key = word >> low_bit;
    std::size_t at = i;
    for (; at > 0 && words[at - 1] >> low_bit > key; --at) {
      if (max_moves-- == 0) {
        words[at] = word;
        return false;
      }
      words[at] = words[at - 1];
    }
    words[at] = word;
  }
  return true;
}

}  // namespace radix

// Sorts fewer than 2^32 words by their bits from `low_bit` < 64 on; equal words keep their order. Digits have
// at most 12 bits. Two digits leave a moderate number of well-spread words nearly sorted, and an insertion
// sort finishes them. O(n); parallel where there are many words.
inline void radix_sort_words(std::vector<std::uint64_t>& words, std::vector<std::uint64_t>& scratch,
                             int low_bit) {
  using namespace radix;
  constexpr std::size_t few = 1024, many = std::size_t{1} << 18;
  if (words.size() < few) {
    std::stable_sort(words.begin(), words.end(),
                     [low_bit](std::uint64_t a, std::uint64_t b) { return a >> low_bit < b >> low_bit; });
    return;
  }
  resize_large(scratch, words.size());
  if (words.size() >= many && oneapi::tbb::this_task_arena::max_concurrency() > 1) {
    for (int bit = low_bit; bit < 64; bit += word_bits) {
      sort_digit_in_blocks(words, scratch, bit);
      words.swap(scratch);
    }
    return;
  }
  const int bits = 64 - low_bit, digits = (bits + word_bits - 1) / word_bits;
  if (digits > 2 && words.size() < many) {
    // Some eight bits more than it takes to number the words.
    const int top = std::min(2 * word_bits, (static_cast<int>(std::bit_width(words.size())) + 9) / 2 * 2);
    sort_digits(words, scratch, 64 - top, top, 2);
    if (sort_nearly_sorted(words, low_bit, 2 * words.size())) return;
  }
  sort_digits(words, scratch, low_bit, bits, digits);
}

}  // namespace meander
