// Anisotropic sampling: the tensor field, the segments that are charted under it, and the tensors at the
// samples (docs/METHODS.md 9).
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "kernels/core/cancel.h"
#include "kernels/data/samples.h"
#include "kernels/density/density.h"
#include "kernels/flatten/flatten_chart.h"
#include "kernels/mesh/measured_mesh.h"
#include "kernels/model/sample_parameters.h"
#include "kernels/sample/spaced_samples.h"
#include "kernels/segment/segment_mesh.h"
#include "kernels/tensor/make_tensor_field.h"

namespace meander {

// What anisotropic sampling found; angles and ratios are means over the area.
struct AnisotropyReport {
  std::uint32_t segments = 0;
  double accepted_share = 0;      // of the area: charts within the limits, [0, 1]
  double mean_angle = 0;          // between a chart's axis and the primary direction, radians
  double mean_chart_ratio = 1;    // singular-value ratio of the chart in the metric, >= 1
  double mean_spacing_ratio = 1;  // s1 / s2 of the field, >= 1
  double clamped_share = 0;       // of the triangles: their ratio was cut to the largest allowed, [0, 1]
};

// Names of the descriptors that hold the fields of AnisotropyReport.
inline constexpr std::array<const char*, 6> anisotropy_names = {
    "segments", "accepted_share", "chart_angle", "chart_ratio", "spacing_ratio", "clamped_share"};

// The mesh that is charted: its components are segments of the surface. A mesh of its own; corner k of a
// triangle is corner k of its source.
struct TensorSegments {
  PreparedMesh mesh;
  std::vector<std::uint32_t> source_triangle;  // T triangles of the surface
  TensorField tensor;
  MeshMeasure measure;  // the user's density over s1 s2 of the tensor
  std::vector<double>
      metric_length;        // 3 T lengths in the tensor's metric; empty while charts follow directions
  double file_measure = 0;  // of the whole surface, units of the file
  AnisotropyReport report;

  MeasuredMesh measured() const { return {mesh, metric_length}; }
};

// The tensor field on the surface and the density that follows from it; then the segments: connected parts,
// for charts that follow the directions cut through the field's singularities as well. Throws ItemError, and
// what `cancel` throws.
TensorSegments make_tensor_segments(const PolygonMesh& file, const PreparedMesh& surface,
                                    const Density& density, const TensorParameters& tensor,
                                    const TensorChartParameters& wanted, const CancelToken& cancel);

// Upper bound of their bytes: field, metric, steps, a second mesh while segments are cut.
constexpr double tensor_bytes(double triangles) {
  constexpr double bytes_per_triangle = 450;
  return triangles * bytes_per_triangle;
}

// Charts of all segments. Segments whose chart does not follow the field well enough are bisected and charted
// again, in rounds; those that have none in the metric, by lack of a sound map or of work (flatten_budget),
// in further rounds down to single triangles. `segments` becomes finer, its report complete. A segment that
// still has none comes back with Method::mean_value or Method::none. Cost: that of its first charts, and at
// most a quarter of their bound in every round.
std::vector<FlatChart> chart_segments(TensorSegments& segments, const SampleParameters& parameters,
                                      const CancelToken& cancel);

// Samples::tensor_direction and tensor_spacing of samples whose triangles are those of the segments. scale:
// file units per unit of the stored points.
void add_sample_tensors(const TensorSegments& segments, double scale, Samples& samples);

// The metric of the tensor at weights b1, b2 of corners 1 and 2 of a triangle of the segments.
LocalMetric metric_at(const TensorSegments& segments, std::uint32_t triangle, double b1, double b2);

// The report as descriptors, by anisotropy_names.
std::vector<DescriptorRow> anisotropy_rows(const AnisotropyReport& report);

}  // namespace meander
