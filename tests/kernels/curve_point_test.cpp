#include "kernels/pointset/curve_point.h"

#include <cmath>

#include "kernels/core/random.h"
#include "kernels/curve_reference.h"
#include "support/catch.h"

using namespace meander;
using namespace meander::test;

namespace {

std::uint64_t power(std::uint64_t base, int exponent) {
  std::uint64_t result = 1;
  for (int i = 0; i < exponent; ++i) result *= base;
  return result;
}

std::uint64_t children(CurveKind kind) { return kind == CurveKind::hilbert ? 4 : 9; }

}  // namespace

TEST_CASE("curve_cell_center: inverse of curve_key on every cell, and neighbors share an edge") {
  for (const CurveKind kind : curve_kinds)
    for (int level = 0; level <= 4; ++level) {
      const std::uint64_t cells = power(children(kind), level);
      const double side = 1 / std::sqrt(static_cast<double>(cells));
      const std::uint64_t finer = power(children(kind), curve_key_levels(kind) - level - 1);
      CurvePoint before;
      std::uint64_t wrong = 0, apart = 0;
      for (std::uint64_t rank = 0; rank < cells; ++rank) {
        const CurvePoint p = curve_cell_center(kind, rank, level);
        wrong += curve_key(kind, p.u, p.v) / finer / children(kind) != rank;
        if (rank > 0) apart += std::abs(std::abs(p.u - before.u) + std::abs(p.v - before.v) - side) > 1e-12;
        before = p;
      }
      CHECK(wrong == 0);
      CHECK(apart == 0);
    }
}

TEST_CASE("curve_point: curve_key of H(t) is t up to the levels of a double") {
  const RandomKey key = make_random_key(7, {});
  std::uint64_t wrong = 0;
  for (std::uint64_t i = 0; i < 20000; ++i) {
    const double t = random_pair(key, Stream::sequence, i).first;
    for (const CurveKind kind : curve_kinds) {
      const CurvePoint p = curve_point(kind, t);
      if (kind == CurveKind::hilbert)
        wrong += curve_key(kind, p.u, p.v) >> 12 != static_cast<std::uint64_t>(t * 0x1p52);
      else
        wrong += curve_key(kind, p.u, p.v) / 6561 != static_cast<std::uint64_t>(t * 1853020188851841.0);
    }
  }
  CHECK(wrong == 0);
}

TEST_CASE("curve_point: the ends of the curve, and t outside the half-open unit interval") {
  for (const CurveKind kind : curve_kinds) {
    const CurvePoint first = curve_point(kind, 0), last = curve_point(kind, 1);
    CHECK(first.u == Approx(0).margin(1e-7));
    CHECK(first.v == Approx(0).margin(1e-7));
    CHECK(last.u == Approx(1).margin(1e-7));  // Hilbert and meander leave at p + a, Peano at p + a + b
    CHECK(last.v == Approx(kind == CurveKind::peano ? 1 : 0).margin(1e-7));
    CHECK(curve_point(kind, -1).u == first.u);
    CHECK(curve_point(kind, 2).v == last.v);
    CHECK((last.u < 1 && last.v < 1));
  }
}

TEST_CASE("curve_point: Hoelder-1/2 with the known constants") {
  // |H(s) - H(t)|^2 / |s - t| is at most 6 for Hilbert, 8 for Peano, 6 2/3 for the meander.
  const RandomKey key = make_random_key(8, {});
  for (const CurveKind kind : curve_kinds) {
    double most = 0;
    for (std::uint64_t i = 0; i < 40000; ++i) {
      const UnitPair u = random_pair(key, Stream::sequence, i);
      const double s = u.first, t = std::fmod(s + std::pow(10, -5 * u.second), 1.0);
      const CurvePoint p = curve_point(kind, s), q = curve_point(kind, t);
      const double dx = p.u - q.u, dy = p.v - q.v;
      most = std::max(most, (dx * dx + dy * dy) / std::abs(s - t));
    }
    CHECK(most < (kind == CurveKind::hilbert ? 6.0 : kind == CurveKind::peano ? 8.0 : 6.7));
    CHECK(most > 3.5);
  }
}
