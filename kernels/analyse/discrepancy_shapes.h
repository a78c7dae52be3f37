// How many random shapes a discrepancy is taken over, and when to stop (docs/METHODS.md 13.2).
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "kernels/core/parallel.h"

namespace meander {

// Shapes are a function of (seed, number) and of nothing else: two methods measured with the same seed meet
// identical shapes, and fewer shapes are a prefix of more. Sampled maxima grow slowly with the number of
// shapes: compare methods only at equal numbers (stable_rise 0, or running_max).
struct ShapeParameters {
  std::uint32_t shapes = 1u << 14;  // the cap; 1 .. 2 x 10^5
  std::uint64_t seed = 1;           // of the shapes
  double stable_rise = 0.01;        // stop when stable_batches batches in a row raise the maximum by less ...
  std::uint32_t stable_batches = 4;  // ... than this share each; a rise of 0 always runs to the cap
};
inline constexpr std::uint32_t shape_batch = 256;

// A sampled discrepancy: max over the shapes of |count / N - measure|, a lower bound of the supremum.
struct ShapeDiscrepancy {
  double discrepancy = 0;
  std::uint32_t shapes = 0;         // that were looked at
  bool stable = false;              // the rule stopped it, or would have at the cap
  std::vector<double> running_max;  // after each batch of shape_batch shapes
};

// The rule on running maxima: number of batches after which it stops, 0 if it does not.
inline std::size_t stable_after(const std::vector<double>& running_max, const ShapeParameters& parameters) {
  std::uint32_t quiet = 0;
  for (std::size_t b = 1; b < running_max.size(); ++b) {
    quiet = running_max[b] < (1 + parameters.stable_rise) * running_max[b - 1] ? quiet + 1 : 0;
    if (parameters.stable_rise > 0 && quiet >= parameters.stable_batches) return b + 1;
  }
  return 0;
}

// The driver: error(number, best) is the discrepancy of one shape, where `best` is the maximum before the
// batch: a shape that cannot exceed it may return anything up to it. Batches run in parallel.
template <class Error>
ShapeDiscrepancy max_over_shapes(const ShapeParameters& parameters, const Error& error) {
  ShapeDiscrepancy result;
  std::vector<double> errors;
  while (result.shapes < parameters.shapes) {
    errors.assign(std::min(shape_batch, parameters.shapes - result.shapes), 0.0);
    const std::uint32_t first = result.shapes;
    const double best = result.discrepancy;
    parallel_tasks(errors.size(),
                   [&](std::size_t i) { errors[i] = error(first + static_cast<std::uint32_t>(i), best); });
    for (const double e : errors) result.discrepancy = std::max(result.discrepancy, e);
    result.shapes += static_cast<std::uint32_t>(errors.size());
    result.running_max.push_back(result.discrepancy);
    if (stable_after(result.running_max, parameters) > 0) {
      result.stable = true;
      break;
    }
  }
  return result;
}

}  // namespace meander
