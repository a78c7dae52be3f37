// The stages of `meander remesh`: those of `run`, then the mesh.
#pragma once

#include <functional>

#include "io/mesh/mesh_reader.h"
#include "jobs/remesh/carried_values.h"
#include "kernels/remesh/remesh_surface.h"
#include "pipeline/sampling_graph.h"

namespace meander {

// Peak memory of making a mesh, beside what the samples and the prepared mesh take.
std::uint64_t remesh_bytes(const MeshEstimate& mesh, std::uint32_t samples, bool fit,
                           const CarriedColumns& carried);

// Adds the making of the mesh to the stages that `run` has (sampling_stages). `parameters` must outlive them.
// made: called with the mesh, in the coordinates of the file, and what its vertices carry; from many threads.
void add_remesh_stages(
    GraphStages& stages, const SampleParameters& parameters, const RemeshParameters& mesh,
    const CarriedColumns& carried,
    std::function<void(const PlanItem&, const RemeshedSurface&, const CarriedValues&)> made);

}  // namespace meander
