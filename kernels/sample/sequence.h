// A 1-D sample set, sorted, with the numbering that it was drawn in where that matters.
#pragma once

#include <cstdint>
#include <vector>

#include "kernels/core/random.h"
#include "kernels/sample/place_samples.h"

namespace meander {

// The largest position.
inline constexpr double below_one = 1.0 - 0x1p-53;

struct SampleSequence {
  std::vector<double> position;              // N values in [0, 1), ascending: by curve rank
  std::vector<std::uint32_t> rank_of_index;  // owen and random: rank of the i-th draw (these sets are
                                             // progressive as they are drawn); empty for the others
};

// O(N log N). Pure in (kind, count, jitter, key).
SampleSequence make_sequence(SequenceKind kind, std::uint32_t count, double jitter, RandomKey key);

// The mask of progressive_order, its highest bit for the first level; and that order under a mask.
std::uint32_t progressive_mask(std::uint32_t count, RandomKey key);
std::vector<std::uint32_t> masked_order(std::uint32_t count, std::uint32_t mask);
// The order in which the blocks of a level are divided: bit reversal under the mask, of 2^level.
std::vector<std::uint32_t> parent_order(int level, std::uint32_t mask);

}  // namespace meander
