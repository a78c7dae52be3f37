#include "kernels/rays/embree_locator.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <string>

#include "kernels/core/parallel.h"
#include "kernels/core/radix_sort.h"
#include "kernels/flatten/chart_geometry.h"
#include "kernels/rays/chart_scene.h"
#include "kernels/rays/ray_plan.h"
#include "kernels/rays/refine_by_rays.h"
#include "kernels/rays/sheets.h"

namespace meander {

namespace {

// More triangles than there can be sheets over one point mark a collapsed spot of the chart: sheets cannot be
// separated there.
constexpr std::size_t most_conflicting = 16;

// One chart while its rays are cast; `hits` and `sheet` are its part of the result.
struct ChartWork {
  const FlatChart& chart;
  std::span<const double> masses;
  std::vector<double> uv_areas;
  std::span<std::uint32_t> hits;
  std::span<std::uint8_t> sheet;
  ConflictSet conflicts;
  std::uint64_t rays = 0, multiple_hits = 0;
};

// The hits that strictly contain the point in the double-precision chart, by exact tests: rays through
// borders and rounding to float32 do not count as overlap.
std::span<const std::uint32_t> sure_hits(const FlatChart& chart, std::span<const std::uint32_t> hits,
                                         double u, double v,
                                         std::array<std::uint32_t, most_hits_per_ray>& storage) {
  std::size_t count = 0;
  for (const std::uint32_t t : hits)
    if (strictly_inside(uv_triangle(chart, t), u, v)) storage[count++] = t;
  return {storage.data(), count};
}

void add_conflicts(std::span<const std::uint32_t> sure, ConflictSet& conflicts) {
  if (sure.size() > most_conflicting) return;
  for (std::size_t a = 0; a < sure.size(); ++a)
    for (std::size_t b = a + 1; b < sure.size(); ++b) conflicts.add(sure[a], sure[b]);
}

double estimated_mass(const ChartWork& work, std::span<const std::uint32_t> hits, double leaf_area) {
  double sum = 0;
  for (const std::uint32_t t : hits) {
    const double area = work.uv_areas[t];
    sum += area <= leaf_area ? work.masses[t] : work.masses[t] * (leaf_area / area);
  }
  return sum;
}

// Step 2: one ray a leaf, level by level.
void cast_leaf_rays(ChartWork& work, const ChartScene& scene, CurveTree& tree, DepthRange depths,
                    double leaf_mass, std::size_t chart_number, RandomKey key, const CancelToken& cancel) {
  const auto random_point = [&](const CurveTree& nodes, std::size_t i) {
    // The counter identifies a leaf by key, depth and chart, so that its ray does not depend on other leaves.
    const auto counter = static_cast<std::uint32_t>(chart_number * 64 + nodes.depth[i]);
    const UnitPair jitter = random_pair(key, Stream::leaf_ray, nodes.key[i], counter);
    return std::pair(nodes.u[i] + jitter.first * nodes.side[i], nodes.v[i] + jitter.second * nodes.side[i]);
  };
  std::array<std::uint32_t, most_hits_per_ray> storage;
  const auto visit = [&](const CurveTree& nodes, std::size_t i, double u, double v,
                         std::span<const std::uint32_t> hits, bool may_split) {
    if (may_split && estimated_mass(work, hits, nodes.side[i] * nodes.side[i]) > leaf_mass) return true;
    for (const std::uint32_t t : hits) ++work.hits[t];
    if (hits.size() < 2) return false;
    const std::span<const std::uint32_t> sure = sure_hits(work.chart, hits, u, v, storage);
    work.multiple_hits += sure.size() > 1;
    add_conflicts(sure, work.conflicts);
    return false;
  };
  work.rays += refine_by_rays(tree, scene, depths, any_number_of_leaves, cancel, random_point, visit);
}

// Neighbors that turn opposite ways lie on the same side of their edge, so they overlap whatever the rays
// say.
void add_folds(const FlatChart& chart, ConflictSet& conflicts) {
  const std::size_t triangles = chart.cut.triangle_count();
  std::vector<int> turn(triangles);
  for (std::size_t t = 0; t < triangles; ++t) turn[t] = orientation(uv_triangle(chart, t));
  for (std::uint32_t h = 0; h < chart.cut.opposite.size(); ++h) {
    const std::uint32_t other = chart.cut.opposite[h];
    if (other != no_index && h < other && turn[h / 3] * turn[other / 3] < 0) conflicts.add(h / 3, other / 3);
  }
}

// Finds which other triangles contain the centroid of each triangle. Rays are sorted along the curve, since
// the triangles of a file are in arbitrary order (unsorted, a ray costs three times as much). Pairs of
// neighbors are treated like all others: sure_hits omits triangles that merely touch along a border.
void add_centroid_conflicts(ChartWork& work, const ChartScene& scene, const CancelToken& cancel) {
  const std::size_t triangles = work.masses.size();
  std::vector<float> center_u(triangles), center_v(triangles);
  std::vector<KeyIndex> order(triangles), scratch;
  parallel_blocks(triangles, 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) {
      const UvTriangle corners = uv_triangle(work.chart, t);
      center_u[t] = static_cast<float>((corners.u[0] + corners.u[1] + corners.u[2]) / 3);
      center_v[t] = static_cast<float>((corners.v[0] + corners.v[1] + corners.v[2]) / 3);
      const std::uint64_t rank = curve_key(CurveKind::hilbert, center_u[t], center_v[t]) >> 32;
      order[t] = {rank, static_cast<std::uint32_t>(t)};
    }
  });
  radix_sort(order, scratch);
  RayHits hits;
  std::vector<float> u, v;
  std::array<std::uint32_t, most_hits_per_ray> storage;
  for (std::size_t first = 0; first < triangles; first += rays_at_once) {
    const std::size_t count = std::min(rays_at_once, triangles - first);
    u.resize(count);
    v.resize(count);
    for (std::size_t r = 0; r < count; ++r) {
      u[r] = center_u[order[first + r].index];
      v[r] = center_v[order[first + r].index];
    }
    scene.cast(u, v, hits, cancel);
    for (std::size_t r = 0; r < count; ++r) {
      const auto all = hits.of(r);
      if (all.size() < 2) continue;
      const std::uint32_t t = order[first + r].index;
      const auto sure = sure_hits(work.chart, all, u[r], v[r], storage);
      if (sure.size() > most_conflicting || std::find(sure.begin(), sure.end(), t) == sure.end()) continue;
      for (const std::uint32_t other : sure)
        if (other != t) work.conflicts.add(t, other);
    }
  }
  work.rays += triangles;
}

