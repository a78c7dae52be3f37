// Values that are no finite numbers.
#pragma once

#include <limits>

namespace meander::test {

inline constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();
inline constexpr double infinity = std::numeric_limits<double>::infinity();

}  // namespace meander::test
