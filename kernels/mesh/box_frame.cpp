#include "kernels/mesh/box_frame.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "kernels/core/status.h"

namespace meander {

BoxFrame box_frame(const std::array<double, 6>& box) {
  BoxFrame frame;
  const auto side = [&](std::size_t axis) { return box[axis + 3] - box[axis]; };
  const double longest = std::max({side(0), side(1), side(2)});
  if (!(longest > 0)) throw ItemError(Status::zero_area, "all vertices of the faces lie at one point");
  const auto too_large = [] {
    return ItemError(
        Status::non_finite,
        "too large: the bounding box spans more than double precision holds; scale the file down");
  };
  if (!std::isfinite(longest)) throw too_large();
  const auto middle = [&](std::size_t axis) { return 0.5 * box[axis] + 0.5 * box[axis + 3]; };
  frame.center = {middle(0), middle(1), middle(2)};
  int exponent = 0;
  std::frexp(longest, &exponent);  // longest < 2^exponent
  frame.unit = std::ldexp(1.0, exponent - 1);
  const double dx = side(0) / frame.unit, dy = side(1) / frame.unit, dz = side(2) / frame.unit;
  frame.diagonal = std::sqrt(dx * dx + dy * dy + dz * dz) * frame.unit;
  if (!std::isfinite(frame.diagonal)) throw too_large();
  return frame;
}

}  // namespace meander
