// Normals of samples with a consistent outside, whatever winding the file has.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "kernels/mesh/prepared_mesh.h"

namespace meander {

struct OutwardNormals {
  std::vector<float> normals;  // 3 per sample, of the flat triangle, of length 1
  // Share of the samples on components with a boundary, whose outside is a convention.
  double unoriented_share = 0;
};

// Orients the components. triangle: the triangle of every sample. A closed component is turned so that its
// signed volume is positive. A component with a boundary has no outside; it is turned so that it faces away
// from the centroid of the whole surface: the integral of (x - centroid) . n over it is positive, which is
// three times the volume where the surface is closed. A component for which that integral vanishes keeps the
// winding of the file. So turning any component of a model inside out does not change the normals. O(T + N).
// Throws std::invalid_argument for a triangle that the mesh does not have.
OutwardNormals outward_normals(const PreparedMesh& mesh, std::span<const std::uint32_t> triangle);

}  // namespace meander
