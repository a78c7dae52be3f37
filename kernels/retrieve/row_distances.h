// The inner loops of descriptor distances, one set per instruction set. Internal to kernels/retrieve.
//
// All sets add the same numbers in the same order: 16 lanes of partial sums, lane l the terms of bins l,
// l + 16, ..., then lanes added in halves. They agree to the bit; build without contraction.
#pragma once

#include <cstddef>

#include "kernels/core/instruction_set.h"

namespace meander {

inline constexpr std::size_t distance_lanes = 16;

// out[i] = sum over bins of a term of the query and row i of `count` rows, each of `stride` numbers, a
// multiple of the lanes.
using RowDistances = void (*)(const float* query, const float* rows, std::size_t stride, std::size_t count,
                              float* out);

struct RowDistanceLoops {
  RowDistances absolute;  // |a - b|
  RowDistances squared;   // (a - b)^2
  RowDistances relative;  // (a - b)^2 / (|a| + |b|), 0 where both are 0
};

// Never for InstructionSet::automatic. The set must be available.
const RowDistanceLoops& row_distance_loops(InstructionSet set);

}  // namespace meander
