#include <immintrin.h>

#include <utility>

#include "kernels/describe/oriented_tiles.h"

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

struct Vector {
  __m512 x, y, z;
};

MEANDER_AVX512 inline Vector all_of(const float* x, const float* y, const float* z, std::size_t i) {
  return {_mm512_set1_ps(x[i]), _mm512_set1_ps(y[i]), _mm512_set1_ps(z[i])};
}

MEANDER_AVX512 inline Vector load(const float* x, const float* y, const float* z, std::size_t j) {
  return {_mm512_loadu_ps(x + j), _mm512_loadu_ps(y + j), _mm512_loadu_ps(z + j)};
}

MEANDER_AVX512 inline __m512 dot(const Vector& a, const Vector& b) {
  return _mm512_add_ps(_mm512_add_ps(_mm512_mul_ps(a.x, b.x), _mm512_mul_ps(a.y, b.y)),
                       _mm512_mul_ps(a.z, b.z));
}

MEANDER_AVX512 inline __m512 negated(__m512 v) {
  return _mm512_castsi512_ps(
      _mm512_xor_si512(_mm512_castps_si512(v), _mm512_castps_si512(_mm512_set1_ps(-0.0f))));
}

struct Edges {
  __m512 cosine[pair_angle_bins - 1];
};

MEANDER_AVX512 inline Edges edges_of(const float (&cosines)[pair_angle_bins - 1]) {
  return {{_mm512_set1_ps(cosines[0]), _mm512_set1_ps(cosines[1]), _mm512_set1_ps(cosines[2])}};
}

// Edges come multiplied with the unit.
MEANDER_AVX512 inline __m512i bins_of(__m512 value, __m512 first, __m512 second, __m512 third) {
  const __m512i one = _mm512_set1_epi32(1);
  __m512i bins = _mm512_maskz_mov_epi32(_mm512_cmp_ps_mask(value, first, _CMP_LT_OQ), one);
  bins = _mm512_mask_add_epi32(bins, _mm512_cmp_ps_mask(value, second, _CMP_LT_OQ), bins, one);
  return _mm512_mask_add_epi32(bins, _mm512_cmp_ps_mask(value, third, _CMP_LT_OQ), bins, one);
}

struct Row {
  Vector place, normal;
};

struct Constants {
  Edges line, normals;
  __m512 factor, top;
};

template <NormalSense sense>
MEANDER_AVX512 inline __m512i slots_of(const OrientedTile& tile, const Row& row, std::size_t j,
                                       const Constants& constants) {
  const Vector to = load(tile.places.x, tile.places.y, tile.places.z, j);
  const Vector d = {_mm512_sub_ps(to.x, row.place.x), _mm512_sub_ps(to.y, row.place.y),
                    _mm512_sub_ps(to.z, row.place.z)};
  const Vector normal = load(tile.nx, tile.ny, tile.nz, j);
  const __m512 distance = _mm512_sqrt_ps(dot(d, d));
  __m512 first = dot(row.normal, d), second = negated(dot(normal, d)), between = dot(row.normal, normal);
  if constexpr (sense == NormalSense::either_side) {
    first = _mm512_abs_ps(first);
    second = _mm512_abs_ps(second);
    between = _mm512_abs_ps(between);
  }
  const __m512 e0 = _mm512_mul_ps(constants.line.cosine[0], distance),
               e1 = _mm512_mul_ps(constants.line.cosine[1], distance),
               e2 = _mm512_mul_ps(constants.line.cosine[2], distance);
  const __m512i a = bins_of(first, e0, e1, e2), b = bins_of(second, e0, e1, e2);
  const __m512i c =
      bins_of(between, constants.normals.cosine[0], constants.normals.cosine[1], constants.normals.cosine[2]);
  const __m512i far =
      _mm512_cvttps_epi32(_mm512_min_ps(_mm512_mul_ps(distance, constants.factor), constants.top));
  const __m512i head = _mm512_or_si512(_mm512_slli_epi32(far, 6), c);
  const __m512i angles = _mm512_or_si512(_mm512_slli_epi32(_mm512_min_epi32(a, b), 4),
                                         _mm512_slli_epi32(_mm512_max_epi32(a, b), 2));
  return _mm512_or_si512(head, angles);
}

// The last vector of a row: pads go to an entry of their own.
MEANDER_AVX512 inline __m512i padded(__m512i slots, std::size_t used) {
  return _mm512_mask_mov_epi32(_mm512_set1_epi32(static_cast<int>(pad_slot)),
                               static_cast<__mmask16>((1u << used) - 1), slots);
}

template <NormalSense sense>
MEANDER_AVX512 void count(const OrientedTile& tile, const OrientedCounter& counter) {
  const PairTile& at = tile.places;
  const std::size_t length = at.offset_end - at.offset_begin, full = length / lanes * lanes;
  const Constants constants = {edges_of(counter.line), edges_of(counter.normals),
                               _mm512_set1_ps(counter.factor), _mm512_set1_ps(pair_distance_top)};
  // Table entries of a row are counted while those of the next are computed, as in the loops of distances.
  std::uint32_t buffers[2][pair_offsets];
  for (std::uint32_t& slot : buffers[1]) slot = pad_slot;
  std::uint32_t *slots = buffers[0], *before = buffers[1];
  for (std::size_t i = at.row_begin; i < at.row_end; ++i, std::swap(slots, before)) {
    const Row row = {all_of(at.x, at.y, at.z, i), all_of(tile.nx, tile.ny, tile.nz, i)};
    const std::size_t first = i + at.offset_begin;
    for (std::size_t k = 0; k < full; k += lanes) {
      _mm512_storeu_si512(slots + k, slots_of<sense>(tile, row, first + k, constants));
      count_slots(before + k, lanes, counter.table);
    }
    if (full < length) {
      _mm512_storeu_si512(slots + full,
                          padded(slots_of<sense>(tile, row, first + full, constants), length - full));
      count_slots(before + full, lanes, counter.table);
    }
  }
  count_slots(before, (length + lanes - 1) / lanes * lanes, counter.table);
}

}  // namespace

const OrientedLoops avx512_oriented_loops{count<NormalSense::signed_normals>,
                                          count<NormalSense::either_side>};

}  // namespace meander
