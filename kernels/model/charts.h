// Charts of all components of a surface.
#pragma once

#include <span>
#include <vector>

#include "kernels/core/cancel.h"
#include "kernels/cut/cut_to_disk.h"
#include "kernels/data/samples.h"
#include "kernels/flatten/flatten_chart.h"
#include "kernels/mesh/measured_mesh.h"

namespace meander {

// One disk for each component; components without area get none (an empty one). Parallel over components.
// Throws what cut_to_disk throws.
std::vector<CutChart> cut_components(const MeasuredMesh& surface, const CutParameters& parameters,
                                     const CancelToken& cancel);

// Their charts. Parallel over components, each with a bound of its own on its work (flatten_budget), so that
// none depends on the others or on the number of threads. Throws what flatten_chart throws.
std::vector<FlatChart> flatten_components(const MeasuredMesh& surface, std::vector<CutChart> cuts,
                                          const FlattenParameters& parameters, const CancelToken& cancel);

// What a row says of its charts: the weakest method (direct for charts with Method::none) and why, sums of
// flips, and means by area.
void report_charts(std::span<const Component> components, std::span<const FlatChart> charts,
                   ItemReport& report);

}  // namespace meander
