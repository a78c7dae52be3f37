#include "kernels/analyse/chi_square.h"

#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

#include "kernels/core/random.h"
#include "support/catch.h"

using namespace meander;

TEST_CASE("chi_square_p_value: critical values of the tables") {
  // Upper 5 % and 1 % points (Abramowitz and Stegun 1964, table 26.8), to the digits printed there.
  struct Entry {
    double degrees, five, one;
  };
  for (const Entry& e :
       {Entry{1, 3.84146, 6.63490}, Entry{2, 5.99147, 9.21034}, Entry{5, 11.0705, 15.0863},
        Entry{10, 18.3070, 23.2093}, Entry{30, 43.7729, 50.8922}, Entry{100, 124.342, 135.807}}) {
    CHECK(chi_square_p_value(e.five, e.degrees) == Approx(0.05).epsilon(1e-4));
    CHECK(chi_square_p_value(e.one, e.degrees) == Approx(0.01).epsilon(1e-4));
  }
}

TEST_CASE("chi_square_p_value: closed forms for one, two and four degrees of freedom") {
  for (const double x : {1e-8, 0.1, 1.0, 3.0, 3.9, 4.1, 20.0, 200.0, 1000.0}) {
    CHECK(chi_square_p_value(x, 2) == Approx(std::exp(-x / 2)).epsilon(1e-11));
    CHECK(chi_square_p_value(x, 4) == Approx(std::exp(-x / 2) * (1 + x / 2)).epsilon(1e-11));
    CHECK(chi_square_p_value(x, 1) == Approx(std::erfc(std::sqrt(x / 2))).epsilon(1e-11));
  }
  CHECK(chi_square_p_value(0, 3) == 1);
  CHECK(chi_square_p_value(std::numeric_limits<double>::infinity(), 3) == 0);
}

TEST_CASE("upper_gamma: recurrence from a to a + 1 across both expansions") {
  // Q(a + 1, x) = Q(a, x) + x^a e^-x / Gamma(a + 1).
  for (const double a : {0.5, 3.0, 11.5, 50.0, 1000.0, 100000.0})
    for (const double factor : {0.9, 0.99, 1.0, 1.01, 1.1}) {
      const double x = a * factor;
      const double step = std::exp(a * std::log(x) - x - std::lgamma(a + 1));
      CHECK(upper_gamma(a + 1, x) - upper_gamma(a, x) == Approx(step).epsilon(1e-6).margin(1e-13));
    }
}

TEST_CASE("upper_gamma: many degrees of freedom are nearly normal") {
  // Wilson and Hilferty (1931): the cube root of chi-square over its degrees is nearly normal.
  for (const double degrees : {2000.0, 200000.0, 1500000.0})
    for (const double z : {-2.0, 0.0, 1.0, 3.0}) {
      const double h = 2 / (9 * degrees);
      const double statistic = degrees * std::pow(1 - h + z * std::sqrt(h), 3);
      CHECK(chi_square_p_value(statistic, degrees) ==
            Approx(0.5 * std::erfc(z / std::sqrt(2.0))).epsilon(1e-3));
    }
}

TEST_CASE("upper_gamma: arguments out of range are errors") {
  CHECK_THROWS_AS(upper_gamma(0, 1), std::invalid_argument);
  CHECK_THROWS_AS(upper_gamma(1, -1), std::invalid_argument);
  CHECK_THROWS_AS(upper_gamma(1, std::nan("")), std::invalid_argument);
}

TEST_CASE("chi_square_test: a die by hand") {
  const std::vector<std::uint64_t> counts{5, 8, 9, 8, 10, 20};
  const std::vector<double> expected(6, 10.0);
  const ChiSquare result = chi_square_test(counts, expected);
  CHECK(result.statistic == Approx(13.4));
  CHECK(result.degrees == 5);
  CHECK(result.p_value == Approx(0.0199).epsilon(5e-3));
}

TEST_CASE("chi_square_test: small cells are merged and expectations scaled") {
  // Expectations 2, 2, 2 | 8 | 1, 5 | 1 of a total of 21 after scaling by one half.
  const std::vector<std::uint64_t> counts{1, 3, 3, 7, 2, 4, 1};
  const std::vector<double> expected{4, 4, 4, 16, 2, 10, 2};
  const ChiSquare result = chi_square_test(counts, expected, 5);
  CHECK(result.cells == 3);
  CHECK(result.statistic == Approx(1.0 / 6 + 1.0 / 8 + 0.0));
  CHECK(chi_square_test(counts, expected, 100).p_value == 1);
  CHECK(chi_square_test({}, {}).p_value == 1);
}

TEST_CASE("chi_square_test: a count where none is expected is detected") {
  const std::vector<std::uint64_t> counts{50, 50, 80};
  const std::vector<double> expected{50, 50, 0};
  CHECK(chi_square_test(counts, expected).p_value < 1e-6);
}

TEST_CASE("chi_square_test: invalid input is an error") {
  const std::vector<std::uint64_t> counts{1, 2};
  const std::vector<double> one{1}, negative{1, -1}, nan{1, std::nan("")};
  CHECK_THROWS_AS(chi_square_test(counts, one), std::invalid_argument);
  CHECK_THROWS_AS(chi_square_test(counts, negative), std::invalid_argument);
  CHECK_THROWS_AS(chi_square_test(counts, nan), std::invalid_argument);
}

TEST_CASE("chi_square_test: p-values of true hypotheses are uniform, a false one is rejected") {
  std::vector<std::uint64_t> of_p(10, 0);
  const std::vector<double> expected{1, 2, 3, 4, 5, 6, 7, 8};
  for (std::uint64_t seed = 0; seed < 400; ++seed) {
    std::vector<std::uint64_t> counts(8, 0);
    for (std::uint64_t i = 0; i < 1000; ++i) {
      double u = 36 * random_pair(make_random_key(seed, {}), Stream::test_shapes, i).first;
      std::size_t cell = 0;
      while (u >= expected[cell]) u -= expected[cell++];
      ++counts[cell];
    }
    const double p = chi_square_test(counts, expected).p_value;
    ++of_p[std::min<std::size_t>(9, static_cast<std::size_t>(10 * p))];
    const std::vector<double> wrong{3, 2, 1, 4, 5, 6, 7, 8};
    CHECK(chi_square_test(counts, wrong).p_value < 0.01);
  }
  CHECK(chi_square_test(of_p, std::vector<double>(10, 1.0)).p_value > 0.001);
}
