// Point location by the first triangle that a ray hits (docs/METHODS.md 6.7).
#pragma once

#include <span>
#include <vector>

#include "kernels/density/density.h"
#include "kernels/partition/elements.h"
#include "kernels/rays/embree_locator.h"

namespace meander {

// The locator of Quinn et al. (2013), for comparison: the first triangle (the one of lowest number) under
// each leaf center. The leaf's share of the surface is its UV area times the local area factor, which comes
// from the mixed areas (Meyer et al. 2003) of the mesh vertices, times the density there. Leaves are split
// while that is more than total / (kappa N). Area is lost where rays miss: at the chart's border, and on
// every sheet but the first. Components without a tree, or whose rays met nothing, keep whole triangles with
// their exact masses, in 3-D Hilbert order. Elements are whole leaves, so CurveElements::vertex is filled and
// path names the whole triangle (1). Throws ItemError(zero_density) when the total is zero.
CurveElements locate_first_hit(const EmbreeDevice& device, const PreparedMesh& mesh,
                               const MeshMeasure& measure, std::span<const FlatChart> charts,
                               std::vector<CurveTree>& trees, const LocateParameters& parameters,
                               const CancelToken& cancel = {});

}  // namespace meander
