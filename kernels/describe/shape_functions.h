// The other shape functions of Osada, Funkhouser, Chazelle and Dobkin 2002 ("Shape distributions"), from the
// same samples as the distance histogram.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "kernels/core/cancel.h"
#include "kernels/core/random.h"

namespace meander {

enum class ShapeFunction : std::uint8_t {
  angle,       // A3: the angle at the first of three random points, radians
  centroid,    // D1: distance to the centroid of the points, over all points
  triangle,    // D3: square root of the area of three random points' triangle
  tetrahedron  // D4: cube root of the volume of four random points' tetrahedron
};
std::string_view name_of(ShapeFunction function);  // a3, d1, d3, d4

struct ShapeFunctionParameters {
  std::uint32_t bins = 32;         // 8..1024
  std::uint32_t tuples = 1 << 17;  // random triangles and tetrahedra, 1..2^28; not used by D1
};

struct ShapeHistogram {
  std::vector<double> shares;  // bins; sum 1
  double scale = 0;            // mean of the values (A3: radians)
  double range = 0;            // bins are equal parts of [0, range]: 3 x mean, and pi for A3
};

// The histogram of a shape function. points: 3 n coordinates, finite, n >= 4 (a row of /points). Values above
// the range count in the last bin; points that all coincide give scale 0 and everything in bin 0. Tuple t is
// four different points, a pure function of (key, t, n); A3 and D3 use its first three, so the functions
// share tuples, and a larger number of tuples begins with the smaller one. The angle at a point that
// coincides with another is 0. O(n + tuples), parallel in fixed blocks; deterministic for every thread count
// and processor. Throws std::invalid_argument for too few points, numbers that are not finite and parameters
// out of range; RunCanceled and ItemError(timeout) from `cancel`.
ShapeHistogram shape_function_histogram(std::span<const float> points, ShapeFunction function, RandomKey key,
                                        const ShapeFunctionParameters& parameters = {},
                                        const CancelToken& cancel = {});

}  // namespace meander
