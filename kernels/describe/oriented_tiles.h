// The inner loops of oriented_pair_histogram for each instruction set. Internal to kernels/describe. Pairs
// and tiles are those of pair_tiles.h. All sets do the same IEEE operations on a pair, so that they agree to
// the bit; build without contraction.
#pragma once

#include <cstddef>
#include <cstdint>

#include "kernels/describe/oriented_pairs.h"
#include "kernels/describe/pair_tiles.h"

namespace meander {

struct OrientedTile {
  PairTile places;
  const float *nx, *ny, *nz;  // laid out as the coordinates: twice, then zeros
};

// An angle lies in the bin of the number of edges whose cosine is larger than its own.
struct OrientedCounter {
  float factor;                        // bins per distance
  float line[pair_angle_bins - 1];     // cosines of the edges
  float normals[pair_angle_bins - 1];  // likewise
  PairCounter table;                   // one pair each; the last entry of a copy is for padding
};
inline constexpr float pair_distance_top = pair_distance_bins - 0.5f;  // the cap on scaled distances
inline constexpr std::uint32_t pad_slot = oriented_pair_bins;
inline constexpr std::size_t oriented_copy_stride = oriented_pair_bins + pair_lanes;

struct OrientedLoops {
  void (*signed_normals)(const OrientedTile&, const OrientedCounter&);  // adds to the table
  void (*either_side)(const OrientedTile&, const OrientedCounter&);
};
extern const OrientedLoops scalar_oriented_loops, avx2_oriented_loops, avx512_oriented_loops;

}  // namespace meander
