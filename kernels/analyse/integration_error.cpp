#include "kernels/analyse/integration_error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "kernels/core/parallel.h"

namespace meander {

namespace {

double uniform(double, double) { return 1; }

double exponential(double x, double y) { return std::exp(x + y); }

double cosine(double x, double y) { return std::cos(3 * x) * std::cos(2 * y); }

constexpr double disc_x = 0.45, disc_y = 0.53, disc_radius = 0.4;
double disc(double x, double y) {
  const double dx = x - disc_x, dy = y - disc_y;
  return dx * dx + dy * dy <= disc_radius * disc_radius ? 1 : 0;
}

constexpr double line_offset = 0.3, line_slope = 0.55;
double half_plane(double x, double y) { return y <= line_offset + line_slope * x ? 1 : 0; }

double squares(double x, double y) { return x * x * y * y; }

Integrand indicator(std::string_view name, double (*value)(double, double), double share) {
  return {name, value, uniform, 1, share, share * (1 - share)};
}

Integrand product(std::string_view name, double (*value)(double, double), double (*density)(double, double),
                  double density_integral, double mean, double mean_square) {
  return {name, value, density, density_integral, mean, mean_square - mean * mean};
}

std::array<Integrand, 5> make_integrands() {
  const double e = std::numbers::e;
  const auto square = [](double v) { return v * v; };
  return {
      product("exponential", exponential, uniform, 1, square(e - 1), square(0.5 * (e * e - 1))),
      product("cosine", cosine, uniform, 1, std::sin(3.0) / 3 * (std::sin(2.0) / 2),
              (0.5 + std::sin(6.0) / 12) * (0.5 + std::sin(4.0) / 8)),
      indicator("disc", disc, std::numbers::pi * disc_radius * disc_radius),
      indicator("half-plane", half_plane, line_offset + 0.5 * line_slope),
      product("weighted", exponential, squares, 1.0 / 9, square(3 * (e - 2)), square(0.75 * (e * e - 1)))};
}

}  // namespace

double integration_error(std::span<const double> values, double exact) {
  if (values.empty()) throw std::invalid_argument("integration_error: no values");
  return std::abs(blocked_sum(values) / static_cast<double>(values.size()) - exact);
}

double weighted_integration_error(std::span<const double> values, std::span<const double> density,
                                  double measure, double exact) {
  if (values.size() != density.size())
    throw std::invalid_argument("weighted_integration_error: as many densities as values");
  std::vector<double> ratios(values.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!(density[i] > 0))
      throw std::invalid_argument("weighted_integration_error: densities must be positive at the samples");
    ratios[i] = measure * values[i] / density[i];
  }
  return integration_error(ratios, exact);
}

std::vector<double> prefix_integration_errors(std::span<const double> values,
                                              std::span<const std::uint64_t> counts, double exact) {
  std::vector<double> errors;
  errors.reserve(counts.size());
  double sum = 0, rest = 0;  // compensated (Neumaier 1974): one order of summation for every prefix
  std::uint64_t done = 0;
  for (const std::uint64_t count : counts) {
    if (count < 1 || count < done || count > values.size())
      throw std::invalid_argument("prefix_integration_errors: counts ascend from 1 to the number of values");
    for (; done < count; ++done) {
      const double value = values[done], next = sum + value;
      rest += std::abs(sum) >= std::abs(value) ? (sum - next) + value : (value - next) + sum;
      sum = next;
    }
    errors.push_back(std::abs((sum + rest) / static_cast<double>(count) - exact));
  }
  return errors;
}

double mean_estimate(std::span<const double> values, std::span<const double> density) {
  if (values.empty()) throw std::invalid_argument("mean_estimate: no values");
  if (density.empty()) return blocked_sum(values) / static_cast<double>(values.size());
  if (density.size() != values.size())
    throw std::invalid_argument("mean_estimate: as many densities as values");
  double sum = 0, weights = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!(density[i] > 0)) throw std::invalid_argument("mean_estimate: densities must be positive");
    sum += values[i] / density[i];
    weights += 1 / density[i];
  }
  return sum / weights;
}

ErrorSummary summarize_errors(std::span<const double> errors) {
  if (errors.empty()) throw std::invalid_argument("summarize_errors: no errors");
  const auto count = static_cast<double>(errors.size());
  double squares = 0, sum = 0;
  ErrorSummary summary;
  for (const double e : errors) {
    squares += e * e;
    sum += e;
    summary.largest = std::max(summary.largest, std::abs(e));
  }
  summary.rms = std::sqrt(squares / count);
  if (errors.size() > 1)
    summary.standard_deviation = std::sqrt(std::max(0.0, squares - sum * sum / count) / (count - 1));
  return summary;
}

std::span<const Integrand> standard_integrands() {
  static const std::array<Integrand, 5> integrands = make_integrands();
  return integrands;
}

}  // namespace meander
