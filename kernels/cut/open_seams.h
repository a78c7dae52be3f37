// Opens edges of a chart: removes opposite links and gives vertices on the seams one copy a fan.
#pragma once

#include <cstdint>
#include <span>

#include "kernels/cut/cut_to_disk.h"

namespace meander {

// Opens the given interior half-edges (either one of each pair). Existing boundary fans keep their vertex
// numbers; further fans get new numbers at the end, in the order of `half_edges`. O(half_edges x valence)
// plus one pass over the vertices.
void open_seams(CutChart& chart, std::span<const std::uint32_t> half_edges);

// Throws ItemError(internal) unless the chart is one connected disk: V - E + F = 1, one boundary loop of at
// least three edges that meets no vertex twice. O(T).
void require_disk(const CutChart& chart);

}  // namespace meander
