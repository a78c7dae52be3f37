// Mending the few triangles that a conformal map turns over.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "kernels/flatten/intrinsic_disk.h"

namespace meander {

// Re-solves a patch of 0 .. 6 rings of vertices around every cluster of flipped triangles with mean-value
// weights, its rim fixed, and keeps the smallest patch that leaves no flip (or else the one that leaves
// fewest, when that is an improvement). Boundary vertices never move. `counts` marks triangles whose
// orientation matters; `disk` has the connectivity of the chart (not an intrinsic triangulation) and
// mollified lengths. Returns the triangles that have moved. Cost: O(T) plus the patches; clusters of more
// than 4096 flips are left alone (the chart is beyond patching).
std::uint32_t repair_flips(const IntrinsicDisk& disk, std::span<const double> angle,
                           std::span<const std::uint8_t> counts, std::span<double> u, std::span<double> v,
                           const CancelToken& cancel = {});

}  // namespace meander
