#include "kernels/analyse/chi_square.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

namespace meander {

namespace {

// log Gamma(a) for a > 0: shifted to a >= 12, then Stirling's series (Abramowitz and Stegun 6.1.40).
// std::lgamma writes a global variable, which threads would race for.
double log_gamma(double a) {
  double shift = 0;
  while (a < 12) {
    shift += std::log(a);
    a += 1;
  }
  const double r = 1 / (a * a);
  const double series =
      (1.0 / 12 - r * (1.0 / 360 - r * (1.0 / 1260 - r * (1.0 / 1680 - r * (1.0 / 1188))))) / a;
  return (a - 0.5) * std::log(a) - a + 0.5 * std::log(2 * std::numbers::pi) + series - shift;
}

// log of x^a e^-x / Gamma(a), without the cancellation of large terms that the three logarithms would have.
double log_front(double a, double x) {
  if (a < 12) return a * std::log(x) - x - log_gamma(a);
  const double d = (x - a) / a;
  const double r = 1 / (a * a);
  const double series =
      (1.0 / 12 - r * (1.0 / 360 - r * (1.0 / 1260 - r * (1.0 / 1680 - r * (1.0 / 1188))))) / a;
  return a * (std::log1p(d) - d) + 0.5 * std::log(a) - 0.5 * std::log(2 * std::numbers::pi) - series;
}

constexpr double precision = std::numeric_limits<double>::epsilon();

// P(a, x) by its power series; x < a + 1.
double lower_series(double a, double x) {
  double term = 1 / a, sum = term;
  for (double n = a + 1; term > sum * precision; n += 1) {
    term *= x / n;
    sum += term;
  }
  return sum * std::exp(log_front(a, x));
}

// Q(a, x) by its continued fraction (modified Lentz); x >= a + 1.
double upper_fraction(double a, double x) {
  constexpr double tiny = 1e-300;
  double b = x + 1 - a;
  double c = 1 / tiny, d = 1 / b, h = d;
  for (double i = 1;; i += 1) {
    const double an = -i * (i - a);
    b += 2;
    d = an * d + b;
    if (std::abs(d) < tiny) d = tiny;
    c = b + an / c;
    if (std::abs(c) < tiny) c = tiny;
    d = 1 / d;
    const double factor = d * c;
    h *= factor;
    if (std::abs(factor - 1) <= precision) break;
  }
  return h * std::exp(log_front(a, x));
}

}  // namespace

double upper_gamma(double a, double x) {
  if (!(a > 0) || !(x >= 0) || !std::isfinite(a))
    throw std::invalid_argument("upper_gamma: a > 0 and x >= 0");
  if (x == 0) return 1;
  if (std::isinf(x)) return 0;
  return x < a + 1 ? 1 - lower_series(a, x) : upper_fraction(a, x);
}

double chi_square_p_value(double statistic, double degrees) {
  return upper_gamma(0.5 * degrees, 0.5 * statistic);
}

ChiSquare chi_square_test(std::span<const std::uint64_t> counts, std::span<const double> expected,
                          double min_expected) {
  if (counts.size() != expected.size())
    throw std::invalid_argument("chi_square_test: as many counts as expectations");
  double total_count = 0, total_expected = 0;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    if (!(expected[i] >= 0) || !std::isfinite(expected[i]))
      throw std::invalid_argument("chi_square_test: expectations must be finite and >= 0");
    total_count += static_cast<double>(counts[i]);
    total_expected += expected[i];
  }
  ChiSquare result;
  if (!(total_expected > 0) || total_count == 0) return result;
  const double scale = total_count / total_expected;

  double count = 0, mean = 0;            // the cell being gathered
  double last_count = 0, last_mean = 0;  // the last one that was closed
  double statistic = 0;                  // of the cells before that
  const auto term = [](double c, double m) { return (c - m) * (c - m) / m; };
  for (std::size_t i = 0; i < counts.size(); ++i) {
    count += static_cast<double>(counts[i]);
    mean += scale * expected[i];
    if (mean < min_expected || mean == 0) continue;
    if (result.cells++ > 0) statistic += term(last_count, last_mean);
    last_count = count;
    last_mean = mean;
    count = mean = 0;
  }
  last_count += count;
  last_mean += mean;
  if (result.cells < 2) return result;
  result.statistic = statistic + term(last_count, last_mean);
  result.degrees = static_cast<double>(result.cells - 1);
  result.p_value = chi_square_p_value(result.statistic, result.degrees);
  return result;
}

}  // namespace meander
