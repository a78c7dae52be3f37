// Simplification by quadric edge collapse, to compare with.
#pragma once

#include <cstdint>
#include <vector>

#include "kernels/mesh/prepared_mesh.h"

namespace meander {

struct SimplifiedMesh {
  std::vector<double> x, y, z;
  std::vector<std::uint32_t> triangles;
};

// OpenMesh's decimater with the error quadrics of Garland and Heckbert (1997, "Surface simplification using
// quadric error metrics"), which collapses half-edges, so that vertices stay where they are; down to that
// many vertices, or as far as it comes without changing the topology. Working units. Faces that OpenMesh does
// not take (two edges between the same vertices) are left out. O(T log T).
SimplifiedMesh quadric_collapse(const PreparedMesh& mesh, std::size_t vertices);

}  // namespace meander
