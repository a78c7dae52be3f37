#include "kernels/describe/shape_moments.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "kernels/core/parallel.h"
#include "kernels/core/radix_sort.h"
#include "kernels/core/status.h"

namespace meander {

namespace {

// Whether there are as many half-edges from u to v as from v to u, for all u and v.
bool is_closed(std::span<const std::uint32_t> triangles) {
  std::vector<KeyIndex> edges, scratch;
  edges.reserve(triangles.size());
  for (std::size_t h = 0; h < triangles.size(); ++h) {
    const std::uint32_t from = triangles[h], to = triangles[h % 3 == 2 ? h - 2 : h + 1];
    if (from == to) continue;
    edges.push_back({std::uint64_t{std::min(from, to)} << 32 | std::max(from, to), from < to ? 1u : 0u});
  }
  radix_sort(edges, scratch);
  for (std::size_t begin = 0, end = 0; begin < edges.size(); begin = end) {
    std::size_t forward = 0;
    for (end = begin; end < edges.size() && edges[end].key == edges[begin].key; ++end)
      forward += edges[end].index;
    if (2 * forward != end - begin) return false;
  }
  return true;
}

// The sums over triangles, with corners relative to the center of the box in units of the box's longest side.
enum Integral : std::size_t { area, ax, ay, az, xx, yy, zz, xy, xz, yz, volume, vx, vy, vz, integrals };

using Integrals = std::array<double, integrals>;

void add_triangle(Integrals& sum, Vector3 a, Vector3 b, Vector3 c) {
  const Vector3 s = a + b + c;
  const double size = triangle_area(a, b, c), third = size / 3, twelfth = size / 12;
  sum[area] += size;
  sum[ax] += third * s.x;
  sum[ay] += third * s.y;
  sum[az] += third * s.z;
  sum[xx] += twelfth * (a.x * a.x + b.x * b.x + c.x * c.x + s.x * s.x);
  sum[yy] += twelfth * (a.y * a.y + b.y * b.y + c.y * c.y + s.y * s.y);
  sum[zz] += twelfth * (a.z * a.z + b.z * b.z + c.z * c.z + s.z * s.z);
  sum[xy] += twelfth * (a.x * a.y + b.x * b.y + c.x * c.y + s.x * s.y);
  sum[xz] += twelfth * (a.x * a.z + b.x * b.z + c.x * c.z + s.x * s.z);
  sum[yz] += twelfth * (a.y * a.z + b.y * b.z + c.y * c.z + s.y * s.z);
  const double tetrahedron = dot(a, cross(b, c)) / 6, fourth = tetrahedron / 4;
  sum[volume] += tetrahedron;
  sum[vx] += fourth * s.x;
  sum[vy] += fourth * s.y;
  sum[vz] += fourth * s.z;
}

// Chooses the sign that makes the largest component positive.
Vector3 with_positive_lead(Vector3 v) {
  double lead = v.x;
  if (std::abs(v.y) > std::abs(lead)) lead = v.y;
  if (std::abs(v.z) > std::abs(lead)) lead = v.z;
  return lead < 0 ? -1.0 * v : v;
}

}  // namespace

ShapeMoments shape_moments(std::span<const double> x, std::span<const double> y, std::span<const double> z,
                           std::span<const std::uint32_t> triangles) {
  if (triangles.size() < 3) throw ItemError(Status::zero_area, "no triangle to take moments of");
  ShapeMoments moments;
  const auto position = [&](std::size_t corner) {
    const std::uint32_t v = triangles[corner];
    return Vector3{x[v], y[v], z[v]};
  };
  const Vector3 first = position(0);
  Vector3 low = first, high = first;
  for (std::size_t corner = 1; corner < triangles.size(); ++corner) {
    const Vector3 p = position(corner);
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  moments.bbox = {low.x, low.y, low.z, high.x, high.y, high.z};
  const Vector3 center = 0.5 * low + 0.5 * high;
  // Division by the longest side keeps squares within the range of double.
  const double unit = std::max({high.x - low.x, high.y - low.y, high.z - low.z});
  if (!(unit > 0)) throw ItemError(Status::zero_area, "no area to take moments of");

  const std::size_t count = triangles.size() / 3;
  std::vector<Integrals> parts((count + sum_block - 1) / sum_block, Integrals{});
  parallel_blocks(count, sum_block, [&](std::size_t begin, std::size_t end) {
    const auto working = [&](std::size_t corner) {
      const Vector3 p = position(corner) - center;
      return Vector3{p.x / unit, p.y / unit, p.z / unit};
    };
    for (std::size_t t = begin; t < end; ++t)
      add_triangle(parts[begin / sum_block], working(3 * t), working(3 * t + 1), working(3 * t + 2));
  });
  Integrals sum{};
  for (const Integrals& part : parts)
    for (std::size_t k = 0; k < integrals; ++k) sum[k] += part[k];
  if (!(sum[area] > 0)) throw ItemError(Status::zero_area, "no area to take moments of");

  const double square = unit * unit;
  moments.area = sum[area] * square;
  const Vector3 mean{sum[ax] / sum[area], sum[ay] / sum[area], sum[az] / sum[area]};
  moments.centroid = center + unit * mean;
  // Second moments about the centroid (parallel axes), then inertia: trace - moment.
  const double mxx = sum[xx] - sum[area] * mean.x * mean.x, myy = sum[yy] - sum[area] * mean.y * mean.y,
               mzz = sum[zz] - sum[area] * mean.z * mean.z, mxy = sum[xy] - sum[area] * mean.x * mean.y,
               mxz = sum[xz] - sum[area] * mean.x * mean.z, myz = sum[yz] - sum[area] * mean.y * mean.z;
  Eigen::Matrix3d tensor;
  tensor << myy + mzz, -mxy, -mxz, -mxy, mxx + mzz, -myz, -mxz, -myz, mxx + myy;
  const double fourth = square * square;
  moments.inertia = {fourth * tensor(0, 0), fourth * tensor(1, 1), fourth * tensor(2, 2),
                     fourth * tensor(0, 1), fourth * tensor(0, 2), fourth * tensor(1, 2)};
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(tensor);
  for (int k = 0; k < 3; ++k) {
    const auto axis = solver.eigenvectors().col(k);
    const auto at = static_cast<std::size_t>(k);
    moments.principal_moments[at] = fourth * std::max(0.0, solver.eigenvalues()[k]);
    moments.principal_axes[at] = with_positive_lead({axis[0], axis[1], axis[2]});
  }
  moments.principal_axes[2] = cross(moments.principal_axes[0], moments.principal_axes[1]);

  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  moments.closed = is_closed(triangles);
  moments.volume = moments.closed ? sum[volume] * square * unit : nan;
  moments.volume_centroid = {nan, nan, nan};
  if (moments.closed && sum[volume] != 0)
    moments.volume_centroid = center + (unit / sum[volume]) * Vector3{sum[vx], sum[vy], sum[vz]};
  return moments;
}

std::array<double, shape_basics_count> shape_basics(const ShapeMoments& moments) {
  const Vector3 low{moments.bbox[0], moments.bbox[1], moments.bbox[2]};
  const Vector3 high{moments.bbox[3], moments.bbox[4], moments.bbox[5]};
  const Vector3 sides = high - low, center = 0.5 * low + 0.5 * high;
  const double d = norm(sides), size = moments.area / d / d;
  const Vector3 offset = moments.centroid - center, solid_offset = moments.volume_centroid - center;
  const double volume = moments.volume / d / d / d;
  std::array<double, 3> principal{};
  for (std::size_t k = 0; k < 3; ++k) principal[k] = moments.principal_moments[k] / moments.area / d / d;
  return {size,
          volume,
          36 * std::numbers::pi * volume * volume / (size * size * size),
          sides.x / d,
          sides.y / d,
          sides.z / d,
          offset.x / d,
          offset.y / d,
          offset.z / d,
          solid_offset.x / d,
          solid_offset.y / d,
          solid_offset.z / d,
          principal[0],
          principal[1],
          principal[2],
          std::sqrt(0.5 * (principal[0] + principal[1] + principal[2]))};  // the trace counts each axis twice
}

}  // namespace meander
