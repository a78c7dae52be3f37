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

// The target of a chart: directions and stretch (form A), or the field's metric up to a rotation and a scale
// for each triangle (form B).
enum class AlignmentForm : std::uint8_t { gradient, metric };

// Measures of each chart triangle, of J = d(u, v) / dx against S of the triangle's mean log S. Triangles that
// do not count (see ChartGeometry) have weight 0 and perfect values.
struct TriangleAlignment {
  std::vector<double> angle;    // T: between J^-1 (1, 0) and e1, [0, pi / 2]; 0 where s1 / s2 < 1.05
  std::vector<double> stretch;  // T: |log(sigma1 / sigma2 * s2 / s1)|, sigma the singular values of J
  std::vector<double> ratio;    // T: singular-value ratio of J S, >= 1; 1 keeps the metric up to scale
  std::vector<double> weight;   // T: area, working units squared
  std::vector<std::uint8_t> anisotropic;  // T: s1 / s2 >= 1.05
};

// Quantiles are by area: larger values have at most 5 % of the area.
struct AlignmentReport {
  double mean_angle = 0, angle_95 = 0;      // radians
  double mean_stretch = 0, stretch_95 = 0;  // of the logarithm
  double mean_ratio = 1, ratio_95 = 1;      // values are cut off at 1e12
  double anisotropic_share = 0;             // of the area: s1 / s2 >= 1.05
  std::uint32_t flips = 0;                  // triangles that count and are not positive in UV (exact sign)
  double flipped_share = 0;                 // of the area
  double overlap = 0;                       // overlap_share() of the chart placed in the unit square
  double area = 0;                          // of triangles that count, working units squared
};

struct AlignmentLimits {
  double angle = 15 * std::numbers::pi / 180;  // of the 95 % quantile, radians; (0, pi / 2]
  double stretch = 0.4054651081081644;         // of the 95 % quantile: log 1.5; > 0
  double ratio = 1.5;                          // of the 95 % quantile, form B; > 1
  // Share of the area; [0, 1]. Flipped triangles disturb the order of the curve only within their own size.
  double flipped = 0.01;
  double overlap = 0.01;  // share of the UV area covered twice, at the resolution of the raster; [0, 1]
};

// u and v may have any scale; their axes matter for the angle: those of form A come from gradient matching
// and are never rotated. O(T).
TriangleAlignment triangle_alignment(const PreparedMesh& mesh, const CutChart& chart,
                                     const TensorField& field, std::span<const double> u,
                                     std::span<const double> v);
// The report of a chart with the overlap of its own placement in the unit square. O(T).
AlignmentReport chart_alignment(const PreparedMesh& mesh, const CutChart& chart, const TensorField& field,
                                std::span<const double> u, std::span<const double> v);
// The report of a chart that flatten_chart has placed in the unit square, where it measured the overlap.
// O(T).
AlignmentReport chart_alignment(const PreparedMesh& mesh, const TensorField& field, const FlatChart& flat);

// Whether a chart is within the limits: angle and stretch for form A, the ratio for form B; flips and overlap
// for both.
bool is_accepted(const AlignmentReport& report, AlignmentForm form, const AlignmentLimits& limits = {});

}  // namespace meander
