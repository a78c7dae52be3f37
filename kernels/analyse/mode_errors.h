// The error of a point set for the lowest eigenfunctions of the Laplacian of a surface
// (docs/METHODS.md 13.10).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "kernels/analyse/point_location.h"
#include "kernels/core/cancel.h"
#include "kernels/mesh/prepared_mesh.h"

namespace meander {

// As many as 800 take five minutes on 17,000 vertices, 100 seven seconds.
inline constexpr std::uint32_t most_surface_modes = 1000;

// A function that is linear on every triangle of one component and 0 on the others.
struct SurfaceMode {
  double value = 0;  // of the Laplacian; 0: the function is 1 on the component
  std::uint32_t component = 0;
  std::vector<double> function;   // of the component's vertices, from its vertex_begin on
  double mean = 0, variance = 0;  // over the whole surface, exact
};

// The lowest `count` eigenfunctions of all components together, in ascending order, by laplacian_modes;
// before them, where there is more than one component, the indicators of the components, largest first, which
// span the eigenspace of 0. Functions that are constant on the surface are left out; fewer come where there
// are fewer. Throws SpectrumNotFound, ItemError(internal), and timeout / RunCanceled from `cancel`. O(V^1.5 +
// count V) for each component that has any.
std::vector<SurfaceMode> lowest_modes(const PreparedMesh& mesh, std::size_t count,
                                      const CancelToken& cancel = {});

// Root mean square over the functions of their mean at n points minus the exact one, relative to random
// points: over sqrt(variance / n) of each. 1 for random points, smaller is better. points: where they lie on
// `mesh`. Throws std::invalid_argument without points or functions. O(modes n).
double mode_error_ratio(const PreparedMesh& mesh, std::span<const SurfaceMode> modes,
                        const SurfaceLocations& points);

}  // namespace meander
