#include <immintrin.h>

#include <utility>

#include "kernels/describe/oriented_tiles.h"

// Functions carry the target themselves: a file compiled with other flags could leave AVX2 code in inline
// functions that the whole program shares.
#define MEANDER_AVX2 __attribute__((target("avx2")))

namespace meander {

namespace {

constexpr std::size_t lanes = 8;

struct Vector {
  __m256 x, y, z;
};

MEANDER_AVX2 inline Vector all_of(const float* x, const float* y, const float* z, std::size_t i) {
  return {_mm256_set1_ps(x[i]), _mm256_set1_ps(y[i]), _mm256_set1_ps(z[i])};
}

MEANDER_AVX2 inline Vector load(const float* x, const float* y, const float* z, std::size_t j) {
  return {_mm256_loadu_ps(x + j), _mm256_loadu_ps(y + j), _mm256_loadu_ps(z + j)};
}

MEANDER_AVX2 inline __m256 dot(const Vector& a, const Vector& b) {
  return _mm256_add_ps(_mm256_add_ps(_mm256_mul_ps(a.x, b.x), _mm256_mul_ps(a.y, b.y)),
                       _mm256_mul_ps(a.z, b.z));
}

MEANDER_AVX2 inline __m256 negated(__m256 v) { return _mm256_xor_ps(v, _mm256_set1_ps(-0.0f)); }
MEANDER_AVX2 inline __m256 magnitude(__m256 v) { return _mm256_andnot_ps(_mm256_set1_ps(-0.0f), v); }

struct Edges {
  __m256 cosine[pair_angle_bins - 1];
};

MEANDER_AVX2 inline Edges edges_of(const float (&cosines)[pair_angle_bins - 1]) {
  return {{_mm256_set1_ps(cosines[0]), _mm256_set1_ps(cosines[1]), _mm256_set1_ps(cosines[2])}};
}

// Edges come multiplied with the unit. A comparison is -1 where it holds.
MEANDER_AVX2 inline __m256i bins_of(__m256 value, __m256 first, __m256 second, __m256 third) {
  const __m256i below =
      _mm256_add_epi32(_mm256_add_epi32(_mm256_castps_si256(_mm256_cmp_ps(value, first, _CMP_LT_OQ)),
                                        _mm256_castps_si256(_mm256_cmp_ps(value, second, _CMP_LT_OQ))),
                       _mm256_castps_si256(_mm256_cmp_ps(value, third, _CMP_LT_OQ)));
  return _mm256_sub_epi32(_mm256_setzero_si256(), below);
}

struct Row {
  Vector place, normal;
};

struct Constants {
  Edges line, normals;
  __m256 factor, top;
};

template <NormalSense sense>
MEANDER_AVX2 inline __m256i slots_of(const OrientedTile& tile, const Row& row, std::size_t j,
                                     const Constants& constants) {
  const Vector to = load(tile.places.x, tile.places.y, tile.places.z, j);
  const Vector d = {_mm256_sub_ps(to.x, row.place.x), _mm256_sub_ps(to.y, row.place.y),
                    _mm256_sub_ps(to.z, row.place.z)};
  const Vector normal = load(tile.nx, tile.ny, tile.nz, j);
  const __m256 distance = _mm256_sqrt_ps(dot(d, d));
  __m256 first = dot(row.normal, d), second = negated(dot(normal, d)), between = dot(row.normal, normal);
  if constexpr (sense == NormalSense::either_side) {
    first = magnitude(first);
    second = magnitude(second);
    between = magnitude(between);
  }
  const __m256 e0 = _mm256_mul_ps(constants.line.cosine[0], distance),
               e1 = _mm256_mul_ps(constants.line.cosine[1], distance),
               e2 = _mm256_mul_ps(constants.line.cosine[2], distance);
  const __m256i a = bins_of(first, e0, e1, e2), b = bins_of(second, e0, e1, e2);
  const __m256i c =
      bins_of(between, constants.normals.cosine[0], constants.normals.cosine[1], constants.normals.cosine[2]);
  const __m256i far =
      _mm256_cvttps_epi32(_mm256_min_ps(_mm256_mul_ps(distance, constants.factor), constants.top));
  const __m256i head = _mm256_or_si256(_mm256_slli_epi32(far, 6), c);
  const __m256i angles = _mm256_or_si256(_mm256_slli_epi32(_mm256_min_epi32(a, b), 4),
                                         _mm256_slli_epi32(_mm256_max_epi32(a, b), 2));
  return _mm256_or_si256(head, angles);
}

MEANDER_AVX2 inline void write(__m256i slots, std::uint32_t* to) {
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(to), slots);
}

// The last vector of a row: pads go to an entry of their own.
MEANDER_AVX2 inline __m256i padded(__m256i slots, std::size_t used) {
  const __m256i lane = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
  const __m256i kept = _mm256_cmpgt_epi32(_mm256_set1_epi32(static_cast<int>(used)), lane);
  return _mm256_blendv_epi8(_mm256_set1_epi32(static_cast<int>(pad_slot)), slots, kept);
}

template <NormalSense sense>
MEANDER_AVX2 void count(const OrientedTile& tile, const OrientedCounter& counter) {
  const PairTile& at = tile.places;
  const std::size_t length = at.offset_end - at.offset_begin, full = length / lanes * lanes;
  const Constants constants = {edges_of(counter.line), edges_of(counter.normals),
                               _mm256_set1_ps(counter.factor), _mm256_set1_ps(pair_distance_top)};
  // Table entries of a row are counted while those of the next are computed, as in the loops of distances.
  std::uint32_t buffers[2][pair_offsets];
  for (std::uint32_t& slot : buffers[1]) slot = pad_slot;
  std::uint32_t *slots = buffers[0], *before = buffers[1];
  for (std::size_t i = at.row_begin; i < at.row_end; ++i, std::swap(slots, before)) {
    const Row row = {all_of(at.x, at.y, at.z, i), all_of(tile.nx, tile.ny, tile.nz, i)};
    const std::size_t first = i + at.offset_begin;
    for (std::size_t k = 0; k < full; k += lanes) {
      write(slots_of<sense>(tile, row, first + k, constants), slots + k);
      count_slots(before + k, lanes, counter.table);
    }
    if (full < length) {
      write(padded(slots_of<sense>(tile, row, first + full, constants), length - full), slots + full);
      count_slots(before + full, lanes, counter.table);
    }
  }
  count_slots(before, (length + lanes - 1) / lanes * lanes, counter.table);
}

}  // namespace

const OrientedLoops avx2_oriented_loops{count<NormalSense::signed_normals>, count<NormalSense::either_side>};

}  // namespace meander
