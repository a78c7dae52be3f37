// Which charts get rays, and how fine their curves are.
#pragma once

#include <span>

#include "kernels/rays/embree_locator.h"
#include "kernels/rays/refine_by_rays.h"

namespace meander {

// What decides the rays of a model. Masses in working units squared.
struct RayPlan {
  double total = 0;      // of all masses
  double leaf_mass = 0;  // a leaf is split while its mass is larger: total / (kappa N)
};

// Throws ItemError(internal) where the sizes of charts, components and masses disagree.
RayPlan plan_rays(const PreparedMesh& mesh, std::span<const FlatChart> charts, std::span<const double> masses,
                  const LocateParameters& parameters);

// Sum of the masses of one component.
double component_mass(const Component& component, std::span<const double> masses);

// Depths of the tree of a chart of mass m, which expects N_c = N m / total samples: at least
// max(3, floor(log2(kappa N_c) / 2) - 1), so that every part of the chart is covered by rays; at most
// max_depth.
DepthRange depth_range(double mass, const RayPlan& plan, const CurveParameters& parameters);

}  // namespace meander
