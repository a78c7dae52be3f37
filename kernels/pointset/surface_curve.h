// The curve of sample_surface, leaf by leaf, for figures.
#pragma once

#include <vector>

#include "kernels/core/cancel.h"
#include "kernels/curve/curve_tree.h"
#include "kernels/surface/sample_surface.h"

namespace meander {

// The leaves of the curve of sample_surface, one by one, for figures.
struct SurfaceCurve {
  CurveTree tree;            // over the unit square (the warped one with reparameterize)
  std::vector<double> mass;  // L measures, in curve order; they sum to the measure
  std::vector<double> uv;    // 2 L: the leaf centers in the surface's own parameters
};
SurfaceCurve build_surface_curve(const ParametricSurface& surface, const SurfaceSampleParameters& parameters,
                                 const CancelToken& cancel = {});

}  // namespace meander
