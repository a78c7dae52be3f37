// Anisotropic sampling: fields, segments, their charts and curves, and measures of samples in the metric.
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>

#include "jobs/laboratory/functions/laboratory_functions.h"
#include "kernels/analyse/curve_chains.h"
#include "kernels/analyse/discrepancy_anisotropic.h"
#include "kernels/analyse/pair_density.h"
#include "kernels/density/pieces.h"
#include "kernels/mesh/prepare_mesh.h"
#include "kernels/rays/embree_locator.h"
#include "kernels/sample/point_frames.h"
#include "kernels/tensor/chart_alignment.h"
#include "kernels/tensor/make_tensor_field.h"
#include "kernels/tensor/singularities.h"

namespace meander {

namespace {

void add_point(std::vector<double>& to, const PreparedMesh& mesh, Vector3 working) {
  const Vector3 p = to_file(mesh, working);
  to.insert(to.end(), {p.x, p.y, p.z});
}

// Takes vertices (V, 3), faces (T, 3) and run, options of `meander run`. Returns the singularities of their
// tensor field: positions (S, 3) in units of the file, half_turns (S,), twice the index; mean_ratio of the
// two spacings over the area; and the euler characteristic.
LaboratoryResult field_singularities(const LaboratoryArguments& given) {
  const PolygonMesh file = given.mesh();
  const PreparedMesh surface = prepare_mesh(file);
  TensorFieldReport report;
  const TensorField field = make_tensor_field(file, surface, parameters_of(given).tensor, {}, &report);
  std::vector<double> positions, half_turns;
  for (const Singularity& s : find_singularities(surface, field)) {
    add_point(positions, surface, s.position);
    half_turns.push_back(s.half_turns);
  }
  double euler = 0;
  for (const Component& c : surface.components) euler += 2 - 2.0 * c.genus - c.boundary_loops;
  LaboratoryResult result;
  result.add("positions", std::move(positions), 3);
  result.add("half_turns", std::move(half_turns));
  result.add("mean_ratio", report.mean_ratio);
  result.add("euler", euler);
  return result;
}

// The field on the triangles of the segments, whose corners are those of their source triangles.
TensorField field_on_segments(const Model& model, const TensorParameters& parameters) {
  const TensorField field = make_tensor_field(model.file, model.surface, parameters);
  TensorField result;
  for (const std::uint32_t source : model.segments.source_triangle)
    for (std::size_t k = 0; k < 3; ++k) result.corner.push_back(field.corner[3 * std::size_t{source} + k]);
  return result;
}

const Model& staged_segments(const LaboratoryArguments& given) {
  const Model& model = given.staged();
  if (model.charts.empty() || model.charts.size() != model.segments.mesh.components.size())
    throw std::invalid_argument("a model that was staged by the method anisotropic is needed");
  return model;
}

// Takes a model staged by the method anisotropic. Returns
//   for each charted triangle: corners (T, 9) in units of the file; vertices (T, 3), numbers that all
//   segments share;
//     uv (T, 6) in the unit square (NaN without a chart); face (T,) of the file; source (T,), the number that
//     samples give as `triangle`; segment (T,); edges (T, 3) from corner k to the next: 0 inner, 1 on a seam
//     of the chart, 2 on the border of the segment;
//   for the field of run, which may differ from the field of the charts: ratio (T,) of the spacings, and
//   angle (T,)
//     between the longer one and the u axis of the chart, in radians;
//   for each segment: area (S,) in squared units of the file; anisotropic (S,): 1, or 0 if its chart does not
//   follow
//     the tensor;
//   accepted_share, the share of the area in charts within the limits.
LaboratoryResult segment_charts(const LaboratoryArguments& given) {
  const Model& model = staged_segments(given);
  const PreparedMesh& mesh = model.segments.mesh;
  const TensorField field = field_on_segments(model, parameters_of(given).tensor);
  const std::size_t triangles = mesh.triangle_count();
  std::vector<double> corners, uv(6 * triangles, std::numeric_limits<double>::quiet_NaN()), ratio,
      angle(triangles), area, anisotropic;
  std::vector<std::uint32_t> vertices, segment(triangles), edges(3 * triangles);
  for (std::uint32_t t = 0; t < triangles; ++t) {
    for (std::uint32_t k = 0; k < 3; ++k) {
      add_point(corners, mesh, mesh.position(mesh.triangles[3 * t + k]));
      vertices.push_back(model.surface.triangles[3 * model.segments.source_triangle[t] + k]);
    }
    const TensorAxes spacings = spacings_of(interpolate(field, t, {1.0 / 3, 1.0 / 3, 1.0 / 3}));
    ratio.push_back(spacings.first / spacings.second);
  }
  for (std::uint32_t c = 0; c < mesh.components.size(); ++c) {
    const Component& component = mesh.components[c];
    const FlatChart& chart = model.charts[c];
    area.push_back(file_area(mesh, component.area));
    anisotropic.push_back(chart.report.method == Method::anisotropic ? 1 : 0);
    const bool flat = chart.report.method != Method::none && !chart.u.empty();
    if (flat) {
      const TriangleAlignment each = triangle_alignment(mesh, chart.cut, field, chart.u, chart.v);
      std::copy(each.angle.begin(), each.angle.end(), angle.begin() + component.triangle_begin);
    }
    for (std::uint32_t t = component.triangle_begin; t < component.triangle_end; ++t) segment[t] = c;
    for (std::uint32_t h = 3 * component.triangle_begin; h < 3 * component.triangle_end; ++h) {
      const std::uint32_t own = h - 3 * component.triangle_begin;
      if (mesh.opposite[h] == no_index)
        edges[h] = 2;
      else if (flat && chart.cut.opposite[own] == no_index)
        edges[h] = 1;
      if (!flat) continue;
      uv[2 * std::size_t{h}] = chart.u[chart.cut.triangles[own]];
      uv[2 * std::size_t{h} + 1] = chart.v[chart.cut.triangles[own]];
    }
  }
  LaboratoryResult result;
  result.add("corners", std::move(corners), 9);
  result.add("vertices", std::move(vertices), 3);
  result.add("uv", std::move(uv), 6);
  result.add("face", mesh.polygon);
  result.add("source", model.segments.source_triangle);
  result.add("segment", std::move(segment));
  result.add("edges", std::move(edges), 3);
  result.add("ratio", std::move(ratio));
  result.add("angle", std::move(angle));
  result.add("area", std::move(area));
  result.add("anisotropic", std::move(anisotropic));
  result.add("accepted_share", model.segments.report.accepted_share);
  return result;
}

// Takes a model staged by the method anisotropic, and run, n and leaves_per_sample as in `samples`. Returns
// the curve over each chart, refined by area and clipped to the chart, as chains of points: points (P, 3) in
// units of the file, uv (P, 2), chain (P,), counted over all charts, and segment (P,); and leaves (S,) of the
// curves of the segments.
LaboratoryResult segment_curves(const LaboratoryArguments& given) {
  const Model& model = staged_segments(given);
  const PreparedMesh& mesh = model.segments.mesh;
  constexpr std::uint32_t steps = 12;  // of a link between two leaves
  LocateParameters parameters = parameters_of(given).locator;
  parameters.min_component_samples = 1;
  // The sampler gives every chart at least three levels, which would make small charts black in a drawing.
  std::map<int, std::vector<CurveTree>> by_levels;
  for (const int levels : {1, 2, parameters.curve.max_depth}) {
    LocateParameters own = parameters;
    own.curve.max_depth = levels;
    by_levels[levels] = build_curves(mesh, model.charts, model.segments.measure.masses, own);
  }
  std::vector<double> points, uv, leaves;
  std::vector<std::uint32_t> chain_of, segment_of;
  std::uint32_t chains = 0;
  for (std::uint32_t c = 0; c < model.charts.size(); ++c) {
    const double expected = static_cast<double>(parameters.samples) * parameters.curve.leaves_per_sample *
                            mesh.components[c].area / mesh.total_area;
    const int levels = expected < 2 ? 1 : expected < 8 ? 2 : parameters.curve.max_depth;
    const CurveTree& tree = by_levels.at(levels)[c];
    leaves.push_back(static_cast<double>(tree.leaf_count()));
    for (const CurveChain& chain : curve_chains(mesh, model.charts[c], tree, steps)) {
      for (std::size_t i = 0; i < chain.u.size(); ++i) {
        add_point(points, mesh, chain.position[i]);
        uv.insert(uv.end(), {chain.u[i], chain.v[i]});
        chain_of.push_back(chains);
        segment_of.push_back(c);
      }
      ++chains;
    }
  }
  LaboratoryResult result;
  result.add("points", std::move(points), 3);
  result.add("uv", std::move(uv), 2);
  result.add("chain", std::move(chain_of));
  result.add("segment", std::move(segment_of));
  result.add("leaves", std::move(leaves));
  return result;
}

// Takes a model staged by the method anisotropic, and n and seed as in `samples`. Returns the pieces of the
// surface in the order of the curve: corners (E, 9) in units of the file; triangle (E,) of segment_charts;
// position (E,), the mass before a piece and half of its own in units of samples, whose integer part is the
// number of the stratum.
LaboratoryResult segment_pieces(const LaboratoryArguments& given) {
  staged_segments(given);
  const Model model = sampled_model(given);
  const PreparedMesh& mesh = model.segments.mesh;
  const auto* const along_curve = std::get_if<CurveElements>(&model.order);
  if (along_curve == nullptr) throw std::invalid_argument("the pieces must lie along a curve");
  const CurveElements& elements = *along_curve;
  const auto n = static_cast<double>(model.row.samples.count());
  const MeasuredMesh measured = model.segments.measured();
  PieceWalk walk(measured);
  std::vector<double> corners, position;
  for (std::size_t e = 0; e < elements.count(); ++e) {
    const std::uint32_t t = elements.triangle[e];
    const Piece& piece = walk.to(t, elements.path[e]);
    for (std::size_t k = 0; k < 3; ++k) {
      const double b0 = 1 - piece.b1[k] - piece.b2[k];
      add_point(corners, mesh,
                b0 * mesh.position(mesh.triangles[3 * t]) +
                    piece.b1[k] * mesh.position(mesh.triangles[3 * t + 1]) +
                    piece.b2[k] * mesh.position(mesh.triangles[3 * t + 2]));
    }
    position.push_back(n * (0.5 * (elements.cumulative[e] + elements.cumulative[e + 1]) / elements.total()));
  }
  LaboratoryResult result;
  result.add("corners", std::move(corners), 9);
  result.add("triangle", elements.triangle);
  result.add("position", std::move(position));
  return result;
}

// Takes points (n, 2) in the unit square, ratio of the spacings, angle of the longer one in radians, shapes,
// windows and seed. Returns the maximum errors over disks, boxes and triangles of the metric; the points in a
// window, and the windows with points.
LaboratoryResult metric_discrepancy(const LaboratoryArguments& given) {
  AnisotropicDiscrepancyParameters parameters;
  parameters.shapes.shapes = static_cast<std::uint32_t>(given.whole("shapes"));
  parameters.shapes.seed = given.whole("seed", 1);
  parameters.shapes.stable_rise = 0;  // sets are compared: the same number of shapes for all
  parameters.windows = static_cast<std::uint32_t>(given.whole("windows"));
  const double half = 0.5 * std::log(given.real("ratio")), angle = given.real("angle");
  const AnisotropicDiscrepancy found =
      anisotropic_discrepancy(given.column("points", 2, 0), given.column("points", 2, 1),
                              tensor_of({half, -half, std::cos(angle), std::sin(angle)}), parameters);
  LaboratoryResult result;
  result.add("disks", found.disks);
  result.add("boxes", found.boxes);
  result.add("triangles", found.triangles);
  result.add("points", found.points);
  result.add("windows", static_cast<double>(found.windows));
  return result;
}

DifferenceMap empty_map(const LaboratoryArguments& given) {
  DifferenceParameters parameters;
  parameters.range = given.real("range");
  parameters.cells = static_cast<std::uint32_t>(given.whole("cells"));
  return make_difference_map(parameters);
}

// Takes points, normals and directions of the longer spacing (n, 3), spacings (n, 2), optional counted (n,)
// uint8, the samples in whose frame pairs count (default: all), units (spacings or area), range of the map to
// each side, and cells of a side. Returns map (cells, cells): pairs per cell by their difference in the frame
// of the longer spacing; rows by the difference across, ascending.
LaboratoryResult tensor_differences(const LaboratoryArguments& given) {
  DifferenceMap map = empty_map(given);
  TensorDifferenceParameters parameters;
  const std::string units = given.text("units");
  if (units != "spacings" && units != "area") throw std::invalid_argument("units must be spacings or area");
  if (units == "area") parameters.units = DifferenceUnits::area;
  if (given.has("counted")) parameters.counted = given.bytes("counted");
  const std::vector<double> s1 = given.column("spacings", 2, 0), s2 = given.column("spacings", 2, 1);
  add_anisotropic_surface_differences(
      map, {given.reals("points", 3), given.reals("normals", 3), given.reals("directions", 3), s1, s2},
      parameters);
  LaboratoryResult result;
  result.add("map", std::move(map.sum), map.side());
  return result;
}

// Takes map and reference (cells, cells), the sums of tensor_differences over `sets` sets of samples and over
// `reference_sets` independent ones in the same field, range and cells. Returns differences (cells, cells)
// over those of the reference, and the ellipse of the dip in their middle by adaptive moments: found (1 or
// 0), depth, ratio of its axes, angle of the longer one in radians, signal_to_noise, and ellipse (64, 2) at
// half of its depth.
LaboratoryResult difference_dip(const LaboratoryArguments& given) {
  DifferenceMap map = empty_map(given), reference = map;
  const auto fill = [&](DifferenceMap& filled, const char* name, const char* sets) {
    const std::span<const double> sum = given.reals(name, filled.side());
    if (sum.size() != filled.sum.size())
      throw std::invalid_argument("a map must have as many rows as columns");
    filled.sum.assign(sum.begin(), sum.end());
    filled.sets = static_cast<std::uint32_t>(given.whole(sets));
  };
  fill(map, "map", "sets");
  fill(reference, "reference", "reference_sets");
  DipParameters parameters;
  parameters.measured_reference = true;
  const Dip dip = dip_moments(map, reference, parameters);
  LaboratoryResult result;
  result.add("found", dip.found ? 1 : 0);
  result.add("depth", dip.depth);
  result.add("ratio", dip.ratio);
  result.add("angle", dip.angle);
  result.add("signal_to_noise", dip.signal_to_noise);
  result.add("differences", normalized_differences(map, reference), map.side());
  std::vector<double> ellipse;
  if (dip.found)
    for (const auto& [x, y] : half_depth_ellipse(dip, 64)) ellipse.insert(ellipse.end(), {x, y});
  result.add("ellipse", std::move(ellipse), 2);
  return result;
}

constexpr LaboratoryFunction tensor_table[] = {{"field_singularities", field_singularities},
                                               {"segment_charts", segment_charts},
                                               {"segment_curves", segment_curves},
                                               {"segment_pieces", segment_pieces},
                                               {"metric_discrepancy", metric_discrepancy},
                                               {"tensor_differences", tensor_differences},
                                               {"difference_dip", difference_dip}};

}  // namespace

const std::span<const LaboratoryFunction> tensor_functions = tensor_table;

}  // namespace meander
