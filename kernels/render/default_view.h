// The view of a model that no option chooses.
#pragma once

#include "kernels/core/vector3.h"

namespace meander {

// From the model towards the eye, where y points up: in front, to the right and above.
inline constexpr Vector3 default_view{0.55, 0.42, 1};

// The same for the axis x, y or z that points up.
constexpr Vector3 default_view_of(char up) {
  const auto [right, above, front] = default_view;
  if (up == 'x') return {above, right, front};
  return up == 'z' ? Vector3{right, -front, above} : default_view;
}

}  // namespace meander
