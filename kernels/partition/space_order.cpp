#include "kernels/partition/space_order.h"

#include <algorithm>
#include <bit>
#include <span>
#include <utility>

#include "kernels/core/large_vector.h"
#include "kernels/core/parallel.h"
#include "kernels/core/radix_sort.h"
#include "kernels/curve/curve_key.h"

namespace meander {

namespace {

constexpr std::size_t tie_block = 65536;

// Stable; nearly all ties are of two or three.
void sort_by_key(std::vector<KeyIndex>& items) {
  constexpr std::size_t few = 16;
  const auto precedes = [](const KeyIndex& a, const KeyIndex& b) { return a.key < b.key; };
  if (items.size() > few) {
    std::stable_sort(items.begin(), items.end(), precedes);
    return;
  }
  for (std::size_t i = 1; i < items.size(); ++i)
    for (std::size_t k = i; k > 0 && precedes(items[k], items[k - 1]); --k) std::swap(items[k], items[k - 1]);
}

// Words of equal coarse keys in the order of their whole keys, which key_of(number) gives. A small part of a
// large box may share one cell.
template <class KeyOf>
void sort_ties(std::span<std::uint64_t> words, int number_bits, const KeyOf& key_of) {
  const auto tie = [&](std::size_t a, std::size_t b) {
    return words[a] >> number_bits == words[b] >> number_bits;
  };
  // Ties belong to the block that they begin in, and may be longer than it.
  std::vector<std::size_t> block_begin((words.size() + tie_block - 1) / tie_block + 1, words.size());
  block_begin[0] = 0;
  for (std::size_t b = 1; b + 1 < block_begin.size(); ++b) {
    std::size_t at = std::max(b * tie_block, block_begin[b - 1]);
    if (at > block_begin[b - 1])
      while (at < words.size() && tie(at - 1, at)) ++at;
    block_begin[b] = at;
  }
  parallel_blocks(words.size(), tie_block, [&](std::size_t first, std::size_t) {
    const std::size_t past = block_begin[first / tie_block + 1];
    std::vector<KeyIndex> tied;
    for (std::size_t begin = block_begin[first / tie_block], end; begin < past; begin = end) {
      for (end = begin + 1; end < past && tie(begin, end);) ++end;
      if (end - begin == 1) continue;
      tied.clear();
      for (std::size_t i = begin; i < end; ++i) {
        const auto number = static_cast<std::uint32_t>(words[i] & ((std::uint64_t{1} << number_bits) - 1));
        tied.push_back({key_of(number), number});
      }
      sort_by_key(tied);
      const std::uint64_t key = words[begin] >> number_bits << number_bits;
      for (std::size_t i = begin; i < end; ++i) words[i] = key | tied[i - begin].index;
    }
  });
}

StridedPoints points_from(const std::vector<MassPoint>& points, std::size_t begin) {
  return {points[begin].at, sizeof(MassPoint) / sizeof(float)};
}

std::vector<std::uint64_t> whole_keys(const std::vector<MassPoint>& points) {
  std::vector<std::uint64_t> keys(points.size());
  parallel_blocks(keys.size(), sum_block, [&](std::size_t begin, std::size_t end) {
    hilbert_keys_3d(points_from(points, begin), std::span(keys).subspan(begin, end - begin));
  });
  return keys;
}

}  // namespace

// A coarse key and the number fit into one word. Points of a region are not so many, so that their words have
// room for longer keys; and a region is a stretch of the curve, so that keys less the least of them are
// shorter than whole ones.
SpaceOrder space_order(const std::vector<MassPoint>& points, bool dense) {
  constexpr int most_number_bits = 64 - coarse_key_bits;
  constexpr std::size_t most_numbered = std::size_t{1} << most_number_bits;
  const std::size_t count = points.size();
  const int number_bits = dense ? std::max(static_cast<int>(std::bit_width(count)), 1) : most_number_bits;
  SpaceOrder order;
  std::vector<std::uint64_t>& words = order.words;
  resize_large(words, count);
  if (count == 0) return order;
  std::vector<std::uint64_t> keys;  // whole ones, where they are needed
  if (dense || count > most_numbered) keys = whole_keys(points);
  if (count > most_numbered) {
    std::vector<KeyIndex> numbered(count), scratch;
    for (std::size_t i = 0; i < count; ++i) numbered[i] = {keys[i], static_cast<std::uint32_t>(i)};
    radix_sort(numbered, scratch);
    for (std::size_t i = 0; i < count; ++i) words[i] = numbered[i].index;
    return order;
  }
  if (dense) {
    const auto [least, most] = std::minmax_element(keys.begin(), keys.end());
    const std::uint64_t first = *least, range = *most - first;
    const int unused = 64 - std::max(static_cast<int>(std::bit_width(range)), 1);
    for (std::size_t i = 0; i < count; ++i)
      words[i] = (keys[i] - first) << unused >> number_bits << number_bits | i;
  } else {
    parallel_blocks(count, sum_block, [&](std::size_t begin, std::size_t end) {
      coarse_hilbert_keys_3d(points_from(points, begin), std::span(words).subspan(begin, end - begin));
      for (std::size_t i = begin; i < end; ++i) words[i] = words[i] << number_bits | i;
    });
  }
  {
    std::vector<std::uint64_t> scratch;
    radix_sort_words(words, scratch, number_bits);
  }
  sort_ties(words, number_bits, [&](std::uint32_t number) {
    if (!keys.empty()) return keys[number];
    const float* p = points[number].at;
    return hilbert_key_3d({static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])});
  });
  order.mask = (std::uint64_t{1} << number_bits) - 1;
  return order;
}

}  // namespace meander
