// Regions of a mesh to count samples in.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "kernels/mesh/prepared_mesh.h"

namespace meander::test {

// By triangle: the cell of its centroid in a grid of side^3 around the mesh.
inline std::vector<std::uint32_t> grid_regions(const PreparedMesh& mesh, std::uint32_t side) {
  std::vector<std::uint32_t> region(mesh.triangle_count());
  for (std::uint32_t t = 0; t < region.size(); ++t) {
    Vector3 p;
    for (std::uint32_t k = 0; k < 3; ++k) p = p + mesh.position(mesh.triangles[3 * t + k]);
    p = mesh.center + mesh.unit / 3 * p;
    const std::array<double, 3> at = {p.x, p.y, p.z};
    for (std::size_t k = 0; k < 3; ++k) {
      const double share = (at[k] - mesh.bbox[k]) / (mesh.bbox[k + 3] - mesh.bbox[k]);
      region[t] = side * region[t] +
                  static_cast<std::uint32_t>(std::clamp(share * side, 0.0, static_cast<double>(side - 1)));
    }
  }
  return region;
}

}  // namespace meander::test
