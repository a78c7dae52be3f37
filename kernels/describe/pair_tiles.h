// The inner loops of distance_histogram for each instruction set. Internal to kernels/describe.
//
// Pairs are (i, i + s mod n): every row i has the same offsets s = 1 .. (n - 1) / 2, so that all vectors but
// the last of a row are full; an even n has n / 2 pairs more, at offset n / 2. All sets do the same IEEE
// operations on a pair (subtract, multiply, add, square root, multiply, convert), so that they agree to the
// bit; build without contraction.
#pragma once

#include <cstddef>
#include <cstdint>

namespace meander {

inline constexpr std::size_t pair_lanes = 16;  // coordinates are padded to 16 lanes
// The maximum number of offsets of a tile: its points stay in the cache, and 32-bit sums do not overflow.
inline constexpr std::size_t pair_offsets = 512;
inline constexpr float distance_unit = 0x1p23f;  // distances below 2 are summed as integers of this fraction

// Rows [row_begin, row_end) x offsets [offset_begin, offset_end). Coordinates: points 0 .. n - 1 twice, then
// zeros.
struct PairTile {
  const float *x, *y, *z;
  std::size_t row_begin, row_end;
  std::size_t offset_begin, offset_end;
};

// Counts the pairs of a tile by bins. Up to 64 bins two pairs are counted by one increment, at (bin of the
// one) + (bin of the other) x side, where side is a power of two; above, one pair each. Increments rotate
// over the copies of the table, so that few wait for the one before. Vectors are padded with pairs in bin 0,
// whose number follows from that of the pairs.
inline constexpr std::uint32_t max_joint_bins = 64;
struct PairCounter {
  float factor;             // bins per distance
  float top;                // bins - 1/2, the cap on scaled distances
  unsigned side_bits;       // side = 2^side_bits; 0: not joint
  std::size_t copy_stride;  // entries of a copy
  std::uint32_t* table;     // pair_copies copies
};
inline constexpr std::size_t pair_copies = 4;

// Counts table entries; `number` is a multiple of pair_copies.
inline void count_slots(const std::uint32_t* slots, std::size_t number, const PairCounter& counter) {
  std::uint32_t *const a = counter.table, *const b = a + counter.copy_stride,
                       *const c = b + counter.copy_stride, *const d = c + counter.copy_stride;
  for (std::size_t k = 0; k < number; k += pair_copies) {
    ++a[slots[k]];
    ++b[slots[k + 1]];
    ++c[slots[k + 2]];
    ++d[slots[k + 3]];
  }
}

struct PairLoops {
  float (*largest)(const PairTile&);                   // the largest squared distance
  std::uint64_t (*sum)(const PairTile&);               // the sum of distances, each x distance_unit, rounded
  void (*count)(const PairTile&, const PairCounter&);  // adds to the table
};
extern const PairLoops scalar_pair_loops, avx2_pair_loops, avx512_pair_loops;

}  // namespace meander
