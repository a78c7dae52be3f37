// Quantiles of weighted values.
#pragma once

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <span>
#include <vector>

namespace meander {

// The smallest value such that values up to it have `share` of the weight; 0 without values. Equal values
// count in their order. O(n log n).
inline double weighted_quantile(std::span<const double> values, std::span<const double> weights,
                                double share) {
  std::vector<std::uint32_t> order(values.size());
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return values[a] != values[b] ? values[a] < values[b] : a < b;
  });
  const double target = share * std::accumulate(weights.begin(), weights.end(), 0.0);
  double below = 0;
  for (const std::uint32_t i : order) {
    below += weights[i];
    if (below >= target) return values[i];
  }
  return order.empty() ? 0.0 : values[order.back()];
}

}  // namespace meander
