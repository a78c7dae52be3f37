#include "kernels/analyse/histogram_error.h"

#include <algorithm>
#include <cmath>

namespace meander {

HistogramError histogram_error(std::span<const double> measured, std::span<const double> ground_truth) {
  double sum = 0, squares = 0, all = 0;
  HistogramError error;
  for (std::size_t b = 0; b < ground_truth.size(); ++b) {
    const double difference = std::abs(measured[b] - ground_truth[b]);
    sum += difference;
    squares += difference * difference;
    all += ground_truth[b];
    error.largest = std::max(error.largest, difference);
  }
  error.relative = sum / all;
  error.norm = std::sqrt(squares) / all;
  return error;
}

Spread spread_of(const std::vector<double>& values) {
  Spread spread;
  const auto count = static_cast<double>(values.size());
  for (const double v : values) spread.mean += v / count;
  if (values.size() < 2) return spread;
  for (const double v : values) spread.deviation += (v - spread.mean) * (v - spread.mean) / (count - 1);
  spread.deviation = std::sqrt(spread.deviation);
  spread.error = spread.deviation / std::sqrt(count);
  return spread;
}

double gap_of(const Spread& a, const Spread& b) { return (a.mean - b.mean) / std::hypot(a.error, b.error); }

}  // namespace meander
