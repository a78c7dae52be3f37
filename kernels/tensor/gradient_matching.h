// Flattening a chart so that u and v count sample spacings along and across a field's primary direction
// (docs/METHODS.md 9.7).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "kernels/flatten/flatten_chart.h"
#include "kernels/solve/intrinsic_disk.h"
#include "kernels/tensor/chart_alignment.h"
#include "kernels/tensor/comb_directions.h"

namespace meander {

// The steps that u and v should take along every half-edge, 3 T each: e1 . edge / s1 and e2 . edge / s2 of
// the triangle of the half-edge (the two sides of an edge may differ).
struct TargetSteps {
  std::vector<double> along, across;
};
TargetSteps target_steps(const UnfoldedTriangles& unfolded, const CombedDirections& directions);

struct GradientMatch {
  bool finite = false;       // false: the solver failed, or the budget did not suffice
  std::vector<double> u, v;  // V, in spacings; vertex 0 at the origin
  double residual = 0;       // sqrt(energy of the solution / energy of a constant map); 0 = matched, <= 1
};
// Minimizes the sum over half-edges of w_h ((u_j - u_i - along_h)^2 + (v_j - v_i - across_h)^2). With w =
// half cotangents that is sum_t A_t (|grad u - e1 / s1|^2 + |grad v - e2 / s2|^2): two Poisson problems with
// one sparse Cholesky factorization, vertex 0 pinned (the solution does not depend on which). O(V^1.5), out
// of `budget` where there is one.
GradientMatch match_gradients(const IntrinsicDisk& disk, std::span<const double> weights,
                              const TargetSteps& steps, const CancelToken& cancel = {},
                              WorkBudget* budget = nullptr);

struct FieldFlattenParameters {
  CombParameters comb;
  double effort = 1;  // multiple of the work that the chart may take: flatten_budget; > 0
};

// The weights that a map was computed with.
enum class FieldMapSource : std::uint8_t { space_weights, metric_weights };

struct FieldChart {
  // UV in the unit square as from fit_square(), but not rotated: u runs along e1. report.method is
  // anisotropic when nothing is flipped and no vertex is wound around more than once, otherwise none (u and v
  // are set in both cases); its distortions are relative to space.
  FlatChart flat;
  double spacing = 0;   // length of one spacing in UV
  double residual = 0;  // see GradientMatch
  FieldMapSource source = FieldMapSource::space_weights;
  std::uint32_t inconsistent_edges = 0, odd_vertices = 0;  // see CombedDirections
  AlignmentReport alignment;
};

// Combs the field and matches gradients. Where that flips a few triangles (2 %), patches around them are
// re-solved with mean-value weights in the field's metric. If flips stay, the whole chart is solved again
// with the cotangents of the metric (errors count in spacings, not in space) and repaired in the same way;
// the map with fewer flips is kept. Never aborts: a chart that comes back with Method::none, as one may that
// reaches the bound on its work, is to be divided, or flattened by form B. Throws timeout / RunCanceled from
// `cancel`.
FieldChart flatten_to_field(const PreparedMesh& mesh, CutChart cut, const TensorField& field,
                            const FieldFlattenParameters& parameters = {}, const CancelToken& cancel = {});

}  // namespace meander
