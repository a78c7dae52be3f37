// Models sampled through the stages, and what is measured of their anisotropic samples.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include "kernels/analyse/pair_density.h"
#include "kernels/analyse/tangent_samples.h"
#include "kernels/describe/describe_samples.h"
#include "kernels/mesh/prepare_mesh.h"
#include "kernels/model/model.h"
#include "kernels/tensor/vertex_tensors.h"

namespace meander::test {

// A model up to its charts; only the last stages run again for other samples.
struct ChartedModel {
  Model state;
  SampleParameters parameters;
  std::vector<TangentFrame> normals;  // at its vertices
};

inline SampleParameters anisotropic(TensorKind kind = TensorKind::curvature,
                                    AlignmentForm form = AlignmentForm::metric) {
  SampleParameters parameters;
  parameters.method = MethodChoice::anisotropic;
  parameters.tensor.kind = kind;
  parameters.tensor_charts.form = form;
  if (form == AlignmentForm::gradient) parameters.tensor_charts.segment.count = 16;
  return parameters;
}

// One row of six numbers per vertex: s1 along the direction, s2 across it and out of the surface.
using TableFormula = std::function<std::pair<Vector3, std::array<double, 2>>(Vector3 point)>;
inline TensorTable table_of(const PolygonMesh& mesh, const TableFormula& formula) {
  TensorTable table;
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    auto [d, s] = formula({mesh.x[v], mesh.y[v], mesh.z[v]});
    const double length = norm(d);
    if (length > 0)
      d = 1 / length * d;
    else
      s = {1, 1};
    const double extra = s[0] - s[1];
    for (const double value : {s[1] + extra * d.x * d.x, extra * d.x * d.y, extra * d.x * d.z,
                               s[1] + extra * d.y * d.y, extra * d.y * d.z, s[1] + extra * d.z * d.z})
      table.values.push_back(value);
  }
  return table;
}

inline ChartedModel charted(PolygonMesh file, SampleParameters parameters,
                            std::shared_ptr<const TensorTable> table = nullptr) {
  ChartedModel model;
  if (table) {
    parameters.tensor.kind = TensorKind::table;
    parameters.tensor.table = std::move(table);
  }
  model.parameters = std::move(parameters);
  model.state.file = std::move(file);
  run_stages(charting_stages(model.parameters), model.state);
  model.normals = vertex_frames(model.state.surface);
  return model;
}

inline const Samples& draw(ChartedModel& model, std::uint32_t n, std::uint64_t seed,
                           SequenceKind sequence = SequenceKind::shifted) {
  static const EmbreeDevice device;
  SampleParameters parameters = model.parameters;
  parameters.samples = n;
  parameters.sequence = sequence;
  model.state.key = make_random_key(seed, {});
  run_stages(placing_stages(parameters, &device), model.state);
  return model.state.row.samples;
}

// Samples with the spacings of a field. Normals are those of the vertices, interpolated: the curvature that
// geodesic lengths need.
struct FieldSamples {
  std::vector<double> points, normals, axes, s1, s2;
  TangentSamples view() const { return {points, normals, axes, s1, s2}; }
};

// `isotropic`: the spacings sqrt(area / N) whatever the field's, along its directions.
inline FieldSamples field_samples(const ChartedModel& model, const Samples& samples, bool isotropic = false) {
  FieldSamples out;
  out.points.assign(samples.points.begin(), samples.points.end());
  out.axes.assign(samples.tensor_direction.begin(), samples.tensor_direction.end());
  const std::vector<std::uint32_t>& triangles = samples.triangle;
  const ItemReport& report = model.state.row.report;
  const double spacing = std::sqrt(report.area / static_cast<double>(samples.count())) / report.scale;
  for (std::size_t i = 0; i < samples.count(); ++i) {
    const double b1 = samples.barycentric[2 * i], b2 = samples.barycentric[2 * i + 1];
    const std::uint32_t* corner = &model.state.surface.triangles[3 * std::size_t{triangles[i]}];
    const Vector3 normal = (1 - b1 - b2) * model.normals[corner[0]].normal +
                           b1 * model.normals[corner[1]].normal + b2 * model.normals[corner[2]].normal;
    const Vector3 flat = triangle_frame(model.state.surface, triangles[i]).normal;
    const Vector3 used = norm(normal) > 1e-3 ? normal : flat;
    out.normals.insert(out.normals.end(), {used.x, used.y, used.z});
    out.s1.push_back(isotropic ? spacing : static_cast<double>(samples.tensor_spacing[2 * i]));
    out.s2.push_back(isotropic ? spacing : static_cast<double>(samples.tensor_spacing[2 * i + 1]));
  }
  return out;
}

// Standard deviation of a dip along the map's x axis over that along y: greater or less than 1, so that noise
// does not only enlarge it.
inline double axis_ratio(const Dip& dip) {
  const double c = std::cos(dip.angle), s = std::sin(dip.angle);
  const double a = dip.first * dip.first, b = dip.second * dip.second;
  return std::sqrt((a * c * c + b * s * s) / (a * s * s + b * c * c));
}

// Samples to compare: `sets` of n points by the sequence, and three times as many sets of independent points
// in the same field as the expectation.
struct DipStudy {
  std::uint32_t samples = 4096, sets = 4;
  DifferenceUnits units = DifferenceUnits::spacings;
  SequenceKind sequence = SequenceKind::shifted;
  bool isotropic = false;                                          // see field_samples
  double low = 0, high = std::numeric_limits<double>::infinity();  // ratios s1 / s2 that count: [low, high)
};
struct DipFound {
  Dip dip;
  double wanted = 1;  // geometric mean of s1 / s2 of the samples that count
  double share = 0;   // of the samples
};
inline DipFound dip_of(ChartedModel& model, const DipStudy& study) {
  DifferenceParameters map;
  map.range = study.units == DifferenceUnits::area ? 3.5 : 2.5;
  map.cells = study.units == DifferenceUnits::area ? 160 : 100;
  DifferenceMap found = make_difference_map(map), expected = make_difference_map(map);
  DipFound result;
  double logs = 0, counted = 0, all = 0;
  for (std::uint32_t set = 0; set < 4 * study.sets; ++set) {
    const bool reference = set >= study.sets;
    const FieldSamples samples = field_samples(
        model, draw(model, study.samples, 1 + set, reference ? SequenceKind::random : study.sequence),
        study.isotropic);
    std::vector<std::uint8_t> counts(samples.s1.size(), 1);
    for (std::size_t i = 0; i < counts.size(); ++i) {
      const double ratio = samples.s1[i] / samples.s2[i];
      counts[i] = ratio >= study.low && ratio < study.high;
      all += !reference;
      if (!counts[i] || reference) continue;
      logs += std::log(ratio);
      ++counted;
    }
    TensorDifferenceParameters parameters;
    parameters.units = study.units;
    parameters.counted = counts;
    add_anisotropic_surface_differences(reference ? expected : found, samples.view(), parameters);
  }
  DipParameters parameters;
  parameters.measured_reference = true;
  result.dip = dip_moments(found, expected, parameters);
  if (counted > 0) result.wanted = std::exp(logs / counted);
  result.share = counted / all;
  return result;
}

}  // namespace meander::test
