// Discrepancy on a mesh over patches grown ring by ring: the measure of Quinn et al. 2013 (docs/METHODS.md
// 13.2).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "kernels/analyse/discrepancy_shapes.h"

namespace meander {

// The triangles around every vertex: those of vertex v are triangles[begin[v]] .. triangles[begin[v + 1] -
// 1].
struct VertexTriangles {
  std::vector<std::uint32_t> begin;
  std::vector<std::uint32_t> triangles;
};
// triangles: 3 T vertex numbers below vertex_count. O(T). Throws std::invalid_argument when one is not.
VertexTriangles triangles_around_vertices(std::span<const std::uint32_t> triangles,
                                          std::uint32_t vertex_count);

// Random seed vertices: number i is the corner of a random triangle, a function of (seed, i) and the
// triangles. Empty without triangles.
std::vector<std::uint32_t> ring_seeds(std::span<const std::uint32_t> triangles, std::uint32_t count,
                                      std::uint64_t seed);

// Ring 1 of a seed vertex is the triangles around it, ring k + 1 adds all that touch ring k; every patch of
// rings 1 .. k is a test shape: max over seeds and k of |samples inside / samples - measure inside /
// measure|. measure: T areas or masses >= 0; counts: T numbers of samples by triangle (exact membership, no
// geometry). Growth stops at the edge of the seed's component (the component is then the last patch). One
// breadth-first search a seed, O(T) each, gives every ring. shapes in the result: seeds; running_max is over
// batches of seeds, and all seeds are looked at. Throws std::invalid_argument when lengths differ, a seed is
// out of range, or there are no samples or no measure.
ShapeDiscrepancy ring_discrepancy(std::span<const std::uint32_t> triangles, const VertexTriangles& around,
                                  std::span<const double> measure, std::span<const std::uint32_t> counts,
                                  std::span<const std::uint32_t> seeds);

}  // namespace meander