// Two triangles for each of the most leaves: all that rays find on charts that cover themselves once at most.
// Elements, which are as many at least, are kept in bounds where charts do so again and again.
std::uint64_t most_hits(const LocateParameters& parameters, std::size_t triangles) {
  constexpr double layers = 2;
  return static_cast<std::uint64_t>(layers * max_leaves_per_mass(parameters.curve.kind) *
                                    parameters.curve.leaves_per_sample *
                                    static_cast<double>(parameters.samples)) +
         triangles;
}

void limit_hits(std::span<std::uint32_t> hits, std::uint64_t most) {
  const std::uint64_t all = std::accumulate(hits.begin(), hits.end(), std::uint64_t{0});
  if (all <= most) return;
  const double share = static_cast<double>(most) / static_cast<double>(all);
  for (std::uint32_t& count : hits) count = static_cast<std::uint32_t>(std::ceil(count * share));
}

// Step 3.
void tell_sheets_apart(ChartWork& work, const ChartScene& scene, const SheetParameters& parameters,
                       const CancelToken& cancel) {
  add_folds(work.chart, work.conflicts);
  add_centroid_conflicts(work, scene, cancel);
  const std::vector<std::uint8_t> sheet =
      separate_sheets(work.chart.cut.opposite, work.masses, work.conflicts.take(), parameters);
  std::copy(sheet.begin(), sheet.end(), work.sheet.begin());
}

}  // namespace

Located locate_with_embree(const EmbreeDevice& device, const PreparedMesh& mesh,
                           std::span<const FlatChart> charts, std::span<const double> masses,
                           std::vector<CurveTree>& trees, RandomKey key, const LocateParameters& parameters,
                           const CancelToken& cancel) {
  const RayPlan plan = plan_rays(mesh, charts, masses, parameters);
  if (trees.size() != charts.size())
    throw ItemError(Status::internal, "the locator was given " + std::to_string(trees.size()) +
                                          " trees for " + std::to_string(charts.size()) + " charts");
  SheetParameters sheets;
  sheets.max_sheets = parameters.max_sheets;
  sheets.min_mass = parameters.min_sheet_samples * plan.total / static_cast<double>(parameters.samples);
  Located result;
  result.hits.assign(mesh.triangle_count(), 0);
  result.sheet.assign(mesh.triangle_count(), 0);
  std::vector<std::array<std::uint64_t, 3>> counts(charts.size(), {0, 0, 0});
  parallel_tasks(charts.size(), [&](std::size_t c) {
    if (trees[c].leaf_count() == 0) return;
    const Component& component = mesh.components[c];
    const std::size_t begin = component.triangle_begin, triangles = component.triangle_end - begin;
    ChartWork work = {charts[c],
                      masses.subspan(begin, triangles),
                      {},
                      std::span(result.hits).subspan(begin, triangles),
                      std::span(result.sheet).subspan(begin, triangles),
                      ConflictSet(triangles)};
    work.uv_areas.resize(triangles);
    for (std::size_t t = 0; t < triangles; ++t) work.uv_areas[t] = uv_area(uv_triangle(charts[c], t));
    const ChartScene scene(device, charts[c].u, charts[c].v, charts[c].cut.triangles);
    const DepthRange depths = depth_range(component_mass(component, masses), plan, parameters.curve);
    cast_leaf_rays(work, scene, trees[c], depths, plan.leaf_mass, c, key, cancel);
    // A leaf contributes at most half of its mass to another sheet: too few leaves cannot form a separate
    // sheet.
    const bool worth_it = static_cast<double>(work.multiple_hits) * plan.leaf_mass / 2 > sheets.min_mass;
    if (worth_it && sheets.max_sheets > 1) tell_sheets_apart(work, scene, sheets, cancel);
    counts[c] = {trees[c].leaf_count(), work.rays, work.multiple_hits};
  });
  limit_hits(result.hits, most_hits(parameters, mesh.triangle_count()));
  for (const auto& [leaves, rays, multiple] : counts) {
    result.leaves += leaves;
    result.rays += rays;
    result.multiple_hits += multiple;
  }
  return result;
}

double locate_bytes(const LocateParameters& parameters, double triangles) {
  constexpr double bytes_per_scene_triangle = 150;  // Embree's buffers and tree
  constexpr double bytes_per_leaf = 64;
  const double leaves = max_leaves_per_mass(parameters.curve.kind) * parameters.curve.leaves_per_sample *
                            static_cast<double>(parameters.samples) +
                        triangles;
  return triangles * bytes_per_scene_triangle + conflict_bytes(triangles) + leaves * bytes_per_leaf;
}

}  // namespace meander
