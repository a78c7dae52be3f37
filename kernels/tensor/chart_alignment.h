// How well a chart follows a field of wanted spacings: acceptance of segments (docs/METHODS.md 9.8).
#pragma once

#include <cstdint>
#include <numbers>
#include <span>
#include <vector>

#include "kernels/cut/cut_to_disk.h"
#include "kernels/flatten/flatten_chart.h"
#include "kernels/tensor/tensor_field.h"

namespace meander {

// What a chart is made to follow: directions and stretch (form A), or the field's metric up to a rotation and
// a scale per triangle (form B).
enum class AlignmentForm : std::uint8_t { gradient, metric };

// Measures per chart triangle, of J = d(u, v) / dx against S of the triangle's mean log S. Triangles that do
// not count (see ChartGeometry) have weight 0 and perfect values.
struct TriangleAlignment {
  std::vector<double> angle;    // T: between J^-1 (1, 0) and e1, [0, pi / 2]; 0 where s1 / s2 < 1.05
  std::vector<double> stretch;  // T: |log(sigma1 / sigma2 * s2 / s1)|, sigma the singular values of J
  std::vector<double> ratio;   // T: singular-value ratio of J S, >= 1: 1 where the metric is kept up to scale
  std::vector<double> weight;  // T: area, working units squared
  std::vector<std::uint8_t> anisotropic;  // T: s1 / s2 >= 1.05
};

// Quantiles are by area: the share of the area with a larger value is at most 5 %.
struct AlignmentReport {
  double mean_angle = 0, angle_95 = 0;      // radians
  double mean_stretch = 0, stretch_95 = 0;  // of the logarithm
  double mean_ratio = 1, ratio_95 = 1;      // values are cut at 1e12
  double anisotropic_share = 0;             // of the area: s1 / s2 >= 1.05
  std::uint32_t flips = 0;                  // triangles that count and are not positive in UV (exact sign)
  double flipped_share = 0;                 // of the area
  double overlap = 0;                       // overlap_share() of the chart placed in the unit square
  double area = 0;                          // that was weighed, working units squared
};

struct AlignmentLimits {
  double angle = 15 * std::numbers::pi / 180;  // of the 95 % quantile, radians; (0, pi / 2]
  double stretch = 0.4054651081081644;         // of the 95 % quantile: log 1.5; > 0
  double ratio = 1.5;                          // of the 95 % quantile, form B; > 1
  double flipped = 0.01;  // share of the area: flipped triangles disturb the order of the curve only within
                          // their own size; [0, 1]
  double overlap = 0.01;  // share of the UV area covered twice, the resolution of the raster; [0, 1]
};

// u and v may have any scale; their axes matter for the angle: form A's are those of gradient matching, never
// rotated. O(T).
TriangleAlignment triangle_alignment(const PreparedMesh& mesh, const CutChart& chart,
                                     const TensorField& field, std::span<const double> u,
                                     std::span<const double> v);
// O(T).
AlignmentReport chart_alignment(const PreparedMesh& mesh, const CutChart& chart, const TensorField& field,
                                std::span<const double> u, std::span<const double> v);
// Of a chart that has its place in the unit square and its overlap measured there (flatten_chart).
AlignmentReport chart_alignment(const PreparedMesh& mesh, const TensorField& field, const FlatChart& flat);

// Form A: angle and stretch; form B: the ratio; both: flips and overlap within the limits.
bool is_accepted(const AlignmentReport& report, AlignmentForm form, const AlignmentLimits& limits = {});

}  // namespace meander
