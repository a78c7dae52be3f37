// Flattening a disk into the unit square (docs/METHODS.md 4).
#pragma once

#include <cstdint>
#include <vector>

#include "kernels/core/cancel.h"
#include "kernels/core/status.h"
#include "kernels/core/work_budget.h"
#include "kernels/cut/cut_to_disk.h"
#include "kernels/mesh/measured_mesh.h"

namespace meander {

struct FlattenParameters {
  std::uint32_t max_extra_seams = 12;  // seams added where the chart shrinks too far; 0..64
  double min_log_scale = -9.0;         // log scale factor below which a chart counts as shrunk too far
  // Share of triangles that may stay flipped before bad ones are repaired or the chart falls back to
  // mean-value coordinates on a circle; 0..1.
  double max_flipped_share = 0;
  double max_mean_distortion = 1.1;  // area-weighted mean sigma1/sigma2 above which another seam is tried
  double effort = 1;                 // multiple of the work that a chart may take: flatten_budget; 0..1e6
};

// The work that a chart of this number of triangles may take: `effort` times that of 64 maps of its size,
// whose factorization grows like T^1.5. Counted, so that it is the same on every machine.
WorkBudget flatten_budget(std::size_t triangles, double effort);

// Quality of the map, measured against MeasuredMesh::length (in space, unless a metric is given); weights are
// areas, triangles without area do not count.
struct ChartReport {
  Method method = Method::none;                // conformal or mean_value; none when nothing worked
  OrderReason reason = OrderReason::as_asked;  // why the map is not conformal
  std::uint32_t triangles = 0;
  std::uint32_t flips = 0;  // triangles with area whose UV orientation is not positive (exact sign)
  double overlap = 0;       // share of the covered UV area that is covered more than once, in [0, 1]
  // Largest over smallest ratio of UV area to 3-D area; quantiles of 1 % and 99 % are not cut off.
  double area_scale_range = 1;
  double mean_distortion = 1;  // area-weighted mean of sigma1/sigma2, >= 1
  double max_distortion = 1;
  double min_uv_edge = 0;                // shortest UV edge
  std::uint32_t extra_seams = 0;         // seams that were added after the first attempt
  std::uint32_t repaired_triangles = 0;  // triangles of re-solved mean-value patches
  double area = 0;                       // of the chart, working units squared
};

// UV of every chart vertex, in [0, 1]^2: uniformly scaled, rotated to the minimum-area rectangle, never
// stretched.
struct FlatChart {
  CutChart cut;
  std::vector<double> u, v;
  ChartReport report;
};

// Flattens a disk, boundary first with zero boundary scale (Sawhney and Crane 2017): cotangent weights first,
// the intrinsic Delaunay triangulation on failure, mean-value patches (Floater 2003) around flips, one more
// seam and another try when the chart shrinks too far, and mean-value coordinates on a circle as the
// fallback. Never aborts: a chart that cannot be flattened is returned with Method::none (the caller falls
// back to the direct method), and so is one that reaches flatten_budget before any map is good enough; a good
// map found by then is kept. The method is `conformal` only without flips, or within max_flipped_share. Cost:
// one n x n sparse Cholesky factorization for each try, at most flatten_budget in all. Deterministic; throws
// timeout / RunCanceled from `cancel`.
FlatChart flatten_chart(const MeasuredMesh& surface, CutChart cut, const FlattenParameters& parameters,
                        const CancelToken& cancel = {});

// Upper bound of the bytes of flat charts: cut, UV, distances.
constexpr double chart_bytes(double triangles) {
  constexpr double bytes_per_triangle = 180;
  return triangles * bytes_per_triangle;
}
// The same while they are looked for, with the factor: the best cut with its map, the next cut with its
// triangulation; the factor, or both of an LU, and the stack of updates.
double flatten_bytes(double triangles, double unknowns);

}  // namespace meander
