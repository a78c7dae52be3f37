#include <immintrin.h>

#include <utility>

#include "kernels/describe/pair_tiles.h"

// Functions carry the target themselves: a file compiled with other flags could leave AVX2 code in inline
// functions that the whole program shares.
#define MEANDER_AVX2 __attribute__((target("avx2")))

namespace meander {

namespace {

constexpr std::size_t lanes = 8;

struct Point {
  __m256 x, y, z;
};

MEANDER_AVX2 inline Point point_of(const PairTile& tile, std::size_t i) {
  return {_mm256_set1_ps(tile.x[i]), _mm256_set1_ps(tile.y[i]), _mm256_set1_ps(tile.z[i])};
}

MEANDER_AVX2 inline __m256 squared_distances(const PairTile& tile, const Point& p, std::size_t j) {
  const __m256 dx = _mm256_sub_ps(p.x, _mm256_loadu_ps(tile.x + j));
  const __m256 dy = _mm256_sub_ps(p.y, _mm256_loadu_ps(tile.y + j));
  const __m256 dz = _mm256_sub_ps(p.z, _mm256_loadu_ps(tile.z + j));
  return _mm256_add_ps(_mm256_add_ps(_mm256_mul_ps(dx, dx), _mm256_mul_ps(dy, dy)), _mm256_mul_ps(dz, dz));
}

// The last vector of a row: pads are distance 0.
MEANDER_AVX2 inline __m256 last_squared_distances(const PairTile& tile, const Point& p, std::size_t j,
                                                  std::size_t used) {
  const __m256i lane = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
  const __m256i kept = _mm256_cmpgt_epi32(_mm256_set1_epi32(static_cast<int>(used)), lane);
  return _mm256_and_ps(_mm256_castsi256_ps(kept), squared_distances(tile, p, j));
}

MEANDER_AVX2 float largest(const PairTile& tile) {
  const std::size_t length = tile.offset_end - tile.offset_begin, full = length / lanes * lanes;
  __m256 most = _mm256_setzero_ps();
  for (std::size_t i = tile.row_begin; i < tile.row_end; ++i) {
    const Point p = point_of(tile, i);
    const std::size_t first = i + tile.offset_begin;
    for (std::size_t k = 0; k < full; k += lanes)
      most = _mm256_max_ps(most, squared_distances(tile, p, first + k));
    if (full < length)
      most = _mm256_max_ps(most, last_squared_distances(tile, p, first + full, length - full));
  }
  alignas(32) float lane[lanes];
  _mm256_store_ps(lane, most);
  float result = 0;
  for (const float value : lane) result = value > result ? value : result;
  return result;
}

MEANDER_AVX2 inline __m256i units_of(__m256 squared) {
  return _mm256_cvtps_epi32(_mm256_mul_ps(_mm256_sqrt_ps(squared), _mm256_set1_ps(distance_unit)));
}

MEANDER_AVX2 std::uint64_t sum(const PairTile& tile) {
  const std::size_t length = tile.offset_end - tile.offset_begin, full = length / lanes * lanes;
  __m256i total = _mm256_setzero_si256();
  for (std::size_t i = tile.row_begin; i < tile.row_end; ++i) {
    const Point p = point_of(tile, i);
    const std::size_t first = i + tile.offset_begin;
    __m256i row = _mm256_setzero_si256();  // pair_offsets / 8 terms below 2^24 a lane
    for (std::size_t k = 0; k < full; k += lanes)
      row = _mm256_add_epi32(row, units_of(squared_distances(tile, p, first + k)));
    if (full < length)
      row = _mm256_add_epi32(row, units_of(last_squared_distances(tile, p, first + full, length - full)));
    total = _mm256_add_epi64(total, _mm256_srli_epi64(row, 32));
    total = _mm256_add_epi64(total, _mm256_and_si256(row, _mm256_set1_epi64x(0xFFFFFFFF)));
  }
  alignas(32) std::uint64_t lane[4];
  _mm256_store_si256(reinterpret_cast<__m256i*>(lane), total);
  return lane[0] + lane[1] + lane[2] + lane[3];
}

// Writes the table entries of a vector of distances.
template <bool joint>
MEANDER_AVX2 inline void write_slots(__m256 squared, __m256 factor, __m256 top, __m128i shift,
                                     std::uint32_t* slots) {
  const __m256i bins =
      _mm256_cvttps_epi32(_mm256_min_ps(_mm256_mul_ps(_mm256_sqrt_ps(squared), factor), top));
  if constexpr (joint) {
    const __m256i both = _mm256_or_si256(bins, _mm256_srl_epi64(bins, shift));
    const __m256i order = _mm256_setr_epi32(0, 2, 4, 6, 1, 3, 5, 7);
    _mm_storeu_si128(reinterpret_cast<__m128i*>(slots),
                     _mm256_castsi256_si128(_mm256_permutevar8x32_epi32(both, order)));
  } else {
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(slots), bins);
  }
}

template <bool joint>
MEANDER_AVX2 void count_pairs(const PairTile& tile, const PairCounter& counter) {
  constexpr std::size_t share = joint ? 2 : 1;
  const std::size_t length = tile.offset_end - tile.offset_begin, full = length / lanes * lanes;
  const __m256 factor = _mm256_set1_ps(counter.factor), top = _mm256_set1_ps(counter.top);
  const __m128i shift = _mm_cvtsi32_si128(32 - static_cast<int>(counter.side_bits));
  // Table entries of a row are counted while those of the next are computed: the two wait for different parts
  // of the processor. Before the first row there are pads.
  std::uint32_t buffers[2][pair_offsets] = {};
  std::uint32_t *slots = buffers[0], *before = buffers[1];
  for (std::size_t i = tile.row_begin; i < tile.row_end; ++i, std::swap(slots, before)) {
    const Point p = point_of(tile, i);
    const std::size_t first = i + tile.offset_begin;
    for (std::size_t k = 0; k < full; k += lanes) {
      write_slots<joint>(squared_distances(tile, p, first + k), factor, top, shift, slots + k / share);
      count_slots(before + k / share, lanes / share, counter);
    }
    if (full < length) {
      write_slots<joint>(last_squared_distances(tile, p, first + full, length - full), factor, top, shift,
                         slots + full / share);
      count_slots(before + full / share, lanes / share, counter);
    }
  }
  count_slots(before, (length + lanes - 1) / lanes * lanes / share, counter);
}

void count(const PairTile& tile, const PairCounter& counter) {
  if (counter.side_bits > 0)
    count_pairs<true>(tile, counter);
  else
    count_pairs<false>(tile, counter);
}

}  // namespace

const PairLoops avx2_pair_loops{largest, sum, count};

}  // namespace meander
