// Constants that the loops over tensors share.
#pragma once

#include <cstddef>

namespace meander {

// Triangles of one task.
inline constexpr std::size_t tensor_block = 4096;
// Rounds in which vertices without a value of their own take that of their neighbors.
inline constexpr int fill_rounds = 64;
// A tensor has no direction below this ratio of its eigenvalues.
inline constexpr double isotropic_ratio = 1.05;

}  // namespace meander
