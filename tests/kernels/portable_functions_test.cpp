#include "kernels/core/portable_functions.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>

#include "kernels/core/portable_angles.h"
#include "kernels/core/random.h"
#include "support/catch.h"

using namespace meander;

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double none = std::numeric_limits<double>::quiet_NaN();

// Uniform numbers that are the same on every machine.
class Numbers {
 public:
  double next(double low, double high) {
    const UnitPair pair = random_pair({{1, 2}}, Stream::test_shapes, index_++, 0);
    return low + (high - low) * pair.first;
  }
  // Of any size: from 2^-exponent to 2^exponent.
  double of_any_size(double exponent) { return std::exp2(next(-exponent, exponent)); }

 private:
  std::uint32_t index_ = 0;
};

// The distance between a result and the right one in units in the last place of that.
double units(double result, long double right) {
  int exponent = 0;
  std::frexp(right, &exponent);
  return static_cast<double>(std::abs(result - right) / std::ldexp(1.0L, exponent - 53));
}

// Whether both are the same number, zero with its sign, or none.
bool same(double a, double b) {
  return std::isnan(a) ? std::isnan(b) : std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
}

}  // namespace

TEST_CASE("portable functions: within the stated errors of long double") {
  if (std::numeric_limits<long double>::digits < 64) return;
  Numbers numbers;
  double exp = 0, log = 0, log2 = 0, pow = 0, cbrt = 0, hypot = 0, hypot3 = 0, atan2 = 0;
  for (int i = 0; i < 100000; ++i) {
    const double x = numbers.next(-700, 700) * (i % 2 == 0 ? 1 : 1e-3);
    exp = std::max(exp, units(portable::exp(x), std::exp(static_cast<long double>(x))));
    const double size = i % 2 == 0 ? numbers.of_any_size(1000) : 1 + numbers.next(-1e-3, 1e-3);
    log = std::max(log, units(portable::log(size), std::log(static_cast<long double>(size))));
    log2 = std::max(log2, units(portable::log2(size), std::log2(static_cast<long double>(size))));
    const double base = numbers.of_any_size(16), exponent = numbers.next(-60, 60);
    pow = std::max(pow, units(portable::pow(base, exponent),
                              std::pow(static_cast<long double>(base), static_cast<long double>(exponent))));
    cbrt = std::max(cbrt, units(portable::cbrt(-size), std::cbrt(static_cast<long double>(-size))));
    const double a = numbers.next(-1, 1) * numbers.of_any_size(8), b = numbers.next(-1, 1), c = a * b - 0.1;
    const long double sum = static_cast<long double>(a) * a + static_cast<long double>(b) * b;
    hypot = std::max(hypot, units(portable::hypot(a, b), std::sqrt(sum)));
    hypot3 =
        std::max(hypot3, units(portable::hypot(a, b, c), std::sqrt(sum + static_cast<long double>(c) * c)));
    atan2 = std::max(atan2, units(portable::atan2(a, b),
                                  std::atan2(static_cast<long double>(a), static_cast<long double>(b))));
  }
  CHECK(exp < 0.56);
  CHECK(log < 0.51);
  CHECK(log2 < 0.51);
  CHECK(pow < 0.57);
  CHECK(cbrt < 1);
  CHECK(hypot < 1.25);
  CHECK(hypot3 < 1.5);
  CHECK(atan2 < 2.5);
}

TEST_CASE("portable functions: special values match the C library") {
  const double values[] = {0.0,       -0.0,   1,      -1,     2,          -2,   0.5, -0.5, 3,
                           1e300,     -1e300, 5e-324, 1e-310, 710,        -746, 800, -800, infinity,
                           -infinity, none,   1e20,   0x1p53, 0x1p53 + 2, 2.5,  -3};
  for (const double x : values) {
    INFO(x);
    for (const auto& [own, library] :
         {std::pair{portable::exp(x), std::exp(x)}, std::pair{portable::log(x), std::log(x)},
          std::pair{portable::log2(x), std::log2(x)}, std::pair{portable::cbrt(x), std::cbrt(x)}}) {
      CHECK((same(own, library) || units(own, library) <= 1));
    }
    for (const double y : values) {
      INFO(y);
      const double own = portable::pow(x, y), library = std::pow(x, y);
      CHECK((same(own, library) || units(own, library) <= 1));
      CHECK((same(portable::hypot(x, y), std::hypot(x, y)) ||
             units(portable::hypot(x, y), std::hypot(x, y)) <= 2));
    }
  }
  for (int exponent = -1074; exponent < 1024; ++exponent)
    CHECK(portable::log2(std::ldexp(1.0, exponent)) == exponent);
}

TEST_CASE("portable functions: angles keep their digits up to 1e15") {
  Numbers numbers;
  for (int i = 0; i < 20000; ++i) {
    const double angle = numbers.next(-1, 1) * numbers.of_any_size(49);
    INFO(angle);
    const Direction direction = direction_of(angle);
    const double slack = std::abs(angle) < 8192 ? 4e-16 * std::abs(angle) : 0;
    CHECK(std::abs(direction.sine - std::sin(angle)) < 1e-15 + slack);
    CHECK(std::abs(direction.cosine - std::cos(angle)) < 1e-15 + slack);
  }
}

// The promise itself: it fails on the first machine, compiler or library that gives another bit.
TEST_CASE("portable functions: the same bits everywhere") {
  Numbers numbers;
  std::uint64_t digest = 0xcbf29ce484222325u;
  const auto add = [&](double value) {
    digest = (digest ^ std::bit_cast<std::uint64_t>(value)) * 0x100000001b3u;
  };
  for (int i = 0; i < 20000; ++i) {
    const double x = numbers.next(-700, 700), y = numbers.next(-3, 3), z = numbers.next(0, 2);
    for (const double value : {portable::exp(x), portable::log(z), portable::log2(z), portable::pow(z, y),
                               portable::cbrt(x), portable::hypot(x, y), portable::hypot(x, y, z),
                               portable::atan2(y, x), direction_of(x).sine, direction_of(1e9 * x).cosine})
      add(value);
  }
  CHECK(digest == 12657403464353446482u);
}
