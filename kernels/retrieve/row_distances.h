// The inner loops of descriptor distances for each instruction set. Internal to kernels/retrieve.
//
// All sets add the same numbers in the same order: 16 lanes of partial sums, lane l with the terms of bins l,
// l + 16, ..., then lanes in halves. They agree to the bit; build without contraction.
#pragma once

#include <cstddef>

#include "kernels/core/instruction_set.h"

namespace meander {

inline constexpr std::size_t distance_lanes = 16;

// Sets out[i] to the sum over bins of a term of the query and row i of `count` rows, each of `stride`
// numbers, a multiple of the lanes.
using RowDistances = void (*)(const float* query, const float* rows, std::size_t stride, std::size_t count,
                              float* out);

struct RowDistanceLoops {
  RowDistances absolute;  // |a - b|
  RowDistances squared;   // (a - b)^2
  RowDistances relative;  // (a - b)^2 / (|a| + |b|), 0 where both are 0
};

// The set must be available, and not InstructionSet::automatic.
const RowDistanceLoops& row_distance_loops(InstructionSet set);

}  // namespace meander
