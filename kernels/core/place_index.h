// Where numbers are in an ascending list of a few of them, found in constant time.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace meander {

// Whether numbers ascend, without a repetition, below `count`.
inline bool are_places(std::span<const std::uint32_t> numbers, std::size_t count) {
  return std::adjacent_find(numbers.begin(), numbers.end(), std::greater_equal<>()) == numbers.end() &&
         (numbers.empty() || numbers.back() < count);
}

// One bit a number, and by word of bits how many are in the list before it: a quarter of a byte a number.
class PlaceIndex {
 public:
  static constexpr std::size_t none = ~std::size_t{0};

  PlaceIndex() = default;
  // Of numbers below `count`, which ascend without a repetition (are_places). O(count / 64 + numbers).
  PlaceIndex(std::span<const std::uint32_t> numbers, std::size_t count) : words_((count + 63) / 64) {
    for (const std::uint32_t number : numbers) words_[number / 64].bits |= std::uint64_t{1} << number % 64;
    std::uint32_t before = 0;
    for (Word& word : words_) {
      word.before = before;
      before += static_cast<std::uint32_t>(std::popcount(word.bits));
    }
  }

  // The place of a number below `count`, or none.
  std::size_t find(std::uint32_t number) const {
    const Word& word = words_[number / 64];
    const std::uint64_t bit = std::uint64_t{1} << number % 64;
    if ((word.bits & bit) == 0) return none;
    return word.before + static_cast<std::size_t>(std::popcount(word.bits & (bit - 1)));
  }

 private:
  struct Word {
    std::uint64_t bits = 0;
    std::uint32_t before = 0;
  };
  std::vector<Word> words_;
};

}  // namespace meander
