// Placement of a flat chart in the unit square.
#pragma once

#include <span>

namespace meander {

// Rotates the points so that their minimum-area bounding rectangle is axis-parallel, longer side along u,
// scales them uniformly and centers them in [0, 1]^2 with a margin of 2^-12 on every side of the longer
// extent. Never mirrors or stretches the chart. The values must be finite; points that all coincide go to the
// center. O(n log n). Returns the scale factor.
double fit_square(std::span<double> u, std::span<double> v);

}  // namespace meander
