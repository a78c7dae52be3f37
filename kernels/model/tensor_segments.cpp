#include "kernels/model/tensor_segments.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

#include "kernels/core/parallel.h"
#include "kernels/cut/cut_to_disk.h"
#include "kernels/tensor/gradient_matching.h"
#include "kernels/tensor/singularities.h"
#include "kernels/tensor/surface_metric.h"

namespace meander {

namespace {

// Multiplies the user's density by one over the area of a cell of the tensor.
Density times(const Density& density, std::vector<double> factor) {
  if (!density.uniform())
    for (std::size_t h = 0; h < factor.size(); ++h) factor[h] *= density.corner[h];
  Density product;
  product.corner = std::move(factor);
  return product;
}

template <class Value>
std::vector<Value> carry_triangle_values(const SegmentedMesh& segmented, const std::vector<Value>& values) {
  std::vector<Value> carried;
  carried.reserve(values.size());
  for (const std::uint32_t source : segmented.source_triangle) carried.push_back(values[source]);
  return carried;
}

// Takes on a finer segmentation of the present segments and reorders all per-triangle data.
void adopt(TensorSegments& segments, SegmentedMesh segmented) {
  segments.tensor = carry_field(segmented, segments.tensor);
  segments.measure.density.corner = carry_half_edge_values(segmented, segments.measure.density.corner);
  segments.measure.masses = carry_triangle_values(segmented, segments.measure.masses);
  segments.source_triangle = carry_triangle_values(segmented, segments.source_triangle);
  if (!segments.metric_length.empty())
    segments.metric_length = carry_half_edge_values(segmented, segments.metric_length);
  segments.mesh = std::move(segmented.mesh);
}

// Slits through the singularities of odd index, so that a direction can be chosen everywhere.
void cut_through_singularities(PreparedMesh& mesh, const TensorField& field, const CancelToken& cancel) {
  const TensorField mean = mean_on_triangles(field);
  const std::vector<Singularity> singularities = find_singularities(mesh, mean, true, cancel);
  for (const std::uint32_t h : connect_singularities(mesh, mean, singularities, {}, cancel)) {
    mesh.opposite[mesh.opposite[h]] = no_index;
    mesh.opposite[h] = no_index;
  }
}

// The chart of one segment and how well it follows the field.
struct SegmentChart {
  FlatChart flat;
  AlignmentReport alignment;
  bool accepted = false;

