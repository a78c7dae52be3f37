#include "kernels/analyse/differential_domain.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "kernels/analyse/difference_blocks.h"
#include "kernels/analyse/kd_tree.h"

namespace meander {

using namespace differences;

namespace {

std::vector<double> planar_points(std::span<const double> x, std::span<const double> y,
                                  const PlaneDomain& domain) {
  require(x.size() == y.size(), "differences: as many x as y");
  require(domain.period_x >= 0 && domain.period_y >= 0 && std::isfinite(domain.period_x + domain.period_y),
          "differences: periods are finite and not negative");
  check_finite(x);
  check_finite(y);
  std::vector<double> points(2 * x.size());
  for (std::size_t i = 0; i < x.size(); ++i) {
    points[2 * i] = wrapped(x[i], domain.period_x);
    points[2 * i + 1] = wrapped(y[i], domain.period_y);
  }
  return points;
}

// Calls pair(block map, i, j, dx, dy) once for every pair i < j with |d| <= radius(i), d = point i - point j,
// on the torus; `radius` must be such that pairs that matter are within that of both.
template <class Radius, class Pair>
void add_planar(DifferenceMap& map, std::span<const double> x, std::span<const double> y,
                const PlaneDomain& domain, const Radius& radius, const Pair& pair) {
  const KdTree<2> tree(planar_points(x, y, domain));
  const auto fits = [](double period, double r) { return !(period > 0) || period >= 2 * r; };
  for (std::uint32_t i = 0; i < tree.count(); ++i)
    require(fits(domain.period_x, radius(i)) && fits(domain.period_y, radius(i)),
            "differences: a period must be at least twice the reach");
  add_blocks(map, tree.count(), [&](MapBlock& block, std::size_t p) {
    const std::uint32_t i = tree.index(p);
    const double r = radius(i);
    for_each_image(tree.point(p), domain.period_x, domain.period_y, [&](const auto& image) {
      tree.in_ball(image, r * r, [&](std::uint32_t j, const auto& other) {
        if (j > i) pair(block, i, j, image[0] - other[0], image[1] - other[1]);
      });
    });
  });
}

// Row-major 2 x 2 times a vector.
std::array<double, 2> times(const double* m, double dx, double dy) {
  return {m[0] * dx + m[1] * dy, m[2] * dx + m[3] * dy};
}

// The least singular value of a 2 x 2 matrix: |det| / the largest.
double least_stretch(const double* m) {
  const double sum = std::hypot(m[0] + m[3], m[1] - m[2]), difference = std::hypot(m[0] - m[3], m[1] + m[2]);
  return std::abs(m[0] * m[3] - m[1] * m[2]) / (0.5 * (sum + difference));
}

std::array<double, 2> times(TangentTensor m, double dx, double dy) {
  return {m.xx * dx + m.xy * dy, m.xy * dx + m.yy * dy};
}

}  // namespace

DifferenceMap make_difference_map(const DifferenceParameters& parameters) {
  require(parameters.range > 0 && std::isfinite(parameters.range), "make_difference_map: range > 0");
  require(parameters.cells >= 2 && parameters.cells <= 4096, "make_difference_map: 2..4096 cells");
  require(parameters.kernel > 0 && parameters.kernel <= widest_kernel,
          "make_difference_map: the kernel is in (0, 64] cells");
  DifferenceMap map;
  map.parameters = parameters;
  map.sum.assign(map.side() * map.side(), 0.0);
  return map;
}

void add_differences(DifferenceMap& map, std::span<const double> x, std::span<const double> y, double spacing,
                     const PlaneDomain& domain) {
  check_spacing({&spacing, 1}, 1);
  const double scale = 1 / spacing, radius = reach_of(map.parameters) * spacing;
  add_planar(
      map, x, y, domain, [&](std::uint32_t) { return radius; },
      [&](MapBlock& block, std::uint32_t, std::uint32_t, double dx, double dy) {
        block.add(scale * dx, scale * dy, 1);
      });
}

void add_density_differences(DifferenceMap& map, std::span<const double> x, std::span<const double> y,
                             std::span<const double> spacing, const PlaneDomain& domain) {
  check_spacing(spacing, x.size());
  const double reach = reach_of(map.parameters);
  add_planar(
      map, x, y, domain, [&](std::uint32_t i) { return reach * spacing[i]; },
      [&](MapBlock& block, std::uint32_t i, std::uint32_t j, double dx, double dy) {
        const double most = reach * spacing[j];
        if (dx * dx + dy * dy > most * most) return;
        const double scale = 2 / (spacing[i] + spacing[j]);
        block.add(scale * dx, scale * dy, 1);
      });
}

void add_anisotropic_differences(DifferenceMap& map, std::span<const double> x, std::span<const double> y,
                                 std::span<const double> inverse_jacobian, const PlaneDomain& domain) {
  require(inverse_jacobian.size() == 4 * x.size(), "differences: four numbers of J^-1 a sample");
  check_finite(inverse_jacobian);
  const double reach = reach_of(map.parameters);
  // |J^-1 d| <= reach is within |d| <= reach / least stretch of J^-1.
  std::vector<double> radius(x.size());
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double stretch = least_stretch(inverse_jacobian.data() + 4 * i);
    require(stretch > 0, "differences: J^-1 must not be singular");
    radius[i] = reach / stretch * (1 + 1e-12);
  }
  add_planar(
      map, x, y, domain, [&](std::uint32_t i) { return radius[i]; },
      [&](MapBlock& block, std::uint32_t i, std::uint32_t j, double dx, double dy) {
        const auto a = times(inverse_jacobian.data() + 4 * std::size_t{i}, dx, dy);
        const auto b = times(inverse_jacobian.data() + 4 * std::size_t{j}, dx, dy);
        if (std::max(a[0] * a[0] + a[1] * a[1], b[0] * b[0] + b[1] * b[1]) > reach * reach) return;
        block.add(0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1]), 1);
      });
}

