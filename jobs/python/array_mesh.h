// Meshes given as arrays.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "jobs/python/interface.h"
#include "kernels/mesh/polygon_mesh.h"

namespace meander {

using Content = std::array<std::uint8_t, 32>;

// A mesh and what its randomness is keyed by.
struct ContentMesh {
  PolygonMesh mesh;
  Content content{};
};

// Copies the arrays. Throws std::invalid_argument for values that are not finite, densities below 0, colors
// outside of [0, 1], attributes that cannot be columns and, with `check`, numbers of vertices that are not
// there. Without it such faces are dropped and counted when the mesh is prepared, as those of files;
// ItemError for more than 32 bits can number.
ContentMesh mesh_of_arrays(const meander_arrays& arrays);

// Gives a mesh a density: numbers of its faces, or of its vertices. Throws std::invalid_argument for values
// that are not finite or below 0, and where there are not as many as faces or vertices.
void set_density(PolygonMesh& mesh, std::span<const double> values, bool of_faces);

// Throws std::invalid_argument that says which of the rows of three is not finite; `name` is that of the
// array.
void require_finite(std::span<const double> triples, const char* name);

}  // namespace meander
