#include "kernels/retrieve/row_distances.h"

#include <algorithm>
#include <cfloat>
#include <cstdint>
#include <cstring>

#include "kernels/core/instruction_set.h"

// One text for all instruction sets, in vectors of the compiler (GCC and Clang) as wide as the machine's. It
// is inlined into functions that carry the target themselves: a file compiled with other flags could leave
// AVX code in inline functions that the whole program shares.

// No such vector is passed between functions that are not inlined.
#pragma GCC diagnostic ignored "-Wpsabi"

namespace meander {

namespace {

using Vector4 = float __attribute__((vector_size(16)));
using Vector8 = float __attribute__((vector_size(32)));
using Vector16 = float __attribute__((vector_size(64)));
using Bits4 = std::int32_t __attribute__((vector_size(16)));
using Bits8 = std::int32_t __attribute__((vector_size(32)));
using Bits16 = std::int32_t __attribute__((vector_size(64)));

MEANDER_INLINE Vector4 magnitude(const Vector4& v) {
  return reinterpret_cast<Vector4>(reinterpret_cast<Bits4>(v) & 0x7FFFFFFF);
}
MEANDER_INLINE Vector8 magnitude(const Vector8& v) {
  return reinterpret_cast<Vector8>(reinterpret_cast<Bits8>(v) & 0x7FFFFFFF);
}
MEANDER_INLINE Vector16 magnitude(const Vector16& v) {
  return reinterpret_cast<Vector16>(reinterpret_cast<Bits16>(v) & 0x7FFFFFFF);
}

struct AbsoluteTerm {
  template <class Vector>
  static MEANDER_INLINE Vector of(const Vector& a, const Vector& b) {
    return magnitude(a - b);
  }
};
struct SquaredTerm {
  template <class Vector>
  static MEANDER_INLINE Vector of(const Vector& a, const Vector& b) {
    return (a - b) * (a - b);
  }
};
// Never divides by zero: the numerator is zero where both are zero.
struct RelativeTerm {
  template <class Vector>
  static MEANDER_INLINE Vector of(const Vector& a, const Vector& b) {
    const Vector sum = magnitude(a) + magnitude(b), min = Vector{} + FLT_MIN;
    return (a - b) * (a - b) / (sum < min ? min : sum);
  }
};

// Adds lanes l + 8 to l, then l + 4 to l.
MEANDER_INLINE Vector4 quarter_sum(const Vector4 (&v)[4]) { return (v[0] + v[2]) + (v[1] + v[3]); }
MEANDER_INLINE Vector4 quarter_sum(const Vector8 (&v)[2]) {
  const Vector8 half = v[0] + v[1];
  return __builtin_shufflevector(half, half, 0, 1, 2, 3) + __builtin_shufflevector(half, half, 4, 5, 6, 7);
}
MEANDER_INLINE Vector4 quarter_sum(const Vector16 (&v)[1]) {
  const Vector8 half[2] = {__builtin_shufflevector(v[0], v[0], 0, 1, 2, 3, 4, 5, 6, 7),
                           __builtin_shufflevector(v[0], v[0], 8, 9, 10, 11, 12, 13, 14, 15)};
  return quarter_sum(half);
}

// Does the last two halvings, (v[0] + v[2]) + (v[1] + v[3]), of four vectors at once.
MEANDER_INLINE Vector4 four_sums(const Vector4 (&v)[4]) {
  const Vector4 a =
      __builtin_shufflevector(v[0], v[1], 0, 4, 1, 5) + __builtin_shufflevector(v[0], v[1], 2, 6, 3, 7);
  const Vector4 b =
      __builtin_shufflevector(v[2], v[3], 0, 4, 1, 5) + __builtin_shufflevector(v[2], v[3], 2, 6, 3, 7);
  return __builtin_shufflevector(a, b, 0, 1, 4, 5) + __builtin_shufflevector(a, b, 2, 3, 6, 7);
}

// Adds four rows at a time; `abreast` of them run side by side as far as there are registers, so that their
// sums do not wait for each other.
template <class Term, class Vector, std::size_t abreast>
MEANDER_INLINE void row_distances(const float* query, const float* rows, std::size_t stride,
                                  std::size_t count, float* out) {
  constexpr std::size_t width = sizeof(Vector) / sizeof(float), vectors = distance_lanes / width;
  for (std::size_t i = 0; i < count; i += 4) {
    Vector4 quarters[4];
#pragma GCC unroll 4
    for (std::size_t first = 0; first < 4; first += abreast) {
      const float* row[abreast];
      Vector sums[abreast][vectors];
#pragma GCC unroll 4
      for (std::size_t r = 0; r < abreast; ++r) {
        row[r] = rows + std::min(i + first + r, count - 1) * stride;
#pragma GCC unroll 4
        for (std::size_t v = 0; v < vectors; ++v) sums[r][v] = Vector{};
      }
      for (std::size_t b = 0; b < stride; b += distance_lanes) {
#pragma GCC unroll 4
        for (std::size_t v = 0; v < vectors; ++v) {
          Vector of_query;
          std::memcpy(&of_query, query + b + v * width, sizeof of_query);
#pragma GCC unroll 4
          for (std::size_t r = 0; r < abreast; ++r) {
            Vector of_row;
            std::memcpy(&of_row, row[r] + b + v * width, sizeof of_row);
            sums[r][v] += Term::of(of_query, of_row);
          }
        }
      }
#pragma GCC unroll 4
      for (std::size_t r = 0; r < abreast; ++r) quarters[first + r] = quarter_sum(sums[r]);
    }
    const Vector4 sums = four_sums(quarters);
    if (i + 4 <= count)
      std::memcpy(out + i, &sums, sizeof sums);
    else
      for (std::size_t r = 0; r < count - i; ++r) out[i + r] = sums[r];
  }
}

// A set of loops with the attributes of a target.
#define MEANDER_ROW_DISTANCE_LOOPS(NAME, TARGET, VECTOR, ABREAST)                                        \
  struct NAME {                                                                                          \
    template <class Term>                                                                                \
    TARGET static void run(const float* query, const float* rows, std::size_t stride, std::size_t count, \
                           float* out) {                                                                 \
      row_distances<Term, VECTOR, ABREAST>(query, rows, stride, count, out);                             \
    }                                                                                                    \
    static constexpr RowDistanceLoops loops{run<AbsoluteTerm>, run<SquaredTerm>, run<RelativeTerm>};     \
  };
MEANDER_ROW_DISTANCE_LOOPS(Baseline, , Vector4, 2)
MEANDER_ROW_DISTANCE_LOOPS(Avx2, MEANDER_TARGET("avx2"), Vector8, 4)
MEANDER_ROW_DISTANCE_LOOPS(Avx512, MEANDER_TARGET("avx512f"), Vector16, 4)

}  // namespace

const RowDistanceLoops& row_distance_loops(InstructionSet set) {
  switch (set) {
    case InstructionSet::avx512:
      return Avx512::loops;
    case InstructionSet::avx2:
      return Avx2::loops;
    default:
      return Baseline::loops;
  }
}

}  // namespace meander
