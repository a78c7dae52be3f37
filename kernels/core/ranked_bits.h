// Bits with ranks: the positions of numbers in an ascending list, found in constant time.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace meander {

// Whether the numbers ascend without repetition and are below `count`.
inline bool ascend_below(std::span<const std::uint32_t> numbers, std::size_t count) {
  return std::adjacent_find(numbers.begin(), numbers.end(), std::greater_equal<>()) == numbers.end() &&
         (numbers.empty() || numbers.back() < count);
}

// One bit a number, and for each word of bits the number of bits set before it (Jacobson 1989). Memory: a
// quarter of a byte a number below `count`.
class RankedBits {
 public:
  static constexpr std::size_t none = ~std::size_t{0};

  RankedBits() = default;
  // Sets the bits of `numbers` among `count`; ascend_below(numbers, count) must hold. O(count / 64 +
  // numbers).
  RankedBits(std::span<const std::uint32_t> numbers, std::size_t count) : words_((count + 63) / 64) {
    for (const std::uint32_t number : numbers) words_[number / 64].bits |= std::uint64_t{1} << number % 64;
    std::uint32_t before = 0;
    for (Word& word : words_) {
      word.before = before;
      before += static_cast<std::uint32_t>(std::popcount(word.bits));
    }
  }

  // The position of a number below `count` in the list, or none.
  std::size_t rank_of(std::uint32_t number) const {
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
