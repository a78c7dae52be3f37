// Point location on charts with Embree: which triangles lie under the leaves of the curve, and which sheets
// overlap (docs/METHODS.md 6.2 and 6.3).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "kernels/core/cancel.h"
#include "kernels/core/random.h"
#include "kernels/curve/curve_tree.h"
#include "kernels/flatten/flatten_chart.h"
#include "kernels/mesh/prepared_mesh.h"
#include "kernels/rays/embree_device.h"

namespace meander {

struct LocateParameters {
  std::uint64_t samples = 2048;
  CurveParameters curve;
  double min_component_samples = 4;  // components that expect fewer samples get no rays
  std::uint32_t max_sheets = 16;     // 1..16
  double min_sheet_samples = 8;      // sheets of fewer expected samples are not separated
};

struct Located {
  // T: number of final leaves whose ray met the triangle; a share of it where charts cover themselves so
  // often that all together would be more than twice as many as there may be leaves.
  std::vector<std::uint32_t> hits;
  std::vector<std::uint8_t> sheet;  // T: 0..max_sheets - 1
  std::uint64_t leaves = 0, rays = 0;
  std::uint64_t multiple_hits = 0;  // leaves with more than one triangle under the ray
};

// build_curve: one tree per chart (an empty tree for charts without rays: Method::none or too few expected
// samples). masses: T triangle masses. O(T log T + L).
std::vector<CurveTree> build_curves(const PreparedMesh& mesh, std::span<const FlatChart> charts,
                                    std::span<const double> masses, const LocateParameters& parameters,
                                    const CancelToken& cancel = {});

// Rays along z through a random point of every leaf, in curve order, in coherent packets; every triangle
// under the point is recorded (a ray that meets more than 64 is on a collapsed spot and counts as a miss).
// Leaves are split, down to depth max(3, floor(log2(kappa N_c) / 2) - 1) everywhere (N_c: expected samples of
// the chart), and further while the mass estimated from their hits exceeds total / (kappa N): each triangle
// gives the leaf's share of its UV area, at most all of its mass. Where rays meet more than one triangle the
// chart overlaps itself; if there is enough of it for a sheet of min_sheet_samples, one ray through every
// centroid finds the triangles in conflict, and they are assigned to sheets by growing regions that never
// join conflicting triangles. Decisions are integers on hits sorted by triangle; ray positions are never used
// as sample positions, ray sums never as mass. Deterministic for every thread count and machine. The trees
// are refined in place. Cost: about 70 ns a triangle for the hierarchy, 100-200 ns a ray; little more than
// one ray a leaf, and one a triangle where the chart overlaps.
Located locate_with_embree(const EmbreeDevice& device, const PreparedMesh& mesh,
                           std::span<const FlatChart> charts, std::span<const double> masses,
                           std::vector<CurveTree>& trees, RandomKey key, const LocateParameters& parameters,
                           const CancelToken& cancel = {});

// Upper bound of the bytes of either locator and its curves, beside the charts.
double locate_bytes(const LocateParameters& parameters, double triangles);

}  // namespace meander
