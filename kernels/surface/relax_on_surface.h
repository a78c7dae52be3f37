// Relaxed samples of parametric surfaces (docs/METHODS.md 7.9).
#pragma once

#include <cstdint>
#include <span>

#include "kernels/core/cancel.h"
#include "kernels/core/random.h"
#include "kernels/surface/surface_measure.h"

namespace meander {

// Moves points of the curve's square as relax_samples moves samples of a mesh: over triangles between the
// points of a grid in the square, with the density of these points. The grid is as fine as .7 of the spacing
// sqrt(area / n) where the surface is stretched most, but has no more than 8 n + 65,536 cells. Sides of the
// square that coincide in space, within 1e-9 of the diagonal, are joined: samples move across the seam of a
// sphere or a torus.
//
// points: n of [0, 1]^2, in the order of a path (relax_samples). uniform: the density is 1 everywhere; area:
// of the surface, > 0. Returns how many stay where they are, since sheets of the surface lie on each other
// around them, or since the surface has no area there. The same for every thread count. Throws as
// SurfaceMeasure::evaluate; timeout and RunCanceled. Some 12 us a sample on one core, and 1.2 KB at the
// peak.
std::uint32_t relax_on_surface(const SurfaceMeasure& measure, bool uniform, double area,
                               std::span<UnitPair> points, const CancelToken& cancel);

}  // namespace meander
