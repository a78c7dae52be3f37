#include "kernels/mesh/polygon_corners.h"

#include <algorithm>

namespace meander {

namespace {

// Searching more corners one by one would cost more than sorting them.
constexpr std::size_t max_searched_corners = 32;

}  // namespace

std::uint32_t PolygonCorners::find(std::uint32_t face, std::uint32_t vertex) {
  const std::uint32_t begin = mesh_.polygon_begin[face], end = mesh_.polygon_begin[face + 1];
  std::uint32_t corner = end;
  if (end - begin <= max_searched_corners) {
    corner = static_cast<std::uint32_t>(
        std::find(mesh_.corners.begin() + begin, mesh_.corners.begin() + end, vertex) -
        mesh_.corners.begin());
  } else {
    auto& sorted = sorted_[face];
    if (sorted.empty()) {
      for (std::uint32_t k = begin; k < end; ++k) sorted.emplace_back(mesh_.corners[k], k);
      std::sort(sorted.begin(), sorted.end());
    }
    const auto at = std::lower_bound(sorted.begin(), sorted.end(), std::pair(vertex, std::uint32_t{0}));
    if (at != sorted.end() && at->first == vertex) corner = at->second;
  }
  return corner < end ? corner : no_index;
}

}  // namespace meander