void add_anisotropic_differences(DifferenceMap& map, std::span<const double> x, std::span<const double> y,
                                 std::span<const TangentTensor> log_spacing,
                                 const TensorDifferenceParameters& parameters, const PlaneDomain& domain) {
  const std::size_t samples = x.size();
  require(log_spacing.size() == samples, "differences: one tensor a sample");
  const std::vector<double> weight = half_weights(parameters.counted, samples);
  const bool by_area = parameters.units == DifferenceUnits::area;
  const double reach = reach_of(map.parameters);
  std::vector<TangentTensor> inverse(samples);  // what differences are multiplied with
  std::vector<TensorAxes> axes(samples);
  std::vector<double> radius(samples);
  for (std::size_t i = 0; i < samples; ++i) {
    const TangentTensor log_s = log_spacing[i];
    require(std::isfinite(log_s.xx) && std::isfinite(log_s.xy) && std::isfinite(log_s.yy),
            "differences: tensors must be finite");
    axes[i] = spacings_of(log_s);
    const double size = std::sqrt(axes[i].first * axes[i].second);
    require(axes[i].second > 0 && std::isfinite(axes[i].first), "differences: tensors out of range");
    inverse[i] = by_area ? TangentTensor{1 / size, 0, 1 / size} : exponential(-1.0 * log_s);
    radius[i] = reach * (by_area ? size : axes[i].first) * (1 + 1e-12);
  }
  add_planar(
      map, x, y, domain, [&](std::uint32_t i) { return radius[i]; },
      [&](MapBlock& block, std::uint32_t i, std::uint32_t j, double dx, double dy) {
        const auto a = times(inverse[i], dx, dy), b = times(inverse[j], dx, dy);
        if (std::max(square(a), square(b)) > reach * reach || weight[i] + weight[j] == 0) return;
        const double qx = 0.5 * (a[0] + b[0]), qy = 0.5 * (a[1] + b[1]);
        if (!parameters.principal_axes) {
          block.add(qx, qy, weight[i] + weight[j]);
          return;
        }
        for (const std::uint32_t k : {i, j})
          if (weight[k] > 0)
            block.add(axes[k].x * qx + axes[k].y * qy, axes[k].x * qy - axes[k].y * qx, weight[k]);
      });
}

