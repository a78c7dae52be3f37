// Seeds of segments, far apart from each other.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "kernels/core/cancel.h"
#include "kernels/mesh/prepared_mesh.h"

namespace meander {

// Farthest-point seeds in the dual graph (Gonzalez 1985), with distances by Dijkstra over `length` (3 T, >=
// 0, equal on both half-edges). The first seed of every component is the triangle farthest from the one whose
// centroid lies farthest from the component's; each further seed is the triangle of the mesh farthest from
// all seeds, ties to the lower index. Returns triangles in the order in which they were found: first one for
// every component, in the order of components, then the others up to `count` in all; fewer where every other
// triangle lies at distance 0. O(T log T) for the first seeds, less for each further one. Throws timeout /
// RunCanceled.
std::vector<std::uint32_t> farthest_seeds(const PreparedMesh& mesh, std::span<const double> length,
                                          std::uint32_t count, const CancelToken& cancel = {});

// The same within one component.
std::vector<std::uint32_t> farthest_seeds(const PreparedMesh& mesh, const Component& component,
                                          std::span<const double> length, std::uint32_t count,
                                          const CancelToken& cancel = {});

}  // namespace meander
