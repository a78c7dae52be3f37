#include "kernels/flatten/chart_report.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "kernels/core/portable_angles.h"
#include "kernels/flatten/orient2d.h"
#include "kernels/mesh/half_edges.h"
#include "kernels/solve/intrinsic_disk.h"

namespace meander {

namespace {

constexpr double thinnest = 1e-12;           // area / longest edge^2 of a triangle that counts
constexpr double largest_distortion = 1e12;  // reported for collapsed triangles

struct Uv {
  double u, v;
};

// Marks the cells whose centers lie in the triangle. Edges are evaluated from their lower end, so that every
// center belongs to exactly one of neighboring triangles.
class CoverageRaster {
 public:
  explicit CoverageRaster(std::size_t side) : side_(side), cells_(side * side, 0) {}

  void add(Uv a, Uv b, Uv c) {
    Uv p[3] = {scaled(a), scaled(b), scaled(c)};
    std::sort(p, p + 3, [](Uv x, Uv y) { return x.v < y.v || (x.v == y.v && x.u < y.u); });
    const std::ptrdiff_t begin = first_center(p[0].v), end = first_center(p[2].v);
    for (std::ptrdiff_t row = begin; row < end; ++row) {
      const double center = static_cast<double>(row) + 0.5;
      double left = crossing(p[0], p[2], center);
      double right = center < p[1].v ? crossing(p[0], p[1], center) : crossing(p[1], p[2], center);
      if (left > right) std::swap(left, right);
      std::uint8_t* cells = cells_.data() + static_cast<std::size_t>(row) * side_;
      const std::ptrdiff_t last = first_center(right);
      for (std::ptrdiff_t column = first_center(left); column < last; ++column)
        cells[column] = cells[column] == 0 ? 1 : 2;
    }
  }

  double overlap() const {
    std::size_t covered = 0, twice = 0;
    for (const std::uint8_t cell : cells_) {
      covered += cell > 0;
      twice += cell > 1;
    }
    return covered == 0 ? 0.0 : static_cast<double>(twice) / static_cast<double>(covered);
  }

 private:
  Uv scaled(Uv p) const { return {p.u * static_cast<double>(side_), p.v * static_cast<double>(side_)}; }
  // The first cell whose center is at or above x.
  std::ptrdiff_t first_center(double x) const {
    return std::clamp(static_cast<std::ptrdiff_t>(std::ceil(x - 0.5)), std::ptrdiff_t{0},
                      static_cast<std::ptrdiff_t>(side_));
  }
  static double crossing(Uv low, Uv high, double v) {
    return low.u + (v - low.v) * ((high.u - low.u) / (high.v - low.v));
  }

