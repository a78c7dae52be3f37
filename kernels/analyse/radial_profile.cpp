#include "kernels/analyse/radial_profile.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace meander {

RadialProfile radial_profile(std::span<const double> map, std::size_t side, double first, double width) {
  return radial_profile(map, side, first, width, {1, 0, 1});
}

RadialProfile radial_profile(std::span<const double> map, std::size_t side, double first, double width,
                             TangentTensor stretch) {
  if (map.size() != side * side) throw std::invalid_argument("radial_profile: the map is side x side values");
  if (!(first >= 0) || !(width > 0) || !std::isfinite(first))
    throw std::invalid_argument("radial_profile: rings begin at first >= 0 and have a width > 0");
  const double determinant_of_stretch = determinant(stretch);
  if (!(stretch.xx > 0 && determinant_of_stretch > 0 && std::isfinite(trace(stretch))))
    throw std::invalid_argument("radial_profile: the stretch is positive definite");
  const double middle = 0.5 * (static_cast<double>(side) - 1);
  // Half a cell beyond the centers of the outermost ones, where the square ends. The ellipse |stretch d| = 1
  // reaches as far along an axis as that column of the inverse is long.
  const double extent = std::max(std::hypot(stretch.xx, stretch.xy), std::hypot(stretch.yy, stretch.xy));
  const double last = 0.5 * static_cast<double>(side) * determinant_of_stretch / extent;
  const double fitting = std::floor((last - first) / width * (1 + 1e-12));
  const auto rings = static_cast<std::size_t>(fitting > 0 ? fitting : 0);

  RadialProfile profile;
  profile.bins.assign(rings, 0);
  profile.mean.assign(rings, 0);
  std::vector<double> squared(rings, 0);
  const std::size_t half =
      side * side / 2;  // the cells before the one in the middle, which is its own mirror
  const std::size_t cells = half + side % 2;
  const auto visit = [&](const auto& add) {
    for (std::size_t c = 0; c < cells; ++c) {
      const double dx = static_cast<double>(c % side) - middle, dy = static_cast<double>(c / side) - middle;
      const double x = stretch.xx * dx + stretch.xy * dy, y = stretch.xy * dx + stretch.yy * dy;
      const double ring = std::floor((std::sqrt(x * x + y * y) - first) / width);
      if (ring >= 0 && ring < static_cast<double>(rings)) add(static_cast<std::size_t>(ring), map[c]);
    }
  };
  visit([&](std::size_t ring, double value) {
    ++profile.bins[ring];
    profile.mean[ring] += value;
  });
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  for (std::size_t k = 0; k < rings; ++k)
    profile.mean[k] = profile.bins[k] > 0 ? profile.mean[k] / profile.bins[k] : nan;
  visit([&](std::size_t ring, double value) {
    const double d = value - profile.mean[ring];
    squared[ring] += d * d;
  });
  for (std::size_t k = 0; k < rings; ++k) {
    profile.radius.push_back(first + (static_cast<double>(k) + 0.5) * width);
    const double mean = profile.mean[k];
    const bool defined = profile.bins[k] > 1 && mean != 0;
    profile.anisotropy_db.push_back(
        defined ? 10 * std::log10(squared[k] / (profile.bins[k] - 1) / (mean * mean)) : nan);
  }
  return profile;
}

}  // namespace meander
