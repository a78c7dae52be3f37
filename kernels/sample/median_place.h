// Internal to kernels/sample: a place in the middle of many.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

#include "kernels/core/vector3.h"

namespace meander {

// The medians of the coordinates of at(i), i in [0, count), over at most 1,025 of them, evenly spread: the
// origin from which float is precise where most of them are, whatever lies apart. count >= 1.
template <class At>
Vector3 median_place(std::size_t count, const At& at) {
  constexpr std::size_t max_used = 1025;
  const std::size_t used = std::min(count, max_used);
  std::array<std::vector<double>, 3> along;
  for (std::size_t i = 0; i < used; ++i) {
    const Vector3 p = at(i * count / used);
    along[0].push_back(p.x);
    along[1].push_back(p.y);
    along[2].push_back(p.z);
  }
  for (std::vector<double>& row : along)
    std::nth_element(row.begin(), row.begin() + static_cast<std::ptrdiff_t>(used / 2), row.end());
  return {along[0][used / 2], along[1][used / 2], along[2][used / 2]};
}

}  // namespace meander
