// A wavy unit square and its chart, for the tests of point location.
#pragma once

#include <cmath>
#include <utility>

#include "kernels/core/vector3.h"

namespace meander::test {

// Height over the square.
inline double bumps(double x, double y) { return 0.2 * std::sin(7 * x) * std::cos(5 * y); }

// The square a little inside the chart's.
inline std::pair<double, double> flat(Vector3 p) { return {0.013 + 0.97 * p.x, 0.007 + 0.97 * p.y}; }

}  // namespace meander::test
