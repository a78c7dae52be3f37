// The 1-D sample sets and the order of the samples in the file (docs/METHODS.md 7).
#include <algorithm>
#include <bit>
#include <cmath>
#include <stdexcept>

#include "kernels/core/parallel.h"
#include "kernels/core/reversed_bits.h"
#include "kernels/sample/place_samples.h"
#include "kernels/sample/sequence.h"

namespace meander {

namespace {

double wrap(double t) { return std::min(t - std::floor(t), below_one); }

// Van der Corput point `index` in base 2 under Owen's nested scrambling (Owen 1995): the flip of each digit
// depends on the digits above it. A pure function of (key, index), so a longer sequence extends a shorter
// one.
double owen_van_der_corput(RandomKey key, std::uint32_t index) {
  const std::uint64_t seed = static_cast<std::uint64_t>(key.words[0]) << 32 | key.words[1];
  std::uint32_t scrambled = 0;
  for (int level = 0; level < 32; ++level) {
    const std::uint32_t digit = index >> level & 1u;  // radical inverse: digits come in reversed order
    // The node of the scrambling tree: a 1 in front of the (unscrambled) digits above this one.
    const std::uint64_t node = std::uint64_t{1} << level | (index & ((std::uint64_t{1} << level) - 1));
    std::uint64_t hash = seed + node * 0x9E3779B97F4A7C15u;  // SplitMix64 finaliser (Steele, Lea, Flood 2014)
    hash = (hash ^ (hash >> 30)) * 0xBF58476D1CE4E5B9u;
    hash = (hash ^ (hash >> 27)) * 0x94D049BB133111EBu;
    scrambled = scrambled << 1 | (digit ^ static_cast<std::uint32_t>((hash ^ (hash >> 31)) & 1u));
  }
  const double rest = random_pair(key, Stream::sequence, index).first;
  return std::min((scrambled + rest) * 0x1p-32, below_one);
}

// Value of sample `index` in its own numbering, before sorting.
double sequence_value(SequenceKind kind, std::uint32_t count, double jitter, RandomKey key, double shift,
                      std::uint32_t index) {
  const auto uniform = [&] { return random_pair(key, Stream::sequence, index).first; };
  switch (kind) {
    case SequenceKind::shifted:
      return wrap((index + shift + jitter * (uniform() - 0.5)) / count);
    case SequenceKind::stratified:
      return std::min((index + uniform()) / count, below_one);
    case SequenceKind::owen:
      return owen_van_der_corput(key, index);
    case SequenceKind::regular:
      return (index + 0.5) / count;
    case SequenceKind::random:
      break;
    case SequenceKind::spaced:
      throw std::invalid_argument("the sequence `spaced` has no positions along the path");
  }
  return uniform();
}

}  // namespace

SampleSequence make_sequence(SequenceKind kind, std::uint32_t count, double jitter, RandomKey key) {
  const double shift = random_pair(key, Stream::sequence_shift, 0).first;
  SampleSequence sequence;
  std::vector<double>& position = sequence.position;
  position.resize(count);
  const auto value = [&](std::uint32_t i) { return sequence_value(kind, count, jitter, key, shift, i); };
  if (kind == SequenceKind::owen || kind == SequenceKind::random) {
    std::vector<std::pair<double, std::uint32_t>> entries(count);
    for (std::uint32_t i = 0; i < count; ++i) entries[i] = {value(i), i};
    std::sort(entries.begin(), entries.end());
    sequence.rank_of_index.resize(count);
    for (std::uint32_t r = 0; r < count; ++r) {
      position[r] = entries[r].first;
      sequence.rank_of_index[entries[r].second] = r;
    }
    return sequence;
  }
  parallel_blocks(count, sum_block, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) position[i] = value(static_cast<std::uint32_t>(i));
  });
  // The strata ascend already, but for one place where a shifted sequence wraps round.
  const auto wrapped = std::is_sorted_until(position.begin(), position.end());
  if (std::is_sorted(wrapped, position.end()) &&
      (wrapped == position.end() || position.back() <= position.front()))
    std::rotate(position.begin(), wrapped, position.end());
  else
    std::sort(position.begin(), position.end());
  return sequence;
}