std::vector<double> spacing_from_density(std::span<const double> density, double measure, double largest) {
  require(measure > 0 && std::isfinite(measure), "spacing_from_density: the measure must be positive");
  require(largest > 0, "spacing_from_density: the largest spacing must be positive");
  std::vector<double> spacing;
  spacing.reserve(density.size());
  for (const double phi : density) {
    require(phi >= 0 && std::isfinite(phi), "spacing_from_density: densities are finite and not negative");
    spacing.push_back(std::min(largest, std::sqrt(measure / (static_cast<double>(density.size()) * phi))));
    require(std::isfinite(spacing.back()), "spacing_from_density: a density of 0 needs a largest spacing");
  }
  return spacing;
}

DifferenceMap expected_differences(const DifferenceParameters& parameters, std::uint64_t samples) {
  DifferenceMap map = make_difference_map(parameters);
  const double pairs = samples > 0 ? static_cast<double>(samples - 1) : 0;
  std::fill(map.sum.begin(), map.sum.end(), pairs * map.cell() * map.cell());
  map.sets = 1;
  return map;
}

DifferenceMap expected_differences(const DifferenceParameters& parameters, std::uint64_t samples,
                                   double width, double height) {
  require(width > 0 && height > 0 && std::isfinite(width) && std::isfinite(height),
          "expected_differences: a rectangle has a width and a height");
  DifferenceMap map = expected_differences(parameters, samples);
  // The expectation is a product: along each axis, the share of the domain that overlaps itself after the
  // shift, spread by the kernel from finely spaced shifts.
  constexpr int steps = 64;  // per cell
  const double spacing = std::sqrt(width * height / static_cast<double>(std::max<std::uint64_t>(samples, 1)));
  const auto along = [&](double extent) {
    std::vector<double> share(map.side(), 0.0);
    AxisWeights weights;
    const double margin = std::ceil(cut_off * parameters.kernel) + 1;
    const double count = (static_cast<double>(map.side()) + 2 * margin) * steps;
    for (double k = 0; k < count; ++k) {
      const double at_cell = (k + 0.5) / steps - margin - 0.5;
      const double shift = spacing * ((at_cell + 0.5) * map.cell() - parameters.range);
      const double overlap = std::max(0.0, 1 - std::abs(shift) / extent);
      weigh(at_cell, parameters.kernel, weights);
      for (std::size_t i = 0; i < weights.count; ++i) {
        const std::ptrdiff_t cell = weights.first + static_cast<std::ptrdiff_t>(i);
        if (cell >= 0 && cell < static_cast<std::ptrdiff_t>(map.side()))
          share[static_cast<std::size_t>(cell)] += weights.weight[i] * overlap / steps;
      }
    }
    return share;
  };
  const std::vector<double> across = along(width), up = along(height);
  for (std::size_t j = 0; j < map.side(); ++j)
    for (std::size_t i = 0; i < map.side(); ++i) map.sum[j * map.side() + i] *= across[i] * up[j];
  return map;
}

std::vector<double> normalized_differences(const DifferenceMap& map, const DifferenceMap& expected) {
  require(map.parameters.range == expected.parameters.range &&
              map.parameters.cells == expected.parameters.cells &&
              map.parameters.kernel == expected.parameters.kernel,
          "normalized_differences: both maps need the same parameters");
  require(map.sets > 0 && expected.sets > 0, "normalized_differences: a map without sets");
  std::vector<double> ratio(map.sum.size());
  const double scale = static_cast<double>(expected.sets) / map.sets;
  for (std::size_t c = 0; c < ratio.size(); ++c)
    ratio[c] =
        expected.sum[c] > 0 ? scale * map.sum[c] / expected.sum[c] : std::numeric_limits<double>::quiet_NaN();
  return ratio;
}

RadialProfile radial_differences(const DifferenceMap& map, std::span<const double> normalized, double width) {
  require(width >= 1, "radial_differences: rings are at least one cell wide");
  return radial_profile(normalized, map.side(), 0, width);
}

}  // namespace meander
