#include "kernels/tensor/gradient_matching.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "kernels/core/portable_functions.h"
#include "kernels/flatten/chart_report.h"
#include "kernels/flatten/repair_flips.h"
#include "kernels/solve/cotan_laplacian.h"

namespace meander {

namespace {

constexpr double square_margin = 0x1p-12;  // that of fit_square()
constexpr double min_weight = 1e-6;        // of a half-edge, where cotangents defeat the factorization

// With more bad triangles than this, the chart folds as a whole: patches would be slow and would not help.
std::size_t max_repaired(std::size_t triangles) { return std::max<std::size_t>(16, triangles / 50); }

// Scales and shifts the chart into the unit square. Returns the scale.
double fit_unrotated(std::span<double> u, std::span<double> v) {
  if (u.empty()) return 0;
  const auto [left, right] = std::minmax_element(u.begin(), u.end());
  const auto [low, high] = std::minmax_element(v.begin(), v.end());
  const double extent = std::max(*right - *left, *high - *low);
  const double scale = extent > 0 ? (1 - 2 * square_margin) / extent : 0;
  const double center_u = 0.5 * (*left + *right), center_v = 0.5 * (*low + *high);
  for (double& x : u) x = std::clamp(0.5 + scale * (x - center_u), 0.0, 1.0);
  for (double& y : v) y = std::clamp(0.5 + scale * (y - center_v), 0.0, 1.0);
  return scale;
}

struct FieldMap {
  GradientMatch match;
  std::uint32_t repaired = 0;
  std::size_t bad = 0;  // flipped or collapsed triangles
  bool sound = false;   // no flips, no branch points
};

// Data that all attempts on one chart share.
struct FieldDisk {
  const CutChart& cut;
  IntrinsicDisk space;     // mollified lengths in space
  IntrinsicDisk metric;    // lengths in spacings of each triangle: the sides of an edge differ
  ChartGeometry geometry;  // of the metric, for judging flipped or collapsed triangles
  TargetSteps steps;
};

FieldDisk make_field_disk(const CutChart& cut, const ChartGeometry& geometry, IntrinsicDisk space,
                          TargetSteps steps) {
  FieldDisk disk{cut, std::move(space), {}, {}, std::move(steps)};
  disk.metric = disk.space;
  for (std::size_t h = 0; h < disk.metric.length.size(); ++h)
    disk.metric.length[h] = portable::hypot(disk.steps.along[h], disk.steps.across[h]);
  disk.geometry.length = disk.metric.length;
  disk.geometry.counts = geometry.counts;
  disk.geometry.area.resize(geometry.area.size());
  for (std::size_t t = 0; t < geometry.area.size(); ++t) {
    const double* l = &disk.geometry.length[3 * t];
    disk.geometry.area[t] = area_from_lengths(l[0], l[1], l[2]);
    // A large ratio of spacings can reduce the area of a thin triangle to zero.
    if (!(disk.geometry.area[t] > 0)) disk.geometry.counts[t] = 0;
    if (disk.geometry.counts[t]) disk.geometry.total_area += disk.geometry.area[t];
  }
  mollify(disk.metric.length);
  return disk;
}

FieldMap try_weights(const FieldDisk& disk, const IntrinsicDisk& lengths, WorkBudget& budget,
                     const CancelToken& cancel) {
  FieldMap map;
  std::vector<double> weights = corner_geometry(lengths.length).half_cotangent;
  map.match = match_gradients(disk.space, weights, disk.steps, cancel, &budget);
  if (!map.match.finite) {
    // Positive weights make an M-matrix, which has a factor whatever the triangles.
    for (double& w : weights) w = std::max(w, min_weight);
    map.match = match_gradients(disk.space, weights, disk.steps, cancel, &budget);
  }
  if (!map.match.finite) return map;
  std::vector<double>&u = map.match.u, &v = map.match.v;
  MapScan scan = scan_map(disk.geometry, disk.cut.triangles, u, v);
  if (!scan.bad.empty() && scan.bad.size() <= max_repaired(disk.cut.triangle_count())) {
    map.repaired = repair_flips(disk.metric, disk.geometry, scan.bad, u, v, cancel, &budget);
    scan = scan_map(disk.geometry, disk.cut.triangles, u, v);
  }
  map.bad = scan.bad.size();
  map.sound = scan.flips == 0 && branch_points(disk.cut, u, v) == 0;
  return map;
}

}  // namespace

TargetSteps target_steps(const UnfoldedTriangles& unfolded, const CombedDirections& directions) {
  TargetSteps steps;
  steps.along.resize(unfolded.x.size());
  steps.across.resize(unfolded.x.size());
  for (std::size_t h = 0; h < unfolded.x.size(); ++h) {
    const std::size_t t = h / 3;
    const double x = unfolded.x[h], y = unfolded.y[h], ex = directions.x[t], ey = directions.y[t];
    steps.along[h] = (x * ex + y * ey) / directions.first[t];
    steps.across[h] = (y * ex - x * ey) / directions.second[t];
  }
  return steps;
}

GradientMatch match_gradients(const IntrinsicDisk& disk, std::span<const double> weights,
                              const TargetSteps& steps, const CancelToken& cancel, WorkBudget* budget) {
  GradientMatch match;
  std::vector<std::uint8_t> pinned(disk.vertex_count, 0);
  if (pinned.empty()) return match;
  pinned[0] = 1;
  const DirichletLaplacian laplacian(disk, {weights.begin(), weights.end()}, pinned, cancel, budget);
  if (!laplacian.factorized()) return match;
  std::vector<double> right_u(disk.vertex_count, 0), right_v(disk.vertex_count, 0);
  for (std::uint32_t h = 0; h < disk.triangles.size(); ++h) {
    const std::uint32_t from = disk.triangles[h], to = disk.triangles[next_half_edge(h)];
    right_u[from] -= weights[h] * steps.along[h];
    right_u[to] += weights[h] * steps.along[h];
    right_v[from] -= weights[h] * steps.across[h];
    right_v[to] += weights[h] * steps.across[h];
  }
  match.u.assign(disk.vertex_count, 0);
  match.v.assign(disk.vertex_count, 0);
  laplacian.solve(right_u, match.u);
  laplacian.solve(right_v, match.v);
  double energy = 0, wanted = 0;
  for (std::uint32_t h = 0; h < disk.triangles.size(); ++h) {
    const std::uint32_t from = disk.triangles[h], to = disk.triangles[next_half_edge(h)];
    const double du = match.u[to] - match.u[from] - steps.along[h];
    const double dv = match.v[to] - match.v[from] - steps.across[h];
    energy += weights[h] * (du * du + dv * dv);
    wanted += weights[h] * (steps.along[h] * steps.along[h] + steps.across[h] * steps.across[h]);
  }
  match.residual = wanted > 0 ? std::sqrt(std::max(0.0, energy / wanted)) : 0.0;
  const auto finite = [](double x) { return std::isfinite(x); };
  match.finite = std::all_of(match.u.begin(), match.u.end(), finite) &&
                 std::all_of(match.v.begin(), match.v.end(), finite);
  return match;
}

FieldChart flatten_to_field(const PreparedMesh& mesh, CutChart cut, const TensorField& field,
                            const FieldFlattenParameters& parameters, const CancelToken& cancel) {
  FieldChart result;
  result.flat.cut = std::move(cut);
  const CutChart& chart = result.flat.cut;
  const ChartGeometry geometry = chart_geometry(mesh, chart);
  IntrinsicDisk space;
  space.triangles = chart.triangles;
  space.opposite = chart.opposite;
  space.length = geometry.length;
  space.vertex_count = static_cast<std::uint32_t>(chart.vertex_count());
  mollify(space.length);
  const UnfoldedTriangles unfolded = unfold_triangles(geometry);
  const CombedDirections directions =
      comb_directions(chart, geometry, unfolded, field, parameters.comb, cancel);
  result.inconsistent_edges = directions.inconsistent_edges;
  result.odd_vertices = static_cast<std::uint32_t>(directions.odd_vertices.size());
  const FieldDisk disk =
      make_field_disk(chart, geometry, std::move(space), target_steps(unfolded, directions));
  WorkBudget budget = flatten_budget(chart.triangle_count(), parameters.effort);
  FieldMap best = try_weights(disk, disk.space, budget, cancel);
  if (!best.sound) {
    FieldMap second = try_weights(disk, disk.metric, budget, cancel);
    if (second.match.finite &&
        (!best.match.finite || second.sound || (!best.sound && second.bad < best.bad))) {
      best = std::move(second);
      result.source = FieldMapSource::metric_weights;
    }
  }
  if (!best.match.finite) return result;
  std::vector<double>&u = result.flat.u, &v = result.flat.v;
  u = std::move(best.match.u);
  v = std::move(best.match.v);
  result.residual = best.match.residual;
  result.spacing = fit_unrotated(u, v);
  ChartReport& report = result.flat.report;
  report.repaired_triangles = best.repaired;
  fill_report(geometry, scan_map(geometry, chart.triangles, u, v), chart, u, v, report);
  report.method = best.sound && report.flips == 0 ? Method::anisotropic : Method::none;
  result.alignment = chart_alignment(mesh, chart, field, u, v);
  return result;
}

}  // namespace meander
