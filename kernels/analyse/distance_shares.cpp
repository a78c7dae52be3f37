#include "kernels/analyse/distance_shares.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

namespace meander {

std::vector<double> sphere_distance_shares(std::uint32_t bins) {
  std::vector<double> shares;
  for (std::uint32_t b = 0; b < bins; ++b)
    shares.push_back((2.0 * b + 1) / (static_cast<double>(bins) * bins));
  return shares;
}

// Two circles around the axis, rho_1 and rho_2 from it and h apart in height, have the distances
// d^2 = rho_1^2 + rho_2^2 + h^2 - 2 rho_1 rho_2 cos(angle), the angle uniform; the mean over pairs of
// circles, weighted by rho_1 rho_2, is taken by the midpoint rule.
std::vector<double> torus_distance_shares(std::uint32_t bins, double tube) {
  constexpr std::uint32_t circles = 1024;
  std::vector<double> cumulative(bins, 0), radius, height;
  for (std::uint32_t i = 0; i < circles; ++i) {
    const double angle = 2 * std::numbers::pi * (i + 0.5) / circles;
    radius.push_back(1 + tube * std::cos(angle));
    height.push_back(tube * std::sin(angle));
  }
  for (std::uint32_t i = 0; i < circles; ++i)
    for (std::uint32_t j = i; j < circles; ++j) {
      const double rise = height[i] - height[j], twice = 2 * radius[i] * radius[j];
      const double squares = radius[i] * radius[i] + radius[j] * radius[j] + rise * rise;
      const double weight = (i == j ? 1 : 2) * radius[i] * radius[j];
      for (std::uint32_t b = 0; b < bins; ++b) {
        const double end = (2 + 2 * tube) * (b + 1.0) / bins;
        const double cosine = std::clamp((squares - end * end) / twice, -1.0, 1.0);
        cumulative[b] += weight * (cosine >= 1 ? 0 : cosine <= -1 ? 1 : std::acos(cosine) / std::numbers::pi);
      }
    }
  std::vector<double> shares;
  for (std::uint32_t b = 0; b < bins; ++b)
    shares.push_back((cumulative[b] - (b > 0 ? cumulative[b - 1] : 0)) / cumulative.back());
  return shares;
}

}  // namespace meander
