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

}  // namespace meander
