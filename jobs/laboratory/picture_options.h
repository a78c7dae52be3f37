// Options that the pictures of models share.
#pragma once

#include <string>

#include "kernels/core/vector3.h"

namespace meander {

// "x,y,z": three numbers that are not all 0, scaled to a largest of 1. Throws UsageError, which names
// `option`.
Vector3 parse_direction(const std::string& option, const std::string& text);

// The unit vector of the axis "x", "y" or "z".
Vector3 axis_of(const std::string& name);

// The direction towards the eye: that of the text, or without one from the front, the right and above of a
// model whose axis `up` points up. Throws UsageError where it lies along that axis.
Vector3 view_of(const std::string& text, const std::string& up);

}  // namespace meander
