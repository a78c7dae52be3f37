#include "kernels/analyse/discrepancy_sphere.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <vector>

#include "kernels/core/random.h"
#include "kernels/core/vector3.h"

namespace meander {

namespace {

// Uniform on the sphere: Lambert's map of draw `draw` of shape `number`.
Vector3 random_direction(RandomKey key, std::uint32_t number, std::uint32_t draw) {
  const UnitPair u = random_pair(key, Stream::test_shapes, number, draw);
  const double angle = 2 * std::numbers::pi * u.first, z = 1 - 2 * u.second;
  const double radius = std::sqrt(std::max(0.0, (1 - z) * (1 + z)));
  return {radius * std::cos(angle), radius * std::sin(angle), z};
}

// Share of the sphere below height h.
double share_below(double h) { return 0.5 * (1 + std::clamp(h, -1.0, 1.0)); }

}  // namespace

ShapeDiscrepancy cap_discrepancy(std::span<const double> x, std::span<const double> y,
                                 std::span<const double> z, const ShapeParameters& parameters) {
  const std::size_t n = x.size();
  if (n == 0 || y.size() != n || z.size() != n)
    throw std::invalid_argument("a discrepancy needs points, and as many x as y and z");
  const RandomKey key = make_random_key(parameters.seed, {});
  const auto points = static_cast<double>(n);
  // Instead of sorting all heights: count them in slices, bound the discrepancy inside each slice by the
  // counts at its ends, and sort only those slices that can hold the maximum.
  const std::size_t slices = std::clamp<std::size_t>(std::bit_ceil(n / 4 + 1), 16, 1u << 18);
  const double scale = 0.5 * static_cast<double>(slices);
  return max_over_shapes(parameters, [&](std::uint32_t number, double best) {
    const Vector3 axis = random_direction(key, number, 0);
    const auto height = [&](std::size_t i) { return axis.x * x[i] + axis.y * y[i] + axis.z * z[i]; };
    const auto slice_of = [&](double h) {
      return static_cast<std::size_t>(std::clamp((h + 1) * scale, 0.0, static_cast<double>(slices - 1)));
    };
    std::vector<std::uint32_t> before(slices + 1, 0);
    for (std::size_t i = 0; i < n; ++i) ++before[slice_of(height(i)) + 1];
    double most = 0;
    for (std::size_t s = 0; s < slices; ++s) {
      before[s + 1] += before[s];
      const double share = static_cast<double>(s + 1) / static_cast<double>(slices);
      most = std::max(most, std::abs(before[s + 1] / points - share));
    }
    const double bar = std::max(best, most);
    std::vector<std::uint8_t> chosen(slices, 0);
    bool any = false;
    for (std::size_t s = 0; s < slices; ++s) {
      const double low = static_cast<double>(s) / static_cast<double>(slices);
      const double high = static_cast<double>(s + 1) / static_cast<double>(slices);
      const double bound = std::max(before[s + 1] / points - low, high - before[s] / points);
      chosen[s] = before[s + 1] > before[s] && bound > bar;
      any = any || chosen[s] != 0;
    }
    if (!any) return most;
    std::vector<double> heights;
    for (std::size_t i = 0; i < n; ++i)
      if (const double h = height(i); chosen[slice_of(h)] != 0) heights.push_back(h);
    std::sort(heights.begin(), heights.end());
    std::size_t slice = slices, rank = 0;
    for (const double h : heights) {
      if (slice_of(h) != slice) {
        slice = slice_of(h);
        rank = before[slice];
      }
      const double share = share_below(h), below = static_cast<double>(rank) / points;
      most = std::max({most, share - below, below + 1 / points - share});
      ++rank;
    }
    return most;
  });
}

ShapeDiscrepancy spherical_triangle_discrepancy(const PointIndex<3>& points,
                                                const ShapeParameters& parameters) {
  if (points.count() == 0) throw std::invalid_argument("a discrepancy needs points");
  const RandomKey key = make_random_key(parameters.seed, {});
  return max_over_shapes(parameters, [&](std::uint32_t number, double) {
    Vector3 a = random_direction(key, number, 0), b = random_direction(key, number, 1),
            c = random_direction(key, number, 2);
    double volume = dot(a, cross(b, c));
    if (volume < 0) {
      std::swap(b, c);
      volume = -volume;
    }
    const double area = 2 * std::atan2(volume, 1 + dot(a, b) + dot(b, c) + dot(c, a));
    const auto inside = [](Vector3 from, Vector3 to) {
      const Vector3 outward = cross(to, from);
      const double length = norm(outward);
      return HalfSpace<3>{{outward.x / length, outward.y / length, outward.z / length}, 0};
    };
    if (!(volume > 0)) return 0.0;
    const std::array<HalfSpace<3>, 3> sides = {inside(a, b), inside(b, c), inside(c, a)};
    return std::abs(static_cast<double>(count_inside(points, sides)) / static_cast<double>(points.count()) -
                    area / (4 * std::numbers::pi));
  });
}

}  // namespace meander
