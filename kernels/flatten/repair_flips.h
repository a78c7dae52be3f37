// Repair of the few triangles that a conformal map flips.
#pragma once

#include <cstdint>
#include <span>

#include "kernels/core/work_budget.h"
#include "kernels/flatten/chart_report.h"
#include "kernels/solve/intrinsic_disk.h"

namespace meander {

// Re-solves a patch of 0 .. 6 rings of vertices around every cluster of bad triangles (see MapScan) with
// mean-value weights and a fixed rim. Keeps the smallest patch without a bad triangle, or else the one that
// repairs the most. Boundary vertices never move. `disk` has the connectivity of the chart (not an intrinsic
// triangulation) and mollified lengths. Returns the number of triangles that have moved.
//
// Cost: O(T) plus the patches; more than 4096 bad triangles are not repaired, because the chart as a whole is
// unusable. A cluster that cannot be repaired is tried again from each of its triangles, quadratic in its
// size: every patch takes its work out of `budget`, and the first one that is refused ends the repair with
// the triangles repaired so far.
std::uint32_t repair_flips(const IntrinsicDisk& disk, const ChartGeometry& geometry,
                           std::span<const std::uint32_t> bad, std::span<double> u, std::span<double> v,
                           const CancelToken& cancel = {}, WorkBudget* budget = nullptr);

}  // namespace meander
