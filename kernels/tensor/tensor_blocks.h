// Constants that the loops over tensors share.
#pragma once

#include <cstddef>

namespace meander {

// Triangles of one task.
inline constexpr std::size_t tensor_block = 4096;
// A tensor has no direction below this ratio of its eigenvalues.
inline constexpr double isotropic_ratio = 1.05;

}  // namespace meander
