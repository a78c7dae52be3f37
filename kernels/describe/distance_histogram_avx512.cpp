#include <immintrin.h>

#include <utility>

#include "kernels/describe/pair_tiles.h"

// Functions carry the target themselves: a file compiled with other flags could leave AVX-512 code in inline
// functions that the whole program shares.
#define MEANDER_AVX512 __attribute__((target("avx512f")))

#if defined(__GNUC__) && !defined(__clang__)
// GCC 12 warns about the undefined pass-through operands of its own intrinsics (GCC bug 105593).
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#pragma GCC diagnostic ignored "-Wuninitialized"
#endif

namespace meander {

namespace {

constexpr std::size_t lanes = 16;

struct Point {
  __m512 x, y, z;
};

MEANDER_AVX512 inline Point point_of(const PairTile& tile, std::size_t i) {
  return {_mm512_set1_ps(tile.x[i]), _mm512_set1_ps(tile.y[i]), _mm512_set1_ps(tile.z[i])};
}

MEANDER_AVX512 inline __m512 squared_distances(const PairTile& tile, const Point& p, std::size_t j) {
  const __m512 dx = _mm512_sub_ps(p.x, _mm512_loadu_ps(tile.x + j));
  const __m512 dy = _mm512_sub_ps(p.y, _mm512_loadu_ps(tile.y + j));
  const __m512 dz = _mm512_sub_ps(p.z, _mm512_loadu_ps(tile.z + j));
  return _mm512_add_ps(_mm512_add_ps(_mm512_mul_ps(dx, dx), _mm512_mul_ps(dy, dy)), _mm512_mul_ps(dz, dz));
}

// The last vector of a row: pads are distance 0.
MEANDER_AVX512 inline __m512 last_squared_distances(const PairTile& tile, const Point& p, std::size_t j,
                                                    std::size_t used) {
  return _mm512_maskz_mov_ps(static_cast<__mmask16>((1u << used) - 1), squared_distances(tile, p, j));
}

MEANDER_AVX512 float largest(const PairTile& tile) {
  const std::size_t length = tile.offset_end - tile.offset_begin, full = length / lanes * lanes;
  __m512 most = _mm512_setzero_ps();
  for (std::size_t i = tile.row_begin; i < tile.row_end; ++i) {
    const Point p = point_of(tile, i);
    const std::size_t first = i + tile.offset_begin;
    for (std::size_t k = 0; k < full; k += lanes)
      most = _mm512_max_ps(most, squared_distances(tile, p, first + k));
    if (full < length)
      most = _mm512_max_ps(most, last_squared_distances(tile, p, first + full, length - full));
  }
  return _mm512_reduce_max_ps(most);
}

MEANDER_AVX512 inline __m512i units_of(__m512 squared) {
  return _mm512_cvtps_epi32(_mm512_mul_ps(_mm512_sqrt_ps(squared), _mm512_set1_ps(distance_unit)));
}

MEANDER_AVX512 std::uint64_t sum(const PairTile& tile) {
  const std::size_t length = tile.offset_end - tile.offset_begin, full = length / lanes * lanes;
  __m512i total = _mm512_setzero_si512();
  for (std::size_t i = tile.row_begin; i < tile.row_end; ++i) {
    const Point p = point_of(tile, i);
    const std::size_t first = i + tile.offset_begin;
    __m512i row = _mm512_setzero_si512();  // pair_offsets / 16 terms below 2^24 a lane
    for (std::size_t k = 0; k < full; k += lanes)
      row = _mm512_add_epi32(row, units_of(squared_distances(tile, p, first + k)));
    if (full < length)
      row = _mm512_add_epi32(row, units_of(last_squared_distances(tile, p, first + full, length - full)));
    total = _mm512_add_epi64(total, _mm512_srli_epi64(row, 32));
    total = _mm512_add_epi64(total, _mm512_and_si512(row, _mm512_set1_epi64(0xFFFFFFFF)));
  }
  return static_cast<std::uint64_t>(_mm512_reduce_add_epi64(total));
}

// Writes the table entries of a vector of distances.
template <bool joint>
MEANDER_AVX512 inline void write_slots(__m512 squared, __m512 factor, __m512 top, __m128i shift,
                                       std::uint32_t* slots) {
  const __m512i bins =
      _mm512_cvttps_epi32(_mm512_min_ps(_mm512_mul_ps(_mm512_sqrt_ps(squared), factor), top));
  if constexpr (joint)
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(slots),
                        _mm512_cvtepi64_epi32(_mm512_or_si512(bins, _mm512_srl_epi64(bins, shift))));
  else
    _mm512_storeu_si512(slots, bins);
}

template <bool joint>
MEANDER_AVX512 void count_pairs(const PairTile& tile, const PairCounter& counter) {
  constexpr std::size_t share = joint ? 2 : 1;
  const std::size_t length = tile.offset_end - tile.offset_begin, full = length / lanes * lanes;
  const __m512 factor = _mm512_set1_ps(counter.factor), top = _mm512_set1_ps(counter.top);
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

const PairLoops avx512_pair_loops{largest, sum, count};

}  // namespace meander
