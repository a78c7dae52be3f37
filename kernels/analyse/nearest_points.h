// The nearest point of a set to each of many queries.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "kernels/analyse/kd_tree.h"

namespace meander {

// queries: 3 n finite coordinates. Result: n numbers of points of the tree, KdTree<3>::none where it has
// none; of points equally near any one, always the same. O(log points) a query, about 0.5 us; parallel.
std::vector<std::uint32_t> nearest_points(const KdTree<3>& tree, std::span<const double> queries);

}  // namespace meander
