// Samples of a parametric surface as a row of a store.
#pragma once

#include "kernels/data/samples.h"
#include "kernels/surface/sample_surface.h"
#include "kernels/surface/surface.h"

namespace meander {

// Makes the row of status ok with these samples of that surface; the caller sets its content hash. The
// bounding box is that of the samples and of a grid of 65 x 65 points of the surface: it may lack a bump
// between them. O(N).
Row surface_row(const ParametricSurface& surface, SurfaceSamples&& samples);

}  // namespace meander
