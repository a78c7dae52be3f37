#include <immintrin.h>

#include <cstddef>
#include <cstdint>

#define MEANDER_LANES __attribute__((target("avx512f")))

#if defined(__GNUC__) && !defined(__clang__)
// GCC 12 warns about the undefined pass-through operands of its own intrinsics (GCC bug 105593).
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#pragma GCC diagnostic ignored "-Wuninitialized"
#endif

namespace meander {

namespace {

constexpr std::size_t lanes = 16;
using Floats = __m512;
using Ints = __m512i;

MEANDER_LANES inline Floats all(float value) { return _mm512_set1_ps(value); }
MEANDER_LANES inline Floats load(const float* from) { return _mm512_loadu_ps(from); }
MEANDER_LANES inline Floats root(Floats v) { return _mm512_sqrt_ps(v); }
MEANDER_LANES inline Floats larger(Floats a, Floats b) { return _mm512_max_ps(a, b); }
MEANDER_LANES inline Floats smaller(Floats a, Floats b) { return _mm512_min_ps(a, b); }
MEANDER_LANES inline Floats magnitude(Floats v) { return _mm512_abs_ps(v); }
MEANDER_LANES inline Ints rounded(Floats v) { return _mm512_cvtps_epi32(v); }
MEANDER_LANES inline Ints truncated(Floats v) { return _mm512_cvttps_epi32(v); }

MEANDER_LANES inline Ints zeros() { return _mm512_setzero_si512(); }
MEANDER_LANES inline Ints added(Ints a, Ints b) { return _mm512_add_epi32(a, b); }
MEANDER_LANES inline void store(Ints v, std::uint32_t* to) { _mm512_storeu_si512(to, v); }

MEANDER_LANES inline __mmask16 first_lanes(std::size_t used) {
  return static_cast<__mmask16>((1u << used) - 1);
}
MEANDER_LANES inline Floats first_lanes(Floats v, std::size_t used) {
  return _mm512_maskz_mov_ps(first_lanes(used), v);
}
MEANDER_LANES inline Ints first_lanes_else(Ints v, std::size_t used, std::uint32_t other) {
  return _mm512_mask_mov_epi32(_mm512_set1_epi32(static_cast<int>(other)), first_lanes(used), v);
}

MEANDER_LANES inline float largest_lane(Floats v) { return _mm512_reduce_max_ps(v); }
// Adds lanes of 32 bits to lanes of 64.
MEANDER_LANES inline Ints with_wide_lanes(Ints total, Ints v) {
  total = _mm512_add_epi64(total, _mm512_srli_epi64(v, 32));
  return _mm512_add_epi64(total, _mm512_and_si512(v, _mm512_set1_epi64(0xFFFFFFFF)));
}
MEANDER_LANES inline std::uint64_t sum_of_wide_lanes(Ints total) {
  return static_cast<std::uint64_t>(_mm512_reduce_add_epi64(total));
}

// One entry for each two bins.
MEANDER_LANES inline void store_joint(Ints bins, __m128i shift, std::uint32_t* to) {
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(to),
                      _mm512_cvtepi64_epi32(_mm512_or_si512(bins, _mm512_srl_epi64(bins, shift))));
}

// By how many of the bounds each value is exceeded.
MEANDER_LANES inline Ints lanes_below(Floats value, Floats first, Floats second, Floats third) {
  const Ints one = _mm512_set1_epi32(1);
  Ints bins = _mm512_maskz_mov_epi32(_mm512_cmp_ps_mask(value, first, _CMP_LT_OQ), one);
  bins = _mm512_mask_add_epi32(bins, _mm512_cmp_ps_mask(value, second, _CMP_LT_OQ), bins, one);
  return _mm512_mask_add_epi32(bins, _mm512_cmp_ps_mask(value, third, _CMP_LT_OQ), bins, one);
}
// The entry of a pair by its bins: distance, both angles with the line, angle between the normals.
MEANDER_LANES inline Ints slot_of(Ints distance, Ints a, Ints b, Ints between) {
  const Ints head = _mm512_or_si512(_mm512_slli_epi32(distance, 6), between);
  const Ints angles = _mm512_or_si512(_mm512_slli_epi32(_mm512_min_epi32(a, b), 4),
                                      _mm512_slli_epi32(_mm512_max_epi32(a, b), 2));
  return _mm512_or_si512(head, angles);
}

}  // namespace

}  // namespace meander

#include "kernels/describe/vector_pair_loops.h"

namespace meander {

const PairLoops avx512_pair_loops = pair_loops_in_vectors;
const OrientedLoops avx512_oriented_loops = oriented_loops_in_vectors;

}  // namespace meander
