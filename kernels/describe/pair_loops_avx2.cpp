#include <immintrin.h>

#include <cstddef>
#include <cstdint>

#define MEANDER_LANES __attribute__((target("avx2")))

namespace meander {

namespace {

constexpr std::size_t lanes = 8;
using Floats = __m256;
using Ints = __m256i;

MEANDER_LANES inline Floats all(float value) { return _mm256_set1_ps(value); }
MEANDER_LANES inline Floats load(const float* from) { return _mm256_loadu_ps(from); }
MEANDER_LANES inline Floats root(Floats v) { return _mm256_sqrt_ps(v); }
MEANDER_LANES inline Floats larger(Floats a, Floats b) { return _mm256_max_ps(a, b); }
MEANDER_LANES inline Floats smaller(Floats a, Floats b) { return _mm256_min_ps(a, b); }
MEANDER_LANES inline Floats magnitude(Floats v) { return _mm256_andnot_ps(all(-0.0f), v); }
MEANDER_LANES inline Ints rounded(Floats v) { return _mm256_cvtps_epi32(v); }
MEANDER_LANES inline Ints truncated(Floats v) { return _mm256_cvttps_epi32(v); }

MEANDER_LANES inline Ints zeros() { return _mm256_setzero_si256(); }
MEANDER_LANES inline Ints added(Ints a, Ints b) { return _mm256_add_epi32(a, b); }
MEANDER_LANES inline void store(Ints v, std::uint32_t* to) {
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(to), v);
}

// All ones in the first `used` lanes, zeros in the others.
MEANDER_LANES inline Ints first_lanes(std::size_t used) {
  const Ints lane = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
  return _mm256_cmpgt_epi32(_mm256_set1_epi32(static_cast<int>(used)), lane);
}
MEANDER_LANES inline Floats first_lanes(Floats v, std::size_t used) {
  return _mm256_and_ps(_mm256_castsi256_ps(first_lanes(used)), v);
}
MEANDER_LANES inline Ints first_lanes_else(Ints v, std::size_t used, std::uint32_t other) {
  return _mm256_blendv_epi8(_mm256_set1_epi32(static_cast<int>(other)), v, first_lanes(used));
}

MEANDER_LANES inline float largest_lane(Floats v) {
  alignas(32) float lane[lanes];
  _mm256_store_ps(lane, v);
  float result = 0;
  for (const float value : lane) result = value > result ? value : result;
  return result;
}
// Adds lanes of 32 bits to lanes of 64.
MEANDER_LANES inline Ints with_wide_lanes(Ints total, Ints v) {
  total = _mm256_add_epi64(total, _mm256_srli_epi64(v, 32));
  return _mm256_add_epi64(total, _mm256_and_si256(v, _mm256_set1_epi64x(0xFFFFFFFF)));
}
MEANDER_LANES inline std::uint64_t sum_of_wide_lanes(Ints total) {
  alignas(32) std::uint64_t lane[4];
  _mm256_store_si256(reinterpret_cast<__m256i*>(lane), total);
  return lane[0] + lane[1] + lane[2] + lane[3];
}

// One entry for each two bins.
MEANDER_LANES inline void store_joint(Ints bins, __m128i shift, std::uint32_t* to) {
  const Ints both = _mm256_or_si256(bins, _mm256_srl_epi64(bins, shift));
  const Ints order = _mm256_setr_epi32(0, 2, 4, 6, 1, 3, 5, 7);
  _mm_storeu_si128(reinterpret_cast<__m128i*>(to),
                   _mm256_castsi256_si128(_mm256_permutevar8x32_epi32(both, order)));
}

// By how many of the bounds each value is exceeded. A comparison is -1 where it holds.
MEANDER_LANES inline Ints lanes_below(Floats value, Floats first, Floats second, Floats third) {
  const Ints below = added(added(_mm256_castps_si256(_mm256_cmp_ps(value, first, _CMP_LT_OQ)),
                                 _mm256_castps_si256(_mm256_cmp_ps(value, second, _CMP_LT_OQ))),
                           _mm256_castps_si256(_mm256_cmp_ps(value, third, _CMP_LT_OQ)));
  return _mm256_sub_epi32(zeros(), below);
}
// The entry of a pair by its bins: distance, both angles with the line, angle between the normals.
MEANDER_LANES inline Ints slot_of(Ints distance, Ints a, Ints b, Ints between) {
  const Ints head = _mm256_or_si256(_mm256_slli_epi32(distance, 6), between);
  const Ints angles = _mm256_or_si256(_mm256_slli_epi32(_mm256_min_epi32(a, b), 4),
                                      _mm256_slli_epi32(_mm256_max_epi32(a, b), 2));
  return _mm256_or_si256(head, angles);
}

}  // namespace

}  // namespace meander

#include "kernels/describe/vector_pair_loops.h"

namespace meander {

const PairLoops avx2_pair_loops = pair_loops_in_vectors;
const OrientedLoops avx2_oriented_loops = oriented_loops_in_vectors;

}  // namespace meander
