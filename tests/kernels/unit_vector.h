// The unit vector of a direction.
#pragma once

#include "kernels/core/vector3.h"

namespace meander::test {

inline Vector3 unit(Vector3 v) { return (1 / norm(v)) * v; }

}  // namespace meander::test
