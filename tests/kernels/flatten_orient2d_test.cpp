#include <cmath>
#include <vector>

#include "kernels/core/random.h"
#include "kernels/flatten/fit_square.h"
#include "kernels/flatten/orient2d.h"
#include "support/catch.h"

using namespace meander;

namespace {

int sign(double value) { return value > 0 ? 1 : value < 0 ? -1 : 0; }

__extension__ using Wide = __int128;

// Exact on integers of up to 60 bits.
int exact_sign(long long ax, long long ay, long long bx, long long by, long long cx, long long cy) {
  const Wide left = static_cast<Wide>(ax - cx) * (by - cy);
  const Wide right = static_cast<Wide>(ay - cy) * (bx - cx);
  return left > right ? 1 : left < right ? -1 : 0;
}

}  // namespace

TEST_CASE("orient2d: the sign is exact next to a line") {
  // Points k ulps off a diagonal (Kettner et al. 2008, "Classroom examples of robustness problems").
  const double ulp = 0x1p-53;
  for (int i = 0; i < 64; ++i)
    for (int j = 0; j < 64; ++j) {
      const double px = 0.5 + i * ulp, py = 0.5 + j * ulp;
      const int expected = sign(j - i);  // left of the diagonal where y > x
      REQUIRE(sign(orient2d(12, 12, 24, 24, px, py)) == expected);
      REQUIRE(sign(orient2d(24, 24, px, py, 12, 12)) == expected);
      REQUIRE(sign(orient2d(24, 24, 12, 12, px, py)) == -expected);
    }
}

TEST_CASE("orient2d: agrees with 128-bit integers, near-degenerate and random") {
  for (std::uint64_t i = 0; i < 20000; ++i) {
    const PhiloxBlock a = random_words({{1, 2}}, Stream::sequence, i),
                      b = random_words({{3, 4}}, Stream::sequence, i);
    const auto word = [](std::uint32_t w) { return static_cast<long long>(w) << 20 | (w >> 12); };  // 52 bits
    const long long ax = word(a[0]), ay = word(a[1]), bx = word(a[2]), by = word(a[3]);
    long long cx = word(b[0]), cy = word(b[1]);
    if (i % 2 == 0) {  // on the line, then a few units off
      const long long k = b[2] % 5 + 1;
      cx = ax + (bx - ax) / 8 * k + static_cast<long long>(b[3] % 3) - 1;
      cy = ay + (by - ay) / 8 * k;
    }
    const double scale = std::ldexp(1.0, -static_cast<int>(i % 90));
    const double value = orient2d(ax * scale, ay * scale, bx * scale, by * scale, cx * scale, cy * scale);
    REQUIRE(sign(value) == exact_sign(ax, ay, bx, by, cx, cy));
  }
}

TEST_CASE("orient2d: collinear points give zero") {
  CHECK(orient2d(0, 0, 1, 1, 2, 2) == 0);
  CHECK(orient2d(0.1, 0.1, 0.1, 0.1, 0.7, 0.3) == 0);
  CHECK(orient2d(0, 0, 0, 0, 0, 0) == 0);
  CHECK(orient2d(0, 0, 1, 0, 0, 1) == 1);
}

TEST_CASE("fit_square: the minimum-area rectangle lies along u, shape unchanged") {
  // A 4 x 1 rectangle turned by every angle, with points inside.
  for (int turn = 0; turn < 24; ++turn) {
    const double c = std::cos(0.3 * turn), s = std::sin(0.3 * turn);
    std::vector<double> u, v;
    for (int i = 0; i <= 8; ++i)
      for (int j = 0; j <= 2; ++j) {
        const double x = 0.5 * i, y = 0.5 * j;
        u.push_back(1e3 + 7 * (c * x - s * y));
        v.push_back(-5e2 + 7 * (s * x + c * y));
      }
    const std::vector<double> before_u = u, before_v = v;
    const double scale = fit_square(u, v);
    double low_u = 1, high_u = 0, low_v = 1, high_v = 0;
    for (std::size_t i = 0; i < u.size(); ++i) {
      low_u = std::min(low_u, u[i]);
      high_u = std::max(high_u, u[i]);
      low_v = std::min(low_v, v[i]);
      high_v = std::max(high_v, v[i]);
      const double length = std::hypot(u[i] - u[0], v[i] - v[0]);
      REQUIRE(length ==
              Approx(scale * std::hypot(before_u[i] - before_u[0], before_v[i] - before_v[0])).margin(1e-9));
    }
    CHECK(high_u - low_u == Approx(1 - 0x1p-11).epsilon(1e-9));
    CHECK(high_v - low_v == Approx((1 - 0x1p-11) / 4).epsilon(1e-9));
    CHECK(low_u + high_u == Approx(1));
    CHECK(low_v + high_v == Approx(1));
    CHECK(orient2d(u[0], v[0], u[24], v[24], u[2], v[2]) > 0);  // not mirrored
  }
}

TEST_CASE("fit_square: points on a line, one point, no point") {
  std::vector<double> u = {0, 1, 2, 3}, v = {0, 2, 4, 6};
  fit_square(u, v);
  CHECK(v[0] == Approx(0.5));
  CHECK(v[3] == Approx(0.5));
  std::vector<double> one_u = {3, 3}, one_v = {4, 4};
  fit_square(one_u, one_v);
  CHECK(one_u[0] == 0.5);
  CHECK(one_v[1] == 0.5);
  std::vector<double> none;
  fit_square(none, none);
}
