// Mending the few triangles that a conformal map turns over.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "kernels/flatten/chart_report.h"
#include "kernels/flatten/intrinsic_disk.h"

namespace meander {

// Re-solves a patch of 0 .. 6 rings of vertices around every cluster of bad triangles (flipped, or of
// distortion above 1000) with mean-value weights, its rim fixed, and keeps the smallest patch that leaves
// nothing bad, or else the one that mends most. Boundary vertices never move. `disk` has the connectivity of
// the chart (not an intrinsic triangulation) and mollified lengths. Returns the number of triangles that have
// moved. Cost: O(T) plus the patches; more than 4096 bad triangles are left alone (the chart is beyond
// patching).
std::uint32_t repair_flips(const IntrinsicDisk& disk, std::span<const double> angle,
                           const ChartGeometry& geometry, std::span<double> u, std::span<double> v,
                           const CancelToken& cancel = {});

}  // namespace meander
