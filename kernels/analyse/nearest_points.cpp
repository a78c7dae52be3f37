#include "kernels/analyse/nearest_points.h"

#include <cstddef>

#include "kernels/core/parallel.h"

namespace meander {

std::vector<std::uint32_t> nearest_points(const KdTree<3>& tree, std::span<const double> queries) {
  std::vector<std::uint32_t> nearest(queries.size() / 3);
  parallel_blocks(nearest.size(), 1024, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      KdTree<3>::Nearest best;
      tree.nearest({queries[3 * i], queries[3 * i + 1], queries[3 * i + 2]}, KdTree<3>::none, best);
      nearest[i] = best.index;
    }
  });
  return nearest;
}

}  // namespace meander
