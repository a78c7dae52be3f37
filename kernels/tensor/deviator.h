// The trace-free part of a tangent tensor as a vector, at twice the angle of the first principal direction.
#pragma once

#include <cmath>

#include "kernels/core/portable_functions.h"
#include "kernels/tensor/tensor_field.h"

namespace meander {

struct Deviator {
  double x = 0, y = 0;
};
inline Deviator deviator(TangentTensor a) { return {0.5 * (a.xx - a.yy), a.xy}; }
inline double length(Deviator d) { return portable::hypot(d.x, d.y); }

}  // namespace meander
