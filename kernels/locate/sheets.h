// Separating the sheets of an overlapping chart.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace meander {

// Two triangles of a chart that cover one point, the smaller number first.
struct Conflict {
  std::uint32_t first, second;
};

struct SheetParameters {
  std::uint32_t max_sheets = 16;  // 1..16
  double min_mass = 0;            // regions of at most this mass stay in sheet 0
};

// Sheet number (0 .. max_sheets - 1) of every triangle, so that conflicting triangles lie in different sheets
// wherever possible, except in regions of at most min_mass.
//   opposite: 3 T half-edges of the chart; mass: T; conflicts: in any order, repeats allowed.
// Connected regions are grown breadth first, from the lowest triangle that has none, without ever joining two
// conflicting triangles; triangles without any conflict and those with one never share a region, so that a
// part of the chart that overlaps is moved to another sheet as a whole and nothing else is. Then the regions,
// the heaviest first, take the lowest sheet in which they conflict with nothing. Regions that are too light,
// or find no sheet, stay in sheet 0. O(T + C log C). Deterministic.
std::vector<std::uint8_t> separate_sheets(std::span<const std::uint32_t> opposite,
                                          std::span<const double> mass, std::vector<Conflict> conflicts,
                                          const SheetParameters& parameters);

}  // namespace meander
