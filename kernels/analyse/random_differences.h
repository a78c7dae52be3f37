// What differences between the samples of a mesh are compared with (differential_domain.h).
#pragma once

#include <cstddef>
#include <cstdint>

#include "kernels/analyse/differential_domain.h"
#include "kernels/mesh/prepared_mesh.h"

namespace meander {

// Adds `sets` sets of `count` independent points, uniform by area in working coordinates, with the normals of
// their triangles. Deterministic by seed. O(sets count log T) and what add_surface_differences takes.
void add_random_surface_differences(DifferenceMap& map, const PreparedMesh& mesh, std::size_t count,
                                    std::uint64_t seed, std::uint32_t sets);

}  // namespace meander
