// Quality of a flat chart: flips, distortion, overlap.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "kernels/flatten/flatten_chart.h"

namespace meander {

// Lengths and areas of a chart's triangles on the surface in the metric of MeasuredMesh::length, shared by
// all attempts on the chart. A triangle counts when its area is above 1e-12 of its longest edge squared:
// thinner ones have no direction in double.
struct ChartGeometry {
  std::vector<double> length;        // 3 T edge lengths, not mollified
  std::vector<double> area;          // T
  std::vector<std::uint8_t> counts;  // T: 1 where the triangle counts
  double total_area = 0;             // of the triangles that count
};
ChartGeometry chart_geometry(const MeasuredMesh& surface, const CutChart& chart);
// The 3 T edge lengths of the chart: MeasuredMesh::length.
std::vector<double> chart_edge_lengths(const MeasuredMesh& surface, const CutChart& chart);

// Chart triangles that count and whose UV orientation is not positive (exact sign). O(T).
std::vector<std::uint32_t> flipped_triangles(std::span<const std::uint32_t> triangles,
                                             std::span<const std::uint8_t> counts, std::span<const double> u,
                                             std::span<const double> v);

// Ratio of the singular values of the map of triangle t, in [1, 1e12]. O(1).
double triangle_distortion(const ChartGeometry& geometry, std::span<const std::uint32_t> triangles,
                           std::span<const double> u, std::span<const double> v, std::uint32_t triangle);

// The distortion from which on a triangle escapes being flipped only by the luck of rounding.
inline constexpr double sliver_distortion = 1000;

// Whether the triangle counts and is flipped or distorted beyond sliver_distortion.
bool is_bad_triangle(const ChartGeometry& geometry, std::span<const std::uint32_t> triangles,
                     std::span<const double> u, std::span<const double> v, std::uint32_t triangle);

// One pass over a map. Weights are 3-D areas; triangles that do not count have none. O(T).
struct MapScan {
  std::vector<std::uint32_t> bad;  // see is_bad_triangle
  std::uint32_t flips = 0;         // triangles whose UV orientation is not positive (exact sign)
  double mean_distortion = 1;
  double capped_distortion = 1;  // mean of min(100, distortion), to compare maps before repair
  double max_distortion = 1;
  double smallest_scale = 1, largest_scale = 1;  // UV area / 3-D area
  double min_uv_edge = 0;                        // of all triangles
};
MapScan scan_map(const ChartGeometry& geometry, std::span<const std::uint32_t> triangles,
                 std::span<const double> u, std::span<const double> v);

// Sum over interior vertices of the winding number of their triangles in UV, less 1: 0 for a map that is
// locally injective, given that no triangle is flipped. O(T).
std::int64_t branch_points(const CutChart& chart, std::span<const double> u, std::span<const double> v);

// Share of the covered UV area that more than one triangle covers, on a raster whose resolution is the power
// of two in 16 .. 512 next above sqrt(8 T); a cell is covered by the triangles that contain its center. UV in
// [0, 1]^2. O(T + cells).
double overlap_share(std::span<const std::uint32_t> triangles, std::span<const double> u,
                     std::span<const double> v);

// Fills the members of ChartReport that follow from the map, all but method, extra seams and repaired
// triangles.
void fill_report(const ChartGeometry& geometry, const MapScan& scan, const CutChart& chart,
                 std::span<const double> u, std::span<const double> v, ChartReport& report);

}  // namespace meander