  // Without a finite map a chart has no coordinates.
  bool is_measurable() const { return !flat.u.empty(); }
};

// The effort for a half, relative to a whole segment: enough for all seams, and many rounds cannot multiply
// the work.
constexpr double effort_of_halves = 0.25;

// effort: see FlattenParameters.
SegmentChart chart_segment(const TensorSegments& segments, CutChart cut, const SampleParameters& parameters,
                           AlignmentForm form, double effort, const CancelToken& cancel) {
  SegmentChart chart;
  const TensorChartParameters& wanted = parameters.tensor_charts;
  if (form == AlignmentForm::gradient) {
    FieldChart along = flatten_to_field(segments.mesh, std::move(cut), segments.tensor, {{}, effort}, cancel);
    chart.flat = std::move(along.flat);
    chart.alignment = along.alignment;
  } else {
    FlattenParameters flatten = parameters.flatten;
    flatten.max_flipped_share = wanted.limits.flipped;
    flatten.max_mean_distortion = std::max(flatten.max_mean_distortion, metric_mean_distortion);
    flatten.effort *= effort;
    chart.flat = flatten_chart(segments.measured(), std::move(cut), flatten, cancel);
    if (chart.is_measurable()) chart.alignment = chart_alignment(segments.mesh, segments.tensor, chart.flat);
    if (chart.flat.report.method == Method::conformal) chart.flat.report.method = Method::anisotropic;
  }
  chart.accepted =
      chart.flat.report.method == Method::anisotropic && is_accepted(chart.alignment, form, wanted.limits);
  return chart;
}

// Charts of the components that have none yet.
void chart_missing(const TensorSegments& segments, std::vector<SegmentChart>& charts,
                   const SampleParameters& parameters, AlignmentForm form, double effort,
                   const CancelToken& cancel) {
  parallel_tasks(charts.size(), [&](std::size_t c) {
    const Component& component = segments.mesh.components[c];
    if (!(component.area > 0) || !charts[c].flat.cut.triangles.empty()) return;
    charts[c] = chart_segment(segments, cut_to_disk(segments.measured(), component, parameters.cut, cancel),
                              parameters, form, effort, cancel);
  });
}

// Updates the chart of a component whose triangles have moved, in the same order.
void move_chart(SegmentChart& chart, const PreparedMesh& mesh, std::uint32_t triangle_begin) {
  CutChart& cut = chart.flat.cut;
  cut.triangle_begin = triangle_begin;
  for (std::size_t h = 0; h < cut.triangles.size(); ++h)
    cut.source_vertex[cut.triangles[h]] = mesh.triangles[3 * std::size_t{triangle_begin} + h];
}

// Components of at least two triangles and some area whose chart, and number of triangles, fail the test.
template <class Fails>
std::vector<std::uint32_t> to_bisect(const PreparedMesh& mesh, const std::vector<SegmentChart>& charts,
                                     const Fails& fails) {
  std::vector<std::uint32_t> failed;
  for (std::uint32_t c = 0; c < charts.size(); ++c) {
    const Component& component = mesh.components[c];
    const std::uint32_t triangles = component.triangle_end - component.triangle_begin;
    if (component.area > 0 && triangles >= 2 && fails(charts[c], triangles)) failed.push_back(c);
  }
  return failed;
}

void bisect_failed(TensorSegments& segments, std::vector<SegmentChart>& charts, TriangleSteps& steps,
                   const std::vector<std::uint32_t>& failed, const RandomWalkParameters& walk,
                   const CancelToken& cancel) {
  if (steps.length.empty()) steps = triangle_steps(segments.mesh, segments.tensor, walk);
  SegmentedMesh segmented = bisect_components(segments.mesh, failed, steps, cancel);
  std::vector<std::uint8_t> fresh(charts.size(), 0);
  for (const std::uint32_t c : failed) fresh[c] = 1;
  std::vector<SegmentChart> next(segmented.mesh.components.size());
  const std::vector<std::uint32_t> source = segmented.source_component;
  steps.length = carry_half_edge_values(segmented, steps.length);
  steps.weight = carry_half_edge_values(segmented, steps.weight);
  adopt(segments, std::move(segmented));
  for (std::size_t c = 0; c < next.size(); ++c) {
    if (fresh[source[c]] || charts[source[c]].flat.cut.triangles.empty()) continue;
    next[c] = std::move(charts[source[c]]);
    move_chart(next[c], segments.mesh, segments.mesh.components[c].triangle_begin);
  }
  charts = std::move(next);
}

void summarize(const PreparedMesh& mesh, const std::vector<SegmentChart>& charts, AnisotropyReport& report) {
  report.segments = static_cast<std::uint32_t>(charts.size());
  double area = 0, accepted = 0, measured = 0, angle = 0, ratio = 0;
  for (std::size_t c = 0; c < charts.size(); ++c) {
    const double weight = mesh.components[c].area;
    if (!(weight > 0)) continue;
    area += weight;
    if (charts[c].accepted) accepted += weight;
    if (!charts[c].is_measurable()) continue;
    measured += weight;
    angle += weight * charts[c].alignment.mean_angle;
    ratio += weight * charts[c].alignment.mean_ratio;
  }
  if (!(area > 0)) return;
  report.accepted_share = accepted / area;
  if (!(measured > 0)) return;
  report.mean_angle = angle / measured;
  report.mean_chart_ratio = ratio / measured;
}

}  // namespace

TensorSegments make_tensor_segments(const PolygonMesh& file, const PreparedMesh& surface,
                                    const Density& density, const TensorParameters& tensor,
                                    const TensorChartParameters& wanted, const CancelToken& cancel) {
  TensorSegments segments;
  TensorFieldReport field;
  segments.mesh = surface;
  segments.tensor = make_tensor_field(file, surface, tensor, cancel, &field);
  segments.report.mean_spacing_ratio = field.mean_ratio;
  segments.report.clamped_share = static_cast<double>(field.clamped_triangles) /
                                  static_cast<double>(std::max<std::size_t>(1, surface.triangle_count()));
  segments.measure = measure_of(surface, times(density, tensor_density(segments.tensor)));
  segments.source_triangle.resize(surface.triangle_count());
  std::iota(segments.source_triangle.begin(), segments.source_triangle.end(), 0u);
  segments.file_measure = file_measure(surface, segments.measure.total());
  const bool along = wanted.form == AlignmentForm::gradient;
  if (along)
    cut_through_singularities(segments.mesh, segments.tensor, cancel);
  else
    segments.metric_length = surface_metric(segments.mesh, segments.tensor, cancel);
  if (along || wanted.segment.count > segments.mesh.components.size())
    adopt(segments, segment_mesh(segments.mesh, segments.tensor, wanted.segment, cancel));
  return segments;
}

std::vector<FlatChart> chart_segments(TensorSegments& segments, const SampleParameters& parameters,
                                      const CancelToken& cancel) {
  const TensorChartParameters& wanted = parameters.tensor_charts;
  std::vector<SegmentChart> charts(segments.mesh.components.size());
  chart_missing(segments, charts, parameters, wanted.form, 1, cancel);
  TriangleSteps steps;
  const auto bisect = [&](AlignmentForm form, const auto& fails) {
    for (std::uint32_t round = 0; round < wanted.max_bisections; ++round) {
      const std::vector<std::uint32_t> failed = to_bisect(segments.mesh, charts, fails);
      if (failed.empty()) return;
      bisect_failed(segments, charts, steps, failed, wanted.segment.walk, cancel);
      chart_missing(segments, charts, parameters, form, effort_of_halves, cancel);
    }
  };
  bisect(wanted.form, [&](const SegmentChart& chart, std::uint32_t triangles) {
    return !chart.accepted && triangles >= 2 * wanted.segment.min_triangles;
  });
  if (wanted.form == AlignmentForm::gradient) {
    summarize(segments.mesh, charts, segments.report);
    // Segments without an accepted chart along the directions are charted in the metric.
    segments.metric_length = surface_metric(segments.mesh, segments.tensor, cancel);
    for (SegmentChart& chart : charts)
      if (!chart.accepted) chart = {};
    chart_missing(segments, charts, parameters, AlignmentForm::metric, 1, cancel);
  }
  // What has no chart in the metric at all would lose it: halves of it, a single triangle at the least, have
  // one.
  bisect(AlignmentForm::metric, [](const SegmentChart& chart, std::uint32_t) {
    return chart.flat.report.method != Method::anisotropic;
  });
  if (wanted.form == AlignmentForm::metric) summarize(segments.mesh, charts, segments.report);
  segments.report.segments = static_cast<std::uint32_t>(charts.size());
  std::vector<FlatChart> flat(charts.size());
  for (std::size_t c = 0; c < charts.size(); ++c) flat[c] = std::move(charts[c].flat);
  return flat;
}

void add_sample_tensors(const TensorSegments& segments, double scale, Samples& samples) {
  // One sample at density d owns the area M / (N d), M the measure of the surface; d is the user's density
  // over s1 s2.
  const double measure = blocked_sum(segments.measure.masses) / static_cast<double>(samples.count());
  const double unit = segments.mesh.unit / scale;
  samples.tensor_direction.resize(3 * samples.count());
  samples.tensor_spacing.resize(2 * samples.count());
  for (std::size_t i = 0; i < samples.count(); ++i) {
    const std::uint32_t triangle = samples.triangle[i];
    const double b1 = samples.barycentric[2 * i], b2 = samples.barycentric[2 * i + 1];
    const TensorAxes axes = spacings_of(interpolate(segments.tensor, triangle, {1 - b1 - b2, b1, b2}));
    const TangentFrame plane = triangle_frame(segments.mesh, triangle);
    const Vector3 direction = axes.x * plane.x + axes.y * plane.y;
    const double size =
        unit * std::sqrt(measure / (static_cast<double>(samples.density[i]) * axes.first * axes.second));
    samples.tensor_direction[3 * i] = static_cast<float>(direction.x);
    samples.tensor_direction[3 * i + 1] = static_cast<float>(direction.y);
    samples.tensor_direction[3 * i + 2] = static_cast<float>(direction.z);
    samples.tensor_spacing[2 * i] = static_cast<float>(size * axes.first);
    samples.tensor_spacing[2 * i + 1] = static_cast<float>(size * axes.second);
  }
}

LocalMetric metric_at(const TensorSegments& segments, std::uint32_t triangle, double b1, double b2) {
  const TensorAxes axes = spacings_of(interpolate(segments.tensor, triangle, {1 - b1 - b2, b1, b2}));
  const TangentFrame plane = triangle_frame(segments.mesh, triangle);
  const Vector3 along = axes.x * plane.x + axes.y * plane.y, normal = cross(plane.x, plane.y),
                across = cross(normal, along);
  const double stretch = std::sqrt(axes.first / axes.second);
  const auto row = [](const Vector3& v) {
    return std::array<float, 3>{static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
  };
  LocalMetric metric;
  metric.rows = {row((1 / stretch) * along), row(stretch * across), row(normal)};
  metric.stretch = static_cast<float>(stretch);
  return metric;
}

std::vector<DescriptorRow> anisotropy_rows(const AnisotropyReport& report) {
  const std::array<double, anisotropy_names.size()> values = {static_cast<double>(report.segments),
                                                              report.accepted_share,
                                                              report.mean_angle,
                                                              report.mean_chart_ratio,
                                                              report.mean_spacing_ratio,
                                                              report.clamped_share};
  std::vector<DescriptorRow> rows;
  for (std::size_t i = 0; i < values.size(); ++i)
    rows.push_back({anisotropy_names[i], {static_cast<float>(values[i])}});
  return rows;
}

}  // namespace meander
