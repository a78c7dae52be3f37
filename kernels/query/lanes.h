// Eight floats, or four doubles, at a time, as pairs of the vectors that all processors have, and eight
// floats as one vector. Internal to kernels/query.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <type_traits>

#include "kernels/core/instruction_set.h"
#include "kernels/core/vector_instructions.h"
#include "kernels/query/triangle_tree.h"
#if defined(__x86_64__)
#include <immintrin.h>
#endif

// No wide vector is passed between functions that are not inlined.
#pragma GCC diagnostic ignored "-Wpsabi"

namespace meander::lanes {

inline constexpr std::size_t count = TriangleTree::fan;
using Floats4 = float __attribute__((vector_size(16)));
using Doubles2 = double __attribute__((vector_size(16)));

template <class Half>
struct Pair {
  Half low, high;
};
using Floats = Pair<Floats4>;
using Doubles = Pair<Doubles2>;
// For functions with instructions of AVX2 (MEANDER_TARGET), into which everything here is inlined.
using WideFloats = float __attribute__((vector_size(32)));
using WideMask = std::int32_t __attribute__((vector_size(32)));
using WideDoubles = double __attribute__((vector_size(32)));
using WideLongMask = std::int64_t __attribute__((vector_size(32)));

// The vectors of a loop: those that all processors have, and those of AVX2 (takes_avx2).
struct Pairs {
  using Floats = lanes::Floats;
  using Doubles = lanes::Doubles;
};
struct Wide {
  using Floats = WideFloats;
  using Doubles = WideDoubles;
};

#define MEANDER_PAIR_OPERATOR(OP)                                                                        \
  template <class Half>                                                                                  \
  MEANDER_INLINE auto operator OP(const Pair<Half>& a, const Pair<Half>& b) {                            \
    return Pair<decltype(a.low OP b.low)>{a.low OP b.low, a.high OP b.high};                             \
  }                                                                                                      \
  template <class Half, class Number>                                                                    \
  requires std::is_arithmetic_v<Number> MEANDER_INLINE auto operator OP(const Pair<Half>& a, Number b) { \
    return Pair<decltype(a.low OP b)>{a.low OP b, a.high OP b};                                          \
  }                                                                                                      \
  template <class Half, class Number>                                                                    \
  requires std::is_arithmetic_v<Number> MEANDER_INLINE auto operator OP(Number a, const Pair<Half>& b) { \
    return Pair<decltype(a OP b.low)>{a OP b.low, a OP b.high};                                          \
  }
MEANDER_PAIR_OPERATOR(+)
MEANDER_PAIR_OPERATOR(-)
MEANDER_PAIR_OPERATOR(*)
MEANDER_PAIR_OPERATOR(/)
MEANDER_PAIR_OPERATOR(&)
MEANDER_PAIR_OPERATOR(|)
MEANDER_PAIR_OPERATOR(<)
MEANDER_PAIR_OPERATOR(>)
MEANDER_PAIR_OPERATOR(<=)
MEANDER_PAIR_OPERATOR(>=)
MEANDER_PAIR_OPERATOR(==)
#undef MEANDER_PAIR_OPERATOR

// Where the mask holds yes, elsewhere no.
template <class Mask, class Half>
MEANDER_INLINE Pair<Half> select(const Pair<Mask>& mask, const Pair<Half>& yes, const Pair<Half>& no) {
  return {mask.low ? yes.low : no.low, mask.high ? yes.high : no.high};
}

MEANDER_INLINE WideFloats select(const WideMask& mask, const WideFloats& yes, const WideFloats& no) {
  return mask ? yes : no;
}
MEANDER_INLINE WideDoubles select(const WideLongMask& mask, const WideDoubles& yes, const WideDoubles& no) {
  return mask ? yes : no;
}

// b where one is no number.
MEANDER_INLINE Floats larger(const Floats& a, const Floats& b) {
  return {std::bit_cast<Floats4>(_mm_max_ps(std::bit_cast<__m128>(a.low), std::bit_cast<__m128>(b.low))),
          std::bit_cast<Floats4>(_mm_max_ps(std::bit_cast<__m128>(a.high), std::bit_cast<__m128>(b.high)))};
}
MEANDER_INLINE Floats smaller(const Floats& a, const Floats& b) {
  return {std::bit_cast<Floats4>(_mm_min_ps(std::bit_cast<__m128>(a.low), std::bit_cast<__m128>(b.low))),
          std::bit_cast<Floats4>(_mm_min_ps(std::bit_cast<__m128>(a.high), std::bit_cast<__m128>(b.high)))};
}
MEANDER_INLINE Doubles larger(const Doubles& a, const Doubles& b) { return select(a > b, a, b); }
MEANDER_INLINE WideFloats larger(const WideFloats& a, const WideFloats& b) { return a > b ? a : b; }
MEANDER_INLINE WideDoubles larger(const WideDoubles& a, const WideDoubles& b) { return a > b ? a : b; }
MEANDER_INLINE WideFloats smaller(const WideFloats& a, const WideFloats& b) { return a < b ? a : b; }

template <class Vector, class Value>
MEANDER_INLINE Vector load(const Value* from) {
  Vector vector;
  std::memcpy(&vector, from, sizeof vector);
  return vector;
}
template <class Vector, class Value>
MEANDER_INLINE void store(const Vector& vector, Value* to) {
  std::memcpy(to, &vector, sizeof vector);
}

// All the same. Not a sum with zeros, which compilers would carry out.
template <class Vector>
struct Repeated;
template <class Half>
struct Repeated<Pair<Half>> {
  template <class Value>
  static MEANDER_INLINE Pair<Half> of(Value value) {
    return {Repeated<Half>::of(value), Repeated<Half>::of(value)};
  }
};
template <>
struct Repeated<Floats4> {
  static MEANDER_INLINE Floats4 of(float v) { return Floats4{v, v, v, v}; }
};
template <>
struct Repeated<Doubles2> {
  static MEANDER_INLINE Doubles2 of(double v) { return Doubles2{v, v}; }
};
template <>
struct Repeated<WideFloats> {
  static MEANDER_INLINE WideFloats of(float v) { return WideFloats{v, v, v, v, v, v, v, v}; }
};
template <>
struct Repeated<WideDoubles> {
  static MEANDER_INLINE WideDoubles of(double v) { return WideDoubles{v, v, v, v}; }
};
template <class Vector, class Value>
MEANDER_INLINE Vector all(Value value) {
  return Repeated<Vector>::of(value);
}

// Correctly rounded on every processor.
MEANDER_INLINE Floats root(const Floats& v) {
  return {std::bit_cast<Floats4>(_mm_sqrt_ps(std::bit_cast<__m128>(v.low))),
          std::bit_cast<Floats4>(_mm_sqrt_ps(std::bit_cast<__m128>(v.high)))};
}
MEANDER_INLINE Doubles root(const Doubles& v) {
  return {std::bit_cast<Doubles2>(_mm_sqrt_pd(std::bit_cast<__m128d>(v.low))),
          std::bit_cast<Doubles2>(_mm_sqrt_pd(std::bit_cast<__m128d>(v.high)))};
}

#if defined(__x86_64__)
// One instruction each. Templates that are inlined into functions with AVX2 have no such instructions
// themselves: vectors are passed by reference until then.
namespace wide {
MEANDER_TARGET("avx2") inline void root(const WideFloats& v, WideFloats& root) {
  root = reinterpret_cast<WideFloats>(_mm256_sqrt_ps(reinterpret_cast<__m256>(v)));
}
MEANDER_TARGET("avx2") inline void root(const WideDoubles& v, WideDoubles& root) {
  root = reinterpret_cast<WideDoubles>(_mm256_sqrt_pd(reinterpret_cast<__m256d>(v)));
}
MEANDER_TARGET("avx2") inline unsigned bits_of(const WideMask& mask) {
  return static_cast<unsigned>(_mm256_movemask_ps(reinterpret_cast<__m256>(mask)));
}
}  // namespace wide

MEANDER_INLINE WideFloats root(const WideFloats& v) {
  WideFloats root;
  wide::root(v, root);
  return root;
}
MEANDER_INLINE WideDoubles root(const WideDoubles& v) {
  WideDoubles root;
  wide::root(v, root);
  return root;
}
#else
MEANDER_INLINE WideFloats root(const WideFloats& v) {
  const Floats both =
      root(Floats{__builtin_shufflevector(v, v, 0, 1, 2, 3), __builtin_shufflevector(v, v, 4, 5, 6, 7)});
  return __builtin_shufflevector(both.low, both.high, 0, 1, 2, 3, 4, 5, 6, 7);
}

MEANDER_INLINE WideDoubles root(const WideDoubles& v) {
  const Doubles both =
      root(Doubles{__builtin_shufflevector(v, v, 0, 1), __builtin_shufflevector(v, v, 2, 3)});
  return __builtin_shufflevector(both.low, both.high, 0, 1, 2, 3);
}

#endif

// A bit for each of eight lanes of a comparison where it holds.
template <class Mask>
MEANDER_INLINE unsigned bits_of(const Pair<Mask>& mask) {
  return static_cast<unsigned>(_mm_movemask_ps(std::bit_cast<__m128>(mask.low))) |
         static_cast<unsigned>(_mm_movemask_ps(std::bit_cast<__m128>(mask.high))) << 4;
}

MEANDER_INLINE unsigned bits_of(const WideMask& mask) {
#if defined(__x86_64__)
  return wide::bits_of(mask);
#else
  using Mask4 = std::int32_t __attribute__((vector_size(16)));
  return bits_of(Pair<Mask4>{__builtin_shufflevector(mask, mask, 0, 1, 2, 3),
                             __builtin_shufflevector(mask, mask, 4, 5, 6, 7)});
#endif
}

}  // namespace meander::lanes
