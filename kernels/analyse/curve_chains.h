// The curve of a chart, clipped to the chart: the chains that figure 13 shows.
#pragma once

#include <cstdint>
#include <vector>

#include "kernels/core/vector3.h"
#include "kernels/curve/curve_tree.h"
#include "kernels/flatten/flatten_chart.h"
#include "kernels/mesh/prepared_mesh.h"

namespace meander {

// A connected part of the curve over a chart.
struct CurveChain {
  std::vector<double> u, v;
  std::vector<Vector3> position;  // on the surface, working units
  std::vector<double> along;      // number of the leaf plus the way to the next one, ascending
};

// The line through the centers of the leaves, in steps of 1/steps of each link, where a triangle of the chart
// lies below it (the first one, where the chart overlaps itself). Chains of a single point are left out.
// O(T + L steps). Method::none and empty trees give none.
std::vector<CurveChain> curve_chains(const PreparedMesh& mesh, const FlatChart& chart, const CurveTree& tree,
                                     std::uint32_t steps);

}  // namespace meander
