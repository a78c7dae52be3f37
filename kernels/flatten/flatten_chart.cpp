#include "kernels/flatten/flatten_chart.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "kernels/flatten/boundary_first.h"
#include "kernels/flatten/chart_report.h"
#include "kernels/flatten/fit_square.h"
#include "kernels/flatten/mean_value.h"
#include "kernels/flatten/repair_flips.h"
#include "kernels/solve/intrinsic_delaunay.h"
#include "kernels/solve/sparse_cholesky.h"

namespace meander {

namespace {

constexpr std::uint32_t seams_per_try = 4;  // protrusions that get a seam in one attempt
constexpr std::uint32_t patience = 2;       // attempts with too little progress before the search ends

// Units of WorkBudget for a triangle of a map: angles, weights and distortion, cut and opened edges.
constexpr std::uint64_t work_per_triangle = 512;
// A map of T triangles takes about T (linear_work + planar_work sqrt(T)), where the second term is the factor
// of a planar graph. A chart with all its seams takes 17 maps and their repairs.
constexpr double linear_work = 1024, planar_work = 2, maps_per_chart = 64;

// The chart as the solvers need it, mollified.
IntrinsicDisk intrinsic_disk(const MeasuredMesh& surface, const CutChart& cut) {
  IntrinsicDisk disk;
  disk.triangles = cut.triangles;
  disk.opposite = cut.opposite;
  disk.length = chart_edge_lengths(surface, cut);
  disk.vertex_count = static_cast<std::uint32_t>(cut.vertex_count());
  mollify(disk.length);
  return disk;
}

struct Try {
  bool finite = false;
  std::vector<double> u, v;  // in the unit square
  std::vector<double> log_scale;
  std::vector<std::uint32_t> elimination;
  double min_log_scale = 0;
  MapScan scan;
  std::uint32_t repaired = 0;
};

// The number of flips is bounded in itself, so their work is taken afterwards.
void make_delaunay(IntrinsicDisk& disk, WorkBudget& budget, const CancelToken& cancel) {
  budget.spend(work_per_triangle * std::uint64_t{make_intrinsic_delaunay(disk, cancel)});
}

// Flattens `disk`, a triangulation of the chart, boundary first. The disk is freed before the map is scanned:
// memory limits how many models can be worked on at once.
Try try_conformal(const MeasuredMesh& surface, const CutChart& cut, IntrinsicDisk disk, WorkBudget& budget,
                  const CancelToken& cancel) {
  Try attempt;
  if (!budget.spend(work_per_triangle * cut.triangle_count())) return attempt;
  ConformalMap map = flatten_boundary_first(disk, cancel, &budget);
  disk = {};
  attempt.log_scale = std::move(map.log_scale);
  attempt.elimination = std::move(map.elimination);
  attempt.finite = map.finite;
  if (!map.finite) return attempt;
  attempt.u = std::move(map.u);
  attempt.v = std::move(map.v);
  fit_square(attempt.u, attempt.v);
  for (const double s : attempt.log_scale) attempt.min_log_scale = std::min(attempt.min_log_scale, s);
  attempt.scan = scan_map(chart_geometry(surface, cut), cut.triangles, attempt.u, attempt.v);
  return attempt;
}

// Makes the first attempt on a cut. In a metric most triangulations are far from Delaunay, so the intrinsic
// Delaunay triangulation is used at once.
Try try_cut(const MeasuredMesh& surface, const CutChart& cut, std::span<const std::uint32_t> elimination,
            WorkBudget& budget, const CancelToken& cancel) {
  IntrinsicDisk disk = intrinsic_disk(surface, cut);
  if (!surface.in_space()) make_delaunay(disk, budget, cancel);
  disk.elimination.assign(elimination.begin(), elimination.end());
  return try_conformal(surface, cut, std::move(disk), budget, cancel);
}

bool is_sound(const CutChart& cut, const Try& attempt) {
  return attempt.finite && attempt.scan.flips == 0 && branch_points(cut, attempt.u, attempt.v) == 0;
}

// The tip of every connected region below the threshold, smallest scale first: one for each protrusion.
std::vector<std::uint32_t> shrunken_tips(const CutChart& cut, std::span<const double> log_scale,
                                         double threshold) {
  std::vector<std::vector<std::uint32_t>> neighbors;
  std::vector<std::uint32_t> region(cut.vertex_count(), no_index), number(cut.vertex_count(), no_index), low;
  for (std::uint32_t w = 0; w < log_scale.size(); ++w)
    if (log_scale[w] < threshold) {
      number[w] = static_cast<std::uint32_t>(low.size());
      low.push_back(w);
    }
  neighbors.resize(low.size());
  for (std::uint32_t h = 0; h < cut.triangles.size(); ++h) {
    const std::uint32_t a = number[cut.triangles[h]], b = number[cut.triangles[next_half_edge(h)]];
    if (a != no_index && b != no_index) neighbors[a].push_back(b);
  }
  std::vector<std::uint32_t> tips, stack;
  std::vector<std::uint8_t> seen(low.size(), 0);
  for (std::uint32_t start = 0; start < low.size(); ++start) {
    if (seen[start]) continue;
    std::uint32_t tip = start;
    seen[start] = 1;
    stack.assign(1, start);
    while (!stack.empty()) {
      const std::uint32_t i = stack.back();
      stack.pop_back();
      if (log_scale[low[i]] < log_scale[low[tip]]) tip = i;
      for (const std::uint32_t j : neighbors[i]) {
        if (seen[j]) continue;
        seen[j] = 1;
        stack.push_back(j);
      }
    }
    tips.push_back(low[tip]);
  }
  std::sort(tips.begin(), tips.end(), [&](std::uint32_t a, std::uint32_t b) {
    return log_scale[a] < log_scale[b] || (log_scale[a] == log_scale[b] && a < b);
  });
  return tips;
}

// Adds up to max_seams for the next attempt and returns their number, 0 when there is nowhere left to cut.
std::uint32_t add_seams(const MeasuredMesh& surface, CutChart& cut, const Try& attempt,
                        const FlattenParameters& parameters, std::uint32_t max_seams,
                        const CancelToken& cancel) {
  std::vector<std::uint32_t> tips;
  if (attempt.min_log_scale < parameters.min_log_scale) {
    tips = shrunken_tips(cut, attempt.log_scale, parameters.min_log_scale);
  } else {
    const auto at = std::min_element(attempt.log_scale.begin(), attempt.log_scale.end());
    if (*at < 0) tips.push_back(static_cast<std::uint32_t>(at - attempt.log_scale.begin()));
  }
  std::uint32_t added = 0;
  for (const std::uint32_t tip : tips) {
    if (added >= std::min(max_seams, seams_per_try)) break;
    if (add_seam(surface, cut, tip, cancel)) ++added;
  }
  return added;
}

bool shrunk(const Try& attempt, const FlattenParameters& parameters) {
  return attempt.min_log_scale < parameters.min_log_scale;
}

bool better(const Try& a, const Try& b, const FlattenParameters& parameters) {
  if (shrunk(b, parameters)) return a.min_log_scale > b.min_log_scale;
  return !shrunk(a, parameters) && a.scan.capped_distortion < b.scan.capped_distortion;
}

// A map on its own cut.
struct MappedCut {
  CutChart cut;
  Try map;
  std::uint32_t extra_seams = 0;
};

// Makes conformal attempts on cuts with more and more seams, as long as they help; returns the best.
MappedCut best_conformal(const MeasuredMesh& surface, CutChart cut, const FlattenParameters& parameters,
                         WorkBudget& budget, const CancelToken& cancel) {
  Try last = try_cut(surface, cut, {}, budget, cancel);
  // Seams only take vertices out of the interior, so one order of elimination serves all attempts.
  const std::vector<std::uint32_t> elimination = std::move(last.elimination);
  MappedCut best{cut, last, 0};
  std::uint32_t extra = 0, waited = 0;
  while (last.finite && extra < parameters.max_extra_seams) {
    const bool too_small = shrunk(last, parameters);
    if (!too_small && !(last.scan.capped_distortion > parameters.max_mean_distortion)) break;
    const std::uint32_t added =
        add_seams(surface, cut, last, parameters, parameters.max_extra_seams - extra, cancel);
    if (added == 0) break;
    extra += added;
    last.u = last.v = std::vector<double>();
    Try attempt = try_cut(surface, cut, elimination, budget, cancel);
    if (!attempt.finite) break;
    // Attempts that bring less than half of their share of the improvement needed are counted; after two the
    // search ends.
    const double wanted = (last.scan.capped_distortion - parameters.max_mean_distortion) /
                          static_cast<double>(parameters.max_extra_seams - extra + 1);
    const bool enough = last.scan.capped_distortion - attempt.scan.capped_distortion >= 0.5 * wanted;
    if (better(attempt, best.map, parameters)) best = {cut, attempt, extra};
    if (!too_small && !enough && ++waited >= patience) break;
    last = std::move(attempt);
  }
  return best;
}

// The defect of a map that is not sound.
OrderReason fault_of(const Try& attempt) {
  if (!attempt.finite) return OrderReason::not_finite;
  return attempt.scan.flips > 0 ? OrderReason::flipped : OrderReason::winding;
}

// Whether the share of bad triangles, by number and by area, is within the limit. Maps with collapsed
// triangles, which raise the distortion of the whole map, are not tolerable.
bool is_tolerable(const Try& attempt, const ChartGeometry& geometry, double share) {
  constexpr double largest_part = 1.01;
  if (!attempt.finite || !(share > 0)) return false;
  if (attempt.scan.mean_distortion > largest_part * attempt.scan.capped_distortion) return false;
  const auto allowed = share * static_cast<double>(geometry.counts.size());
  double area = 0;
  for (const std::uint32_t t : attempt.scan.bad) area += geometry.area[t];
  return static_cast<double>(attempt.scan.bad.size()) <= allowed && area <= share * geometry.total_area;
}

struct MapKind {
  Method method = Method::conformal;
  OrderReason reason = OrderReason::as_asked;
};

// Repairs a map with bad triangles in place; when that is not enough tries the intrinsic Delaunay
// triangulation, and last the mean-value map to the circle. `best` becomes the best of them.
MapKind repair_map(const MeasuredMesh& surface, const CutChart& cut, const ChartGeometry& geometry,
                   const FlattenParameters& parameters, Try& best, WorkBudget& budget,
                   const CancelToken& cancel) {
  if (is_tolerable(best, geometry, parameters.max_flipped_share)) return {};
  const IntrinsicDisk disk = intrinsic_disk(surface, cut);
  const auto repair = [&](Try& attempt) {
    if (attempt.finite && !attempt.scan.bad.empty()) {
      attempt.repaired =
          repair_flips(disk, geometry, attempt.scan.bad, attempt.u, attempt.v, cancel, &budget);
      attempt.scan = scan_map(geometry, cut.triangles, attempt.u, attempt.v);
    }
    return is_sound(cut, attempt);
  };
  if (repair(best)) return {};
  if (surface.in_space() && !budget.exhausted()) {
    IntrinsicDisk delaunay = disk;
    make_delaunay(delaunay, budget, cancel);
    Try second = try_conformal(surface, cut, std::move(delaunay), budget, cancel);
    if (repair(second)) {
      best = std::move(second);
      return {};
    }
  }
  const double flips_allowed = parameters.max_flipped_share * static_cast<double>(cut.triangle_count());
  if (best.finite && flips_allowed > 0 && best.scan.flips <= flips_allowed) return {};
  const OrderReason reason = budget.exhausted() ? OrderReason::work_limit : fault_of(best);
  const MapKind nothing{Method::none, reason}, no_work{Method::none, OrderReason::work_limit};
  if (!budget.spend(work_per_triangle * cut.triangle_count())) return no_work;
  Try circle;
  circle.finite = flatten_to_circle(disk, circle.u, circle.v, cancel, &budget);
  cancel.check();
  if (!circle.finite) return budget.exhausted() ? no_work : nothing;
  fit_square(circle.u, circle.v);
  circle.scan = scan_map(geometry, cut.triangles, circle.u, circle.v);
  best = std::move(circle);
  return is_sound(cut, best) ? MapKind{Method::mean_value, reason} : nothing;
}

}  // namespace

WorkBudget flatten_budget(std::size_t triangles, double effort) {
  const auto count = static_cast<double>(triangles);
  const double units = effort * maps_per_chart * count * (linear_work + planar_work * std::sqrt(count));
  return WorkBudget(static_cast<std::uint64_t>(std::min(units, 0x1p63)));
}

FlatChart flatten_chart(const MeasuredMesh& surface, CutChart chart, const FlattenParameters& parameters,
                        const CancelToken& cancel) {
  WorkBudget budget = flatten_budget(chart.triangle_count(), parameters.effort);
  MappedCut found = best_conformal(surface, std::move(chart), parameters, budget, cancel);
  CutChart& cut = found.cut;
  Try& best = found.map;
  const ChartGeometry geometry = chart_geometry(surface, cut);
  FlatChart flat;
  MapKind kind;
  if (!best.scan.bad.empty() || !is_sound(cut, best))
    kind = repair_map(surface, cut, geometry, parameters, best, budget, cancel);
  flat.report.method = kind.method;
  flat.report.reason = kind.reason;
  flat.report.extra_seams = found.extra_seams;
  flat.report.repaired_triangles = best.repaired;
  flat.u = std::move(best.u);
  flat.v = std::move(best.v);
  if (best.finite) fill_report(geometry, best.scan, cut, flat.u, flat.v, flat.report);
  flat.cut = std::move(cut);
  return flat;
}

double flatten_bytes(double triangles, double unknowns) {
  constexpr double bytes_per_triangle = 300, bytes_per_entry = 13;
  return triangles * bytes_per_triangle + most_factor_entries(unknowns) * bytes_per_entry;
}

}  // namespace meander
