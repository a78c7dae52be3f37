// Internal to kernels/sample: a surface as points with masses, for sums of smooth kernels over it.
#pragma once

#include "kernels/core/cancel.h"
#include "kernels/core/vector3.h"
#include "kernels/density/density.h"
#include "kernels/mesh/prepared_mesh.h"
#include "kernels/sample/kernel_sums.h"

namespace meander {

// Lower densities count as this one where they say how far samples are apart.
inline constexpr double min_density = 1e-30;

// Positions from `origin` (working units), masses in units of `unit` (area x density, working units), and
// normals: triangles in pieces whose edges are shorter than a spacing, sqrt(unit / density), or that are
// light; light pieces that lie together and face one way are one point. For kernels that change over half a
// spacing: with pieces of .5 and cells of .3 spacings the error of relaxed samples is less than 1 % lower.
// O(T + pieces); at most 128 pieces a unit of mass, and about 8 points. Deterministic.
SurfaceRows surface_points(const PreparedMesh& mesh, const Density& density, double unit,
                           const Vector3& origin, const CancelToken& cancel);

}  // namespace meander
