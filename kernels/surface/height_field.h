// A surface over a grid of heights, such as a grayscale picture.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "kernels/surface/surface.h"

namespace meander {

// bilinear: continuous; the slope jumps across grid lines, duu = dvv = 0. bicubic: Catmull and Rom's cardinal
// spline (1974), passes through all heights, once continuously differentiable; second derivatives jump across
// grid lines. Heights are extrapolated linearly beyond the border, so that planes are reproduced up to it.
enum class HeightInterpolation : std::uint8_t { bilinear, bicubic };

struct HeightFieldParameters {
  HeightInterpolation interpolation = HeightInterpolation::bicubic;
  double extent_x = 1, extent_y = 1;  // x = extent_x u, y = extent_y v; > 0
  double scale = 1;                   // z = scale x height
};

// heights: width x height values, row by row; row 0 lies at v = 0, column 0 at u = 0, the last ones at 1. The
// values are copied. Throws ItemError: unreadable (the sizes do not fit, fewer than 2 x 2, a bad parameter),
// non_finite (a height).
std::unique_ptr<ParametricSurface> make_height_field(std::span<const float> heights, std::size_t width,
                                                     std::size_t height,
                                                     const HeightFieldParameters& parameters = {});

}  // namespace meander
