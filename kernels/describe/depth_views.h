// Depth images of a surface from its principal directions, as a descriptor of shape.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "kernels/core/cancel.h"
#include "kernels/mesh/prepared_mesh.h"

namespace meander {

// Frequencies (u, v), u, v >= 0, within these radii keep their magnitudes and their parts.
inline constexpr std::uint32_t view_magnitude_radius = 8, view_part_radius = 3;
inline constexpr std::size_t depth_view_values = 522;

// Six parallel views along the principal axes of the surface, both ways, as depth images: 1 at the near and 0
// at the far side of a cube around it, of half-width 2 x the root mean square distance of the surface from
// its centroid, and 0 where there is no surface. (Depth images of aligned models by their Fourier
// coefficients: Heczko, Keim, Saupe and Vranic 2002, "Verfahren zur Aehnlichkeitssuche auf 3D-Objekten";
// Vranic 2004.) Each pair of opposite views, for the axis of the smallest moment of inertia first, gives:
//   - mean and half difference of sqrt|F(u, v)| in both views, each the mean of (u, v) and (-u, v);
//   - at low frequencies the roots of mean and half difference of the cos cos, cos sin, sin cos and sin sin
//     parts of F, by absolute value, without those that are 0 by definition: they tell where things are.
// No choice of sense along the axes changes the values, so they change with neither position, direction,
// size, handedness nor the sense of faces. Axes of equal moments (of a cube, of a solid of revolution around
// its axis) have no direction of their own: there the values depend on how the model stands.
//
// A rasterizer of our own draws 128 x 128 pixels in double precision, instead of Embree: every triangle is
// visited once for two views, no tree is built, and the bits are the same on every processor. Surfaces of so
// many layers that the pixels of a view would exceed 2^26 are drawn with fewer pixels, 16 x 16 at least. O(T
// + pixels). Deterministic. Throws ItemError(zero_area) without area, and timeout / RunCanceled from
// `cancel`.
std::vector<float> depth_views(const PreparedMesh& mesh, const CancelToken& cancel = {});

}  // namespace meander