  std::size_t side_;
  std::vector<std::uint8_t> cells_;
};

double length_of(double x, double y) { return std::sqrt(x * x + y * y); }

double finite_ratio(double large, double small) {
  return small > large / 1e300 ? large / small : (large > 0 ? 1e300 : 1.0);
}

}  // namespace

std::vector<double> chart_edge_lengths(const MeasuredMesh& surface, const CutChart& chart) {
  std::vector<double> length(chart.triangles.size());
  for (std::uint32_t h = 0; h < length.size(); ++h) {
    const std::uint32_t other = chart.opposite[h];
    length[h] = other != no_index && other < h ? length[other] : surface.length(3 * chart.triangle_begin + h);
  }
  return length;
}

// Areas in space are those of the mesh; areas in a metric follow from the lengths.
ChartGeometry chart_geometry(const MeasuredMesh& surface, const CutChart& chart) {
  ChartGeometry geometry;
  const std::size_t count = chart.triangle_count();
  geometry.length = chart_edge_lengths(surface, chart);
  geometry.area.resize(count);
  geometry.counts.resize(count);
  for (std::size_t t = 0; t < count; ++t) {
    const double* l = &geometry.length[3 * t];
    const double longest = std::max({l[0], l[1], l[2]});
    geometry.area[t] = surface.in_space() ? surface.mesh().area[chart.triangle_begin + t]
                                          : area_from_lengths(l[0], l[1], l[2]);
    geometry.counts[t] = geometry.area[t] > thinnest * longest * longest;
    if (geometry.counts[t]) geometry.total_area += geometry.area[t];
  }
  return geometry;
}

std::vector<std::uint32_t> flipped_triangles(std::span<const std::uint32_t> triangles,
                                             std::span<const std::uint8_t> counts, std::span<const double> u,
                                             std::span<const double> v) {
  std::vector<std::uint32_t> flipped;
  for (std::uint32_t t = 0; t < counts.size(); ++t) {
    if (!counts[t]) continue;
    const std::uint32_t a = triangles[3 * t], b = triangles[3 * t + 1], c = triangles[3 * t + 2];
    if (!(orient2d(u[a], v[a], u[b], v[b], u[c], v[c]) > 0)) flipped.push_back(t);
  }
  return flipped;
}

double triangle_distortion(const ChartGeometry& geometry, std::span<const std::uint32_t> triangles,
                           std::span<const double> u, std::span<const double> v, std::uint32_t triangle) {
  const double* l = &geometry.length[3 * std::size_t{triangle}];
  const std::uint32_t* corner = &triangles[3 * std::size_t{triangle}];
  int base = 0;  // the longest edge lies along the first axis of the triangle's own frame
  for (int k = 1; k < 3; ++k)
    if (l[k] > l[base]) base = k;
  const double a = l[base], b = l[(base + 1) % 3], c = l[(base + 2) % 3];
  const double x = 0.5 * (a + (c - b) * (c + b) / a), y = 2 * geometry.area[triangle] / a;
  const std::uint32_t p = corner[base], q = corner[(base + 1) % 3], r = corner[(base + 2) % 3];
  const double ux = (u[q] - u[p]) / a, vx = (v[q] - v[p]) / a;
  const double uy = ((u[r] - u[p]) - ux * x) / y, vy = ((v[r] - v[p]) - vx * x) / y;
  const double conformal = length_of(ux + vy, vx - uy), anti = length_of(ux - vy, vx + uy);
  const double large = conformal + anti, small = std::abs(conformal - anti);
  return large < largest_distortion * small ? large / small : largest_distortion;
}

bool is_bad_triangle(const ChartGeometry& geometry, std::span<const std::uint32_t> triangles,
                     std::span<const double> u, std::span<const double> v, std::uint32_t triangle) {
  if (!geometry.counts[triangle]) return false;
  const std::uint32_t* c = &triangles[3 * std::size_t{triangle}];
  return !(orient2d(u[c[0]], v[c[0]], u[c[1]], v[c[1]], u[c[2]], v[c[2]]) > 0) ||
         triangle_distortion(geometry, triangles, u, v, triangle) > sliver_distortion;
}

MapScan scan_map(const ChartGeometry& geometry, std::span<const std::uint32_t> triangles,
                 std::span<const double> u, std::span<const double> v) {
  MapScan scan;
  double weighted = 0, capped = 0, shortest = std::numeric_limits<double>::infinity();
  double smallest = shortest, largest = 0;
  for (std::uint32_t t = 0; t < geometry.counts.size(); ++t) {
    const std::uint32_t* c = &triangles[3 * std::size_t{t}];
    const double u1 = u[c[1]] - u[c[0]], v1 = v[c[1]] - v[c[0]];
    const double u2 = u[c[2]] - u[c[0]], v2 = v[c[2]] - v[c[0]];
    const double u3 = u2 - u1, v3 = v2 - v1;
    shortest = std::min({shortest, u1 * u1 + v1 * v1, u2 * u2 + v2 * v2, u3 * u3 + v3 * v3});
    if (!geometry.counts[t]) continue;
    const double doubled = orient2d(u[c[0]], v[c[0]], u[c[1]], v[c[1]], u[c[2]], v[c[2]]);
    const double q = triangle_distortion(geometry, triangles, u, v, t);
    const double scale = 0.5 * std::abs(doubled) / geometry.area[t];
    if (!(doubled > 0)) ++scan.flips;
    if (!(doubled > 0) || q > sliver_distortion) scan.bad.push_back(t);
    smallest = std::min(smallest, scale);
    largest = std::max(largest, scale);
    scan.max_distortion = std::max(scan.max_distortion, q);
    weighted += geometry.area[t] * q;
    capped += geometry.area[t] * std::min(q, 100.0);
  }
  scan.min_uv_edge = std::sqrt(shortest);
  if (!(geometry.total_area > 0)) return scan;
  scan.mean_distortion = std::max(1.0, weighted / geometry.total_area);
  scan.capped_distortion = std::max(1.0, capped / geometry.total_area);
  scan.smallest_scale = smallest;
  scan.largest_scale = largest;
  return scan;
}

std::int64_t branch_points(const CutChart& chart, std::span<const double> u, std::span<const double> v) {
  const std::vector<std::uint8_t> on_boundary =
      boundary_vertices(chart.triangles, chart.opposite, chart.vertex_count());
  const auto interior = std::count(on_boundary.begin(), on_boundary.end(), std::uint8_t{0});
  // Signed angles of a triangle sum to +-pi, those around an interior vertex to 2 pi times its winding.
  double total = 0;
  for (std::size_t t = 0; t < chart.triangle_count(); ++t) {
    const std::uint32_t* c = &chart.triangles[3 * t];
    const double sign = orient2d(u[c[0]], v[c[0]], u[c[1]], v[c[1]], u[c[2]], v[c[2]]) < 0 ? -1.0 : 1.0;
    total += sign * std::numbers::pi;
    for (int k = 0; k < 3; ++k) {
      if (!on_boundary[c[k]]) continue;
      const std::uint32_t p = c[k], q = c[(k + 1) % 3], r = c[(k + 2) % 3];
      const double ax = u[q] - u[p], ay = v[q] - v[p], bx = u[r] - u[p], by = v[r] - v[p];
      total -= sign * upper_angle(std::abs(ax * by - ay * bx), ax * bx + ay * by);
    }
  }
  return std::llround(total / (2 * std::numbers::pi)) - static_cast<std::int64_t>(interior);
}

double overlap_share(std::span<const std::uint32_t> triangles, std::span<const double> u,
                     std::span<const double> v) {
  const double wanted = std::sqrt(8.0 * static_cast<double>(triangles.size() / 3));
  std::size_t side = 16;
  while (side < 512 && static_cast<double>(side) < wanted) side *= 2;
  CoverageRaster raster(side);
  for (std::size_t t = 0; t + 2 < triangles.size(); t += 3) {
    const std::uint32_t a = triangles[t], b = triangles[t + 1], c = triangles[t + 2];
    raster.add({u[a], v[a]}, {u[b], v[b]}, {u[c], v[c]});
  }
  return raster.overlap();
}

void fill_report(const ChartGeometry& geometry, const MapScan& scan, const CutChart& chart,
                 std::span<const double> u, std::span<const double> v, ChartReport& report) {
  report.triangles = static_cast<std::uint32_t>(chart.triangle_count());
  report.flips = scan.flips;
  report.mean_distortion = scan.mean_distortion;
  report.max_distortion = scan.max_distortion;
  report.area_scale_range = finite_ratio(scan.largest_scale, scan.smallest_scale);
  report.min_uv_edge = scan.min_uv_edge;
  report.overlap = chart.triangle_count() > 1 ? overlap_share(chart.triangles, u, v) : 0.0;
  report.area = 0;
  for (const double a : geometry.area) report.area += a;
}

}  // namespace meander
