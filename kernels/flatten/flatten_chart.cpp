#include "kernels/flatten/flatten_chart.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "kernels/flatten/boundary_first.h"
#include "kernels/flatten/chart_report.h"
#include "kernels/flatten/fit_square.h"
#include "kernels/flatten/intrinsic_delaunay.h"
#include "kernels/flatten/mean_value.h"
#include "kernels/flatten/repair_flips.h"

namespace meander {

namespace {

constexpr std::uint32_t seams_per_try = 4;  // protrusions that get a seam in one attempt
constexpr std::uint32_t patience =
    2;  // attempts with too little progress in distortion before the search ends

// A cut chart with its geometry, shared by all attempts on this cut.
struct CutDisk {
  CutChart cut;
  ChartGeometry geometry;
  IntrinsicDisk disk;  // mollified
  // In a metric most triangulations are far from Delaunay, so the intrinsic Delaunay triangulation is used
  // from the first attempt on.
  std::optional<IntrinsicDisk> delaunay;

  const IntrinsicDisk& solved() const { return delaunay ? *delaunay : disk; }

  CutDisk(const PreparedMesh& mesh, CutChart chart, const CancelToken& cancel) : cut(std::move(chart)) {
    geometry = chart_geometry(mesh, cut);
    disk.triangles = cut.triangles;
    disk.opposite = cut.opposite;
    disk.length = geometry.length;
    disk.vertex_count = static_cast<std::uint32_t>(cut.vertex_count());
    mollify(disk.length);
    if (mesh.metric_length.empty()) return;
    delaunay = disk;
    make_intrinsic_delaunay(*delaunay, cancel);
  }
};

struct Try {
  bool finite = false;
  std::vector<double> u, v;  // in the unit square
  std::vector<double> log_scale;
  std::vector<std::uint32_t> elimination;
  double least_log_scale = 0;
  MapScan scan;
  std::uint32_t repaired = 0;
  bool sound = false;  // no flips, no branch points
};

Try try_conformal(const CutDisk& chart, const IntrinsicDisk& disk, const CancelToken& cancel) {
  Try attempt;
  ConformalMap map = flatten_boundary_first(disk, cancel);
  attempt.log_scale = std::move(map.log_scale);
  attempt.elimination = std::move(map.elimination);
  attempt.finite = map.finite;
  if (!map.finite) return attempt;
  attempt.u = std::move(map.u);
  attempt.v = std::move(map.v);
  fit_square(attempt.u, attempt.v);
  for (const double s : attempt.log_scale) attempt.least_log_scale = std::min(attempt.least_log_scale, s);
  attempt.scan = scan_map(chart.geometry, chart.cut.triangles, attempt.u, attempt.v);
  return attempt;
}

void judge(const CutDisk& chart, Try& attempt) {
  attempt.sound = attempt.scan.flips == 0 && branch_points(chart.cut, attempt.u, attempt.v) == 0;
}

// Repairs flips in place and decides whether the map is sound.
void mend(const CutDisk& chart, Try& attempt, const CancelToken& cancel) {
  if (!attempt.finite) return;
  if (!attempt.scan.bad.empty()) {
    attempt.repaired =
        repair_flips(chart.disk, chart.geometry, attempt.scan.bad, attempt.u, attempt.v, cancel);
    attempt.scan = scan_map(chart.geometry, chart.cut.triangles, attempt.u, attempt.v);
  }
  judge(chart, attempt);
}

// The tip of every connected region below the threshold, smallest scale first: one per protrusion.
std::vector<std::uint32_t> shrunken_tips(const CutChart& cut, std::span<const double> log_scale,
                                         double threshold) {
  std::vector<std::vector<std::uint32_t>> neighbours;
  std::vector<std::uint32_t> region(cut.vertex_count(), no_index), number(cut.vertex_count(), no_index), low;
  for (std::uint32_t w = 0; w < log_scale.size(); ++w)
    if (log_scale[w] < threshold) {
      number[w] = static_cast<std::uint32_t>(low.size());
      low.push_back(w);
    }
  neighbours.resize(low.size());
  for (std::uint32_t h = 0; h < cut.triangles.size(); ++h) {
    const std::uint32_t a = number[cut.triangles[h]], b = number[cut.triangles[next_half_edge(h)]];
    if (a != no_index && b != no_index) neighbours[a].push_back(b);
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
      for (const std::uint32_t j : neighbours[i]) {
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

// Adds seams for the next attempt; 0 when there is nowhere left to cut.
std::uint32_t add_seams(const PreparedMesh& mesh, CutChart& cut, const Try& attempt,
                        const FlattenParameters& parameters, std::uint32_t most, const CancelToken& cancel) {
  std::vector<std::uint32_t> tips;
  if (attempt.least_log_scale < parameters.min_log_scale) {
    tips = shrunken_tips(cut, attempt.log_scale, parameters.min_log_scale);
  } else {
    const auto at = std::min_element(attempt.log_scale.begin(), attempt.log_scale.end());
    if (*at < 0) tips.push_back(static_cast<std::uint32_t>(at - attempt.log_scale.begin()));
  }
  std::uint32_t added = 0;
  for (const std::uint32_t tip : tips) {
    if (added >= std::min(most, seams_per_try)) break;
    if (add_seam(mesh, cut, tip, cancel)) ++added;
  }
  return added;
}

bool shrunk(const Try& attempt, const FlattenParameters& parameters) {
  return attempt.least_log_scale < parameters.min_log_scale;
}

bool better(const Try& a, const Try& b, const FlattenParameters& parameters) {
  if (shrunk(b, parameters)) return a.least_log_scale > b.least_log_scale;
  return !shrunk(a, parameters) && a.scan.capped_distortion < b.scan.capped_distortion;
}

// Conformal attempts on charts with more and more seams; `chart` and `best` become the best of them. Returns
// the number of seams that were added to it.
std::uint32_t add_seams_while_they_help(const PreparedMesh& mesh, const FlattenParameters& parameters,
                                        const CancelToken& cancel, CutDisk& chart, Try& best) {
  CutChart cut = chart.cut;
  Try last = best;
  std::uint32_t extra = 0, best_extra = 0, waited = 0;
  while (last.finite && extra < parameters.max_extra_seams) {
    const bool too_small = shrunk(last, parameters);
    if (!too_small && !(last.scan.capped_distortion > parameters.max_mean_distortion)) break;
    const std::uint32_t added =
        add_seams(mesh, cut, last, parameters, parameters.max_extra_seams - extra, cancel);
    if (added == 0) break;
    extra += added;
    CutDisk next(mesh, cut, cancel);
    IntrinsicDisk& solved = next.delaunay ? *next.delaunay : next.disk;
    solved.elimination = chart.solved().elimination;  // more seams, fewer interior vertices
    Try attempt = try_conformal(next, solved, cancel);
    if (!attempt.finite) break;
    // Seams that bring less than half of their share of the improvement needed are counted; after two the
    // search ends.
    const double wanted = (last.scan.capped_distortion - parameters.max_mean_distortion) /
                          static_cast<double>(parameters.max_extra_seams - extra + 1);
    const bool enough = last.scan.capped_distortion - attempt.scan.capped_distortion >= 0.5 * wanted;
    if (better(attempt, best, parameters)) {
      best = attempt;
      best_extra = extra;
      chart = std::move(next);
    }
    if (!too_small && !enough && ++waited >= patience) break;
    last = std::move(attempt);
  }
  return best_extra;
}

}  // namespace

FlatChart flatten_chart(const PreparedMesh& mesh, CutChart cut, const FlattenParameters& parameters,
                        const CancelToken& cancel) {
  CutDisk chart(mesh, std::move(cut), cancel);
  Try best = try_conformal(chart, chart.solved(), cancel);
  (chart.delaunay ? *chart.delaunay : chart.disk).elimination = best.elimination;
  const std::uint32_t extra = add_seams_while_they_help(mesh, parameters, cancel, chart, best);
  Method method = Method::conformal;
  mend(chart, best, cancel);
  if (!best.sound && !chart.delaunay) {
    IntrinsicDisk delaunay = chart.disk;
    make_intrinsic_delaunay(delaunay, cancel);
    Try second = try_conformal(chart, delaunay, cancel);
    mend(chart, second, cancel);
    if (second.sound) best = std::move(second);
  }
  const double flips_allowed = parameters.max_flipped_share * static_cast<double>(chart.cut.triangle_count());
  const bool tolerable = best.finite && flips_allowed > 0 && best.scan.flips <= flips_allowed;
  if (!best.sound && !tolerable) {
    Try circle;
    circle.finite = flatten_to_circle(chart.disk, circle.u, circle.v);
    cancel.check();
    if (circle.finite) {
      fit_square(circle.u, circle.v);
      circle.scan = scan_map(chart.geometry, chart.cut.triangles, circle.u, circle.v);
      judge(chart, circle);
    }
    method = circle.sound ? Method::mean_value : Method::none;
    if (circle.finite) best = std::move(circle);
  }
  FlatChart flat;
  flat.report.method = method;
  flat.report.extra_seams = extra;
  flat.report.repaired_triangles = best.repaired;
  flat.u = std::move(best.u);
  flat.v = std::move(best.v);
  if (best.finite) fill_report(chart.geometry, best.scan, chart.cut, flat.u, flat.v, flat.report);
  flat.cut = std::move(chart.cut);
  return flat;
}

}  // namespace meander