std::vector<double> sample_sequence(SequenceKind kind, std::uint32_t count, double jitter, RandomKey key) {
  return make_sequence(kind, count, jitter, key).position;
}

namespace {

// The ranks 0 .. n - 1 cut into 2^level nearly equal blocks; a block may be empty.
struct RankBlocks {
  std::uint64_t count;
  std::uint64_t begin(int level, std::uint64_t block) const { return block * count >> level; }
  bool empty(int level, std::uint64_t block) const { return begin(level, block) == begin(level, block + 1); }
};

// The block that is divided as number `index` of the 2^level.
std::uint32_t divided_block(int level, std::uint32_t index, std::uint32_t mask) {
  return level == 0 ? 0 : (reversed_bits(index) ^ mask) >> (32 - level);
}

}  // namespace

std::vector<std::uint32_t> parent_order(int level, std::uint32_t mask) {
  std::vector<std::uint32_t> order(std::size_t{1} << level);
  for (std::uint32_t j = 0; j < order.size(); ++j) order[j] = divided_block(level, j, mask);
  return order;
}

std::vector<std::uint32_t> masked_order(std::uint32_t count, std::uint32_t mask) {
  std::vector<std::uint32_t> order;
  if (count == 0) return order;
  if (count == 1) return {0};
  order.reserve(count);
  const int levels = std::bit_width(count - 1);
  const RankBlocks blocks{count};
  // The rank that represents a block of a level above the last: down by the mask's bits, on the last level
  // into the other child where that one is empty. Only there a block may be empty.
  const auto representative = [&](int level, std::uint64_t block) {
    const std::uint64_t below = mask >> (32 - levels) & ((std::uint64_t{1} << (levels - level)) - 1);
    block = block << (levels - level) | below;
    return static_cast<std::uint32_t>(blocks.begin(levels, block ^ (blocks.empty(levels, block) ? 1 : 0)));
  };
  order.push_back(representative(0, 0));
  // The child is the one where the parent's representative did not go.
  for (int level = 1; level < levels; ++level)
    for (std::uint32_t j = 0; j < std::uint32_t{1} << (level - 1); ++j) {
      const std::uint64_t parent = divided_block(level - 1, j, mask);
      order.push_back(representative(level, parent << 1 | (~(mask >> (32 - level)) & 1)));
    }
  // On the last level only some parents have two children. Bit reversal over all parents would visit those in
  // clusters (their pattern along the curve is nearly periodic), so they are taken in the progressive order
  // of their own number.
  std::vector<std::uint32_t> rest;
  for (std::uint64_t parent = 0; parent < std::uint64_t{1} << (levels - 1); ++parent) {
    const std::uint64_t child = parent << 1 | (~(mask >> (32 - levels)) & 1);
    if (!blocks.empty(levels, child) && !blocks.empty(levels, child ^ 1))
      rest.push_back(static_cast<std::uint32_t>(blocks.begin(levels, child)));
  }
  for (const std::uint32_t i : masked_order(static_cast<std::uint32_t>(rest.size()), mask))
    order.push_back(rest[i]);
  return order;
}

std::uint32_t progressive_mask(std::uint32_t count, RandomKey key) {
  const int levels = count > 1 ? std::bit_width(count - 1) : 0;
  const std::uint64_t word = random_words(key, Stream::sequence_shift, 1)[0];
  return static_cast<std::uint32_t>(word << (32 - levels));
}

std::vector<std::uint32_t> progressive_order(std::uint32_t count, RandomKey key) {
  return masked_order(count, progressive_mask(count, key));
}

}  // namespace meander
