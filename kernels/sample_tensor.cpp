#include "kernels/sample_tensor.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "kernels/core/parallel.h"
#include "kernels/describe/describe_samples.h"
#include "kernels/segment/segment_mesh.h"
#include "kernels/tensor/gradient_matching.h"
#include "kernels/tensor/singularities.h"
#include "kernels/tensor/surface_metric.h"

namespace meander {

namespace {

// Multiplies the user's density by one over the area of a cell of the tensor.
void multiply(Density& density, std::vector<double> factor) {
  if (!density.uniform())
    for (std::size_t h = 0; h < factor.size(); ++h) factor[h] *= density.corner[h];
  density.corner = std::move(factor);
}

// Replaces the components by the segments and reorders all per-triangle data except the masses, which are
// computed from the density once the segments are final.
void adopt(ModelState& model, SegmentedMesh segmented) {
  model.tensor = carry_field(segmented, model.tensor);
  model.density.corner = carry_half_edge_values(segmented, model.density.corner);
  if (!model.mesh.metric_length.empty())
    segmented.mesh.metric_length = carry_half_edge_values(segmented, model.mesh.metric_length);
  model.mesh = std::move(segmented.mesh);
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

SegmentChart chart_segment(const ModelState& model, CutChart cut, const SampleParameters& parameters,
                           AlignmentForm form) {
  SegmentChart chart;
  const TensorChartParameters& wanted = parameters.tensor_charts;
  if (form == AlignmentForm::gradient) {
    FieldChart along = flatten_to_field(model.mesh, std::move(cut), model.tensor, {}, model.cancel);
    chart.flat = std::move(along.flat);
    chart.alignment = along.alignment;
  } else {
    FlattenParameters flatten = parameters.flatten;
    flatten.max_flipped_share = wanted.limits.flipped;
    chart.flat = flatten_chart(model.mesh, std::move(cut), flatten, model.cancel);
    if (chart.is_measurable())
      chart.alignment = chart_alignment(model.mesh, chart.flat.cut, model.tensor, chart.flat.u, chart.flat.v);
    if (chart.flat.report.method == Method::conformal) chart.flat.report.method = Method::anisotropic;
  }
  chart.accepted =
      chart.flat.report.method == Method::anisotropic && is_accepted(chart.alignment, form, wanted.limits);
  return chart;
}

// Charts of the components that have none yet.
void chart_missing(ModelState& model, std::vector<SegmentChart>& charts, const SampleParameters& parameters,
                   AlignmentForm form) {
  parallel_tasks(charts.size(), [&](std::size_t c) {
    const Component& component = model.mesh.components[c];
    if (!(component.area > 0) || !charts[c].flat.cut.triangles.empty()) return;
    CutChart cut = c < model.cuts.size() && !model.cuts[c].triangles.empty()
                       ? std::move(model.cuts[c])
                       : cut_to_disk(model.mesh, component, parameters.cut, model.cancel);
    charts[c] = chart_segment(model, std::move(cut), parameters, form);
  });
  model.cuts.clear();
}

// Updates the chart of a component whose triangles have moved, in the same order.
void move_chart(SegmentChart& chart, const PreparedMesh& mesh, std::uint32_t triangle_begin) {
  CutChart& cut = chart.flat.cut;
  cut.triangle_begin = triangle_begin;
  for (std::size_t h = 0; h < cut.triangles.size(); ++h)
    cut.source_vertex[cut.triangles[h]] = mesh.triangles[3 * std::size_t{triangle_begin} + h];
}

// Components whose chart failed and that are large enough to be halved.
std::vector<std::uint32_t> to_bisect(const ModelState& model, const std::vector<SegmentChart>& charts,
                                     std::uint32_t min_triangles) {
  std::vector<std::uint32_t> failed;
  for (std::uint32_t c = 0; c < charts.size(); ++c) {
    const Component& component = model.mesh.components[c];
    const std::uint32_t triangles = component.triangle_end - component.triangle_begin;
    if (component.area > 0 && !charts[c].accepted && triangles >= 2 * min_triangles) failed.push_back(c);
  }
  return failed;
}

void bisect_failed(ModelState& model, std::vector<SegmentChart>& charts, TriangleSteps& steps,
                   const std::vector<std::uint32_t>& failed) {
  SegmentedMesh segmented = bisect_components(model.mesh, failed, steps, model.cancel);
  std::vector<std::uint8_t> fresh(charts.size(), 0);
  for (const std::uint32_t c : failed) fresh[c] = 1;
  std::vector<SegmentChart> next(segmented.mesh.components.size());
  const std::vector<std::uint32_t> source = segmented.source_component;
  steps.length = carry_half_edge_values(segmented, steps.length);
  steps.weight = carry_half_edge_values(segmented, steps.weight);
  adopt(model, std::move(segmented));
  for (std::size_t c = 0; c < next.size(); ++c) {
    if (fresh[source[c]] || charts[source[c]].flat.cut.triangles.empty()) continue;
    next[c] = std::move(charts[source[c]]);
    move_chart(next[c], model.mesh, model.mesh.components[c].triangle_begin);
  }
  charts = std::move(next);
}

void summarise(ModelState& model, const std::vector<SegmentChart>& charts) {
  AnisotropyReport& report = model.anisotropy;
  report.segments = static_cast<std::uint32_t>(charts.size());
  double area = 0, accepted = 0, measured = 0, angle = 0, ratio = 0;
  for (std::size_t c = 0; c < charts.size(); ++c) {
    const double weight = model.mesh.components[c].area;
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

void make_tensor_segments(ModelState& model, const SampleParameters& parameters) {
  const TensorChartParameters& wanted = parameters.tensor_charts;
  TensorFieldReport field;
  TensorParameters tensor = parameters.tensor;
  if (model.tensor_table) tensor.table = model.tensor_table;
  model.tensor = make_tensor_field(model.file, model.mesh, tensor, model.cancel, &field);
  model.anisotropy.mean_spacing_ratio = field.mean_ratio;
  model.anisotropy.clamped_share = static_cast<double>(field.clamped_triangles) /
                                   static_cast<double>(std::max<std::size_t>(1, model.mesh.triangle_count()));
  multiply(model.density, tensor_density(model.tensor));
  model.masses = triangle_masses(model.mesh, model.density);
  model.row.report.measure = file_measure(model.mesh, model.masses);
  const bool along = wanted.form == AlignmentForm::gradient;
  if (along)
    cut_through_singularities(model.mesh, model.tensor, model.cancel);
  else
    set_surface_metric(model.mesh, model.tensor, model.cancel);
  if (along || wanted.segment.count > model.mesh.components.size())
    adopt(model, segment_mesh(model.mesh, model.tensor, wanted.segment, model.cancel));
}

void flatten_segments(ModelState& model, const SampleParameters& parameters) {
  const TensorChartParameters& wanted = parameters.tensor_charts;
  std::vector<SegmentChart> charts(model.mesh.components.size());
  chart_missing(model, charts, parameters, wanted.form);
  TriangleSteps steps;
  for (std::uint32_t round = 0; round < wanted.max_bisections; ++round) {
    const std::vector<std::uint32_t> failed = to_bisect(model, charts, wanted.segment.min_triangles);
    if (failed.empty()) break;
    if (steps.length.empty()) steps = triangle_steps(model.mesh, model.tensor, wanted.segment.walk);
    bisect_failed(model, charts, steps, failed);
    chart_missing(model, charts, parameters, wanted.form);
  }
  model.masses = triangle_masses(model.mesh, model.density);
  summarise(model, charts);
  if (wanted.form == AlignmentForm::gradient) {
    // Segments without an accepted chart along the directions are charted in the metric.
    set_surface_metric(model.mesh, model.tensor, model.cancel);
    for (SegmentChart& chart : charts)
      if (!chart.accepted) chart = {};
    chart_missing(model, charts, parameters, AlignmentForm::metric);
  }
  model.charts.resize(charts.size());
  for (std::size_t c = 0; c < charts.size(); ++c) model.charts[c] = std::move(charts[c].flat);
}

void add_sample_tensors(ModelState& model) {
  Samples& samples = model.row.samples;
  const std::vector<std::uint32_t> triangles = sample_triangles(model.file, model.mesh, samples);
  // One sample at density d owns the area M / (N d), M the measure of the surface; d is the user's density
  // over s1 s2.
  const double measure = blocked_sum(model.masses) / static_cast<double>(samples.count());
  const double unit = model.mesh.unit / model.row.report.scale;
  samples.tensor_direction.resize(3 * samples.count());
  samples.tensor_spacing.resize(2 * samples.count());
  for (std::size_t i = 0; i < samples.count(); ++i) {
    const double b1 = samples.barycentric[2 * i], b2 = samples.barycentric[2 * i + 1];
    const TensorAxes axes = spacings_of(interpolate(model.tensor, triangles[i], {1 - b1 - b2, b1, b2}));
    const TangentFrame plane = triangle_frame(model.mesh, triangles[i]);
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

}  // namespace meander
