#include "kernels/analyse/pair_density.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "kernels/analyse/require.h"
#include "kernels/tensor/tangent_tensor.h"

namespace meander {

namespace {

constexpr double outskirts = 0.6;  // of the range: farther out is no dip

double cell_position(const DifferenceMap& map, std::size_t cell) {
  return (static_cast<double>(cell) + 0.5) * map.cell() - map.parameters.range;
}

// 1 - g per cell, 0 where nothing is expected. g is scaled to 1 in the outskirts of the map: how many samples
// of a class there happen to be in a set, or lie near a boundary, would otherwise be a dip without end.
std::vector<double> dip_values(const DifferenceMap& map, const DifferenceMap& expected) {
  std::vector<double> dip = normalized_differences(map, expected);
  const double least = outskirts * outskirts * map.parameters.range * map.parameters.range;
  double seen = 0, reference = 0;
  for (std::size_t c = 0; c < dip.size(); ++c) {
    const double x = cell_position(map, c % map.side()), y = cell_position(map, c / map.side());
    if (x * x + y * y <= least || !(expected.sum[c] > 0)) continue;
    seen += map.sum[c] / map.sets;
    reference += expected.sum[c] / expected.sets;
  }
  const double scale = seen > 0 ? reference / seen : 1;
  for (double& value : dip) value = std::isnan(value) ? 0 : 1 - scale * value;
  return dip;
}

struct Moments {
  double weight = 0, mass = 0;  // sums over cells of w and of w (1 - g)
  TangentTensor second;         // of w (1 - g), divided by the mass
};

// Under the window exp(-q^T covariance^-1 q / 2), to five standard deviations.
template <class Visit>
void for_each_in_window(const DifferenceMap& map, TangentTensor covariance, const Visit& visit) {
  const double d = determinant(covariance);
  const TangentTensor inverse = {covariance.yy / d, -covariance.xy / d, covariance.xx / d};
  const double half_y = 5 * std::sqrt(covariance.yy);
  for (std::size_t j = 0; j < map.side(); ++j) {
    const double y = cell_position(map, j);
    if (std::abs(y) > half_y) continue;
    for (std::size_t i = 0; i < map.side(); ++i) {
      const double x = cell_position(map, i), exponent = quadratic(inverse, x, y);
      if (exponent <= 25) visit(j * map.side() + i, x, y, std::exp(-0.5 * exponent));
    }
  }
}

Moments moments_under(const DifferenceMap& map, const std::vector<double>& dip, TangentTensor covariance) {
  Moments sums;
  for_each_in_window(map, covariance, [&](std::size_t c, double x, double y, double w) {
    const double mass = w * dip[c];
    sums.weight += w;
    sums.mass += mass;
    sums.second = sums.second + mass * TangentTensor{x * x, x * y, y * y};
  });
  if (sums.mass != 0) sums.second = (1 / sums.mass) * sums.second;
  return sums;
}

void set_axes(Dip& dip, TensorAxes axes) {
  dip.first = std::sqrt(axes.first);
  dip.second = std::sqrt(axes.second);
  dip.ratio = dip.first / dip.second;
  dip.angle = std::atan2(axes.y, axes.x);
}

struct Fit {
  Dip dip;
  TangentTensor covariance;  // of the dip in the map, the kernel's spread included
};

Fit fit_moments(const DifferenceMap& map, const DifferenceMap& expected, const std::vector<double>& dip,
                const DipParameters& parameters) {
  require(parameters.start > 0 && std::isfinite(parameters.start) && parameters.least_signal > 0 &&
              parameters.iterations > 0,
          "dip: the first window, the least signal and the iterations must be positive");
  Fit fit;
  const double start = parameters.start * parameters.start;
  fit.covariance = {start, 0, start};
  // Independent pairs: each counts in two cells, so the variance of a cell is twice its number.
  double variance = 0;
  const double scale = static_cast<double>(map.sets) / expected.sets;
  for_each_in_window(map, fit.covariance, [&](std::size_t c, double, double, double w) {
    if (!(expected.sum[c] > 0)) return;
    variance += 2 * w * w / (scale * expected.sum[c]);
    if (parameters.measured_reference) variance += 2 * w * w / expected.sum[c];
  });
  const Moments first = moments_under(map, dip, fit.covariance);
  if (!(variance > 0)) return fit;
  fit.dip.signal_to_noise = first.mass / std::sqrt(variance);
  fit.dip.depth = first.mass / first.weight;
  if (fit.dip.signal_to_noise < parameters.least_signal) return fit;

  const double widest = 0.25 * map.parameters.range * map.parameters.range;
  const double narrowest = 0.25 * map.cell() * map.cell();
  const double kernel = map.parameters.kernel * map.cell();
  for (std::uint32_t i = 0; i < parameters.iterations; ++i) {
    const Moments sums = moments_under(map, dip, fit.covariance);
    if (!(sums.mass > 0)) return fit;
    const TangentTensor next = 2.0 * sums.second;
    TensorAxes axes = tensor_axes(next);
    if (!(axes.second > narrowest && axes.first < widest)) return fit;
    const TangentTensor change = next + -1.0 * fit.covariance;
    fit.covariance = next;
    const double size = std::abs(change.xx) + 2 * std::abs(change.xy) + std::abs(change.yy);
    if (size > 1e-6 * axes.second) continue;
    axes.first -= kernel * kernel;
    axes.second -= kernel * kernel;
    if (!(axes.second > 0)) return fit;
    const double area = std::numbers::pi * std::sqrt(determinant(fit.covariance));
    fit.dip.depth = moments_under(map, dip, fit.covariance).mass * map.cell() * map.cell() / area;
    set_axes(fit.dip, axes);
    fit.dip.found = true;
    return fit;
  }
  return fit;
}

}  // namespace

Dip dip_moments(const DifferenceMap& map, const DifferenceMap& expected, const DipParameters& parameters) {
  return fit_moments(map, expected, dip_values(map, expected), parameters).dip;
}

Dip dip_contour(const DifferenceMap& map, const DifferenceMap& expected, const DipParameters& parameters) {
  const std::vector<double> values = dip_values(map, expected);
  Fit fit = fit_moments(map, expected, values, parameters);
  if (!fit.dip.found) return fit.dip;
  const auto lost = [&] {
    fit.dip.found = false;
    fit.dip.first = fit.dip.second = fit.dip.ratio = fit.dip.angle = 0;
    return fit.dip;
  };
  // Bilinear between the centers of cells; 0 (no dip) beyond them.
  const auto value_at = [&](double x, double y) {
    const double u = (x + map.parameters.range) / map.cell() - 0.5;
    const double v = (y + map.parameters.range) / map.cell() - 0.5;
    const auto side = static_cast<double>(map.side());
    if (!(u >= 0 && v >= 0 && u < side - 1 && v < side - 1)) return 0.0;
    const auto i = static_cast<std::size_t>(u), j = static_cast<std::size_t>(v);
    const double s = u - std::floor(u), t = v - std::floor(v);
    const double* low = values.data() + j * map.side() + i;
    const double* high = low + map.side();
    return (1 - t) * ((1 - s) * low[0] + s * low[1]) + t * ((1 - s) * high[0] + s * high[1]);
  };
  constexpr int directions = 64;
  constexpr double step = 0.02, most = 4;  // standard deviations of the dip
  const TangentTensor root = apply(fit.covariance, [](double c) { return std::sqrt(c); });
  const double level = 0.5 * fit.dip.depth;
  double area = 0;
  TangentTensor second;
  for (int k = 0; k < directions; ++k) {
    const double angle = std::numbers::pi * (k + 0.5) / directions;  // the map is symmetric
    const double c = std::cos(angle), s = std::sin(angle);
    const double dx = root.xx * c + root.xy * s, dy = root.xy * c + root.yy * s;
    double r = 0, before = value_at(0, 0), here = before;
    while (here > level && r < most) {
      before = here;
      r += step;
      here = value_at(r * dx, r * dy);
    }
    if (r == 0 || here > level) return lost();
    r -= step * (level - here) / (before - here);
    area += 0.5 * r * r;
    const double fourth = 0.25 * r * r * r * r;
    second = second + fourth * TangentTensor{c * c, c * s, s * s};
  }
  second = (1 / area) * second;
  // Back to the map: root second root. The half-axes of an ellipse are twice the roots of its moments.
  const auto times = [](TangentTensor m, double x, double y) {
    return std::array<double, 2>{m.xx * x + m.xy * y, m.xy * x + m.yy * y};
  };
  const auto column_x = times(second, root.xx, root.xy), column_y = times(second, root.xy, root.yy);
  const TangentTensor contour = {root.xx * column_x[0] + root.xy * column_x[1],
                                 root.xx * column_y[0] + root.xy * column_y[1],
                                 root.xy * column_y[0] + root.yy * column_y[1]};
  const TensorAxes axes = tensor_axes(4.0 * contour);
  if (!(axes.second > 0)) return lost();
  set_axes(fit.dip, axes);
  return fit.dip;
}

std::vector<std::array<double, 2>> half_depth_ellipse(const Dip& dip, std::size_t count) {
  const double half_depth = std::sqrt(2 * std::log(2.0)), c = std::cos(dip.angle), s = std::sin(dip.angle);
  std::vector<std::array<double, 2>> points;
  for (std::size_t i = 0; i < count; ++i) {
    const double t = 2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(count);
    const double a = half_depth * dip.first * std::cos(t), b = half_depth * dip.second * std::sin(t);
    points.push_back({a * c - b * s, a * s + b * c});
  }
  return points;
}

std::vector<std::uint32_t> ratio_classes(std::span<const double> s1, std::span<const double> s2,
                                         std::span<const double> edges) {
  require(s1.size() == s2.size(), "ratio_classes: as many s1 as s2");
  for (std::size_t k = 1; k < edges.size(); ++k)
    require(edges[k] > edges[k - 1], "ratio_classes: edges must ascend");
  std::vector<std::uint32_t> classes(s1.size());
  for (std::size_t i = 0; i < s1.size(); ++i)
    classes[i] = static_cast<std::uint32_t>(std::upper_bound(edges.begin(), edges.end(), s1[i] / s2[i]) -
                                            edges.begin());
  return classes;
}

DifferenceMap expected_differences(const DifferenceParameters& parameters, std::uint64_t samples,
                                   std::uint64_t counted) {
  require(counted <= samples, "expected_differences: more samples counted than there are");
  DifferenceMap map = expected_differences(parameters, samples);
  const double share = samples > 0 ? static_cast<double>(counted) / static_cast<double>(samples) : 0;
  for (double& value : map.sum) value *= share;
  return map;
}

}  // namespace meander
