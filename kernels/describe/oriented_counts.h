// What the histograms of oriented pairs share: the layout of normals, the bins, and the loops. Internal to
// kernels/describe.
#pragma once

#include <span>
#include <vector>

#include "kernels/describe/oriented_tiles.h"
#include "kernels/describe/pair_points.h"

namespace meander {

// Normals in the layout of PairPoints.
struct PairNormals {
  std::vector<float> x, y, z;

  explicit PairNormals(std::span<const float> normals) {
    const std::size_t count = normals.size() / 3;
    std::size_t k = 0;
    for (auto* coordinates : {&x, &y, &z}) {
      coordinates->assign(2 * count + pair_lanes, 0.0f);
      for (std::size_t i = 0; i < count; ++i)
        (*coordinates)[i] = (*coordinates)[count + i] = normals[3 * i + k];
      ++k;
    }
  }
  OrientedTile with(const PairTile& places) const { return {places, x.data(), y.data(), z.data()}; }
};

// bins_per_distance: in working units.
OrientedCounter oriented_counter(NormalSense sense, double bins_per_distance);
const OrientedLoops& oriented_loops(InstructionSet set);

}  // namespace meander
