// Forward-mode automatic differentiation in two variables: numbers that carry their derivatives by u and v
// (Griewank and Walther 2008, "Evaluating derivatives", chapters 3 and 13). Formulas written over a scalar
// type run on double, on Jet1 (first derivatives) and on Jet2 (first and second derivatives).
#pragma once

#include <cmath>

#include "kernels/core/portable_angles.h"
#include "kernels/core/portable_functions.h"

namespace meander {

struct Jet1 {
  double f = 0, u = 0, v = 0;
  constexpr Jet1() = default;
  // A constant; implicit, so that formulas may mix in numbers.
  constexpr Jet1(double value) : f(value) {}
  constexpr Jet1(double value, double by_u, double by_v) : f(value), u(by_u), v(by_v) {}
};

struct Jet2 {
  double f = 0, u = 0, v = 0, uu = 0, uv = 0, vv = 0;
  constexpr Jet2() = default;
  constexpr Jet2(double value) : f(value) {}
  constexpr Jet2(double value, double by_u, double by_v, double by_uu = 0, double by_uv = 0, double by_vv = 0)
      : f(value), u(by_u), v(by_v), uu(by_uu), uv(by_uv), vv(by_vv) {}
};

// A derivative of g times one of x. It is 0 where x does not change, even where g is infinitely steep, as the
// square root of a part that is clamped to 0.
constexpr double steep(double g, double x) { return x == 0 ? 0 : g * x; }
// g(x) from the value g and the derivatives g1, g2 of g at x.
constexpr double chain(double, double g, double, double) { return g; }
constexpr Jet1 chain(const Jet1& x, double g, double g1, double) {
  return {g, steep(g1, x.u), steep(g1, x.v)};
}
constexpr Jet2 chain(const Jet2& x, double g, double g1, double g2) {
  return {g,
          steep(g1, x.u),
          steep(g1, x.v),
          steep(g1, x.uu) + steep(g2, x.u * x.u),
          steep(g1, x.uv) + steep(g2, x.u * x.v),
          steep(g1, x.vv) + steep(g2, x.v * x.v)};
}
constexpr double value_of(double x) { return x; }
constexpr double value_of(const Jet1& x) { return x.f; }
constexpr double value_of(const Jet2& x) { return x.f; }

constexpr Jet1 operator+(const Jet1& a, const Jet1& b) { return {a.f + b.f, a.u + b.u, a.v + b.v}; }
constexpr Jet1 operator-(const Jet1& a, const Jet1& b) { return {a.f - b.f, a.u - b.u, a.v - b.v}; }
constexpr Jet1 operator-(const Jet1& a) { return {-a.f, -a.u, -a.v}; }
constexpr Jet1 operator*(const Jet1& a, const Jet1& b) {
  return {a.f * b.f, a.u * b.f + a.f * b.u, a.v * b.f + a.f * b.v};
}
constexpr Jet2 operator+(const Jet2& a, const Jet2& b) {
  return {a.f + b.f, a.u + b.u, a.v + b.v, a.uu + b.uu, a.uv + b.uv, a.vv + b.vv};
}
constexpr Jet2 operator-(const Jet2& a, const Jet2& b) {
  return {a.f - b.f, a.u - b.u, a.v - b.v, a.uu - b.uu, a.uv - b.uv, a.vv - b.vv};
}
constexpr Jet2 operator-(const Jet2& a) { return {-a.f, -a.u, -a.v, -a.uu, -a.uv, -a.vv}; }
constexpr Jet2 operator*(const Jet2& a, const Jet2& b) {
  return {a.f * b.f,
          a.u * b.f + a.f * b.u,
          a.v * b.f + a.f * b.v,
          a.uu * b.f + 2 * a.u * b.u + a.f * b.uu,
          a.uv * b.f + a.u * b.v + a.v * b.u + a.f * b.uv,
          a.vv * b.f + 2 * a.v * b.v + a.f * b.vv};
}
// Numbers times jets, without the products by zero.
constexpr Jet1 operator*(double a, const Jet1& b) { return {a * b.f, a * b.u, a * b.v}; }
constexpr Jet1 operator*(const Jet1& a, double b) { return b * a; }
constexpr Jet2 operator*(double a, const Jet2& b) {
  return {a * b.f, a * b.u, a * b.v, a * b.uu, a * b.uv, a * b.vv};
}
constexpr Jet2 operator*(const Jet2& a, double b) { return b * a; }

template <class Scalar>
constexpr Scalar reciprocal(const Scalar& x) {
  const double r = 1 / value_of(x);
  return chain(x, r, -r * r, 2 * r * r * r);
}
constexpr Jet1 operator/(const Jet1& a, const Jet1& b) { return a * reciprocal(b); }
constexpr Jet2 operator/(const Jet2& a, const Jet2& b) { return a * reciprocal(b); }

template <class Scalar>
struct CosineSine {
  Scalar cosine, sine;
};
// Both functions at once, from one reduction; the same bits on every machine. |x| up to a few thousand turns.
template <class Scalar>
CosineSine<Scalar> cosine_sine(const Scalar& x) {
  const auto [c, s] = direction_of(value_of(x));
  return {chain(x, c, -s, -c), chain(x, s, c, -s)};
}
// x^n for n >= 0, by repeated multiplication of values.
template <class Scalar>
constexpr Scalar integer_power(const Scalar& x, int n) {
  const auto raised = [base = value_of(x)](int exponent) {
    double result = 1;
    for (int k = 0; k < exponent; ++k) result *= base;
    return result;
  };
  return chain(x, raised(n), n > 0 ? n * raised(n - 1) : 0.0, n > 1 ? n * (n - 1) * raised(n - 2) : 0.0);
}
// The derivatives are infinite or NaN at 0.
template <class Scalar>
Scalar square_root(const Scalar& x) {
  const double r = std::sqrt(value_of(x));
  return chain(x, r, 0.5 / r, -0.25 / (r * r * r));
}
template <class Scalar>
Scalar exponential(const Scalar& x) {
  const double e = portable::exp(value_of(x));
  return chain(x, e, e, e);
}
template <class Scalar>
Scalar logarithm(const Scalar& x) {
  const double r = 1 / value_of(x);
  return chain(x, portable::log(value_of(x)), r, -r * r);
}

}  // namespace meander
