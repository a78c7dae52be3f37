// The stages of `meander remesh`: those of `run`, then the mesh and its file.
#pragma once

#include <filesystem>
#include <functional>

#include "io/mesh/mesh_reader.h"
#include "kernels/remesh/remesh_surface.h"
#include "pipeline/sampling_graph.h"

namespace meander {

// Peak memory of making a mesh, beside what the samples and the prepared mesh take.
std::uint64_t remesh_bytes(const MeshEstimate& mesh, std::uint32_t samples, bool fit);

struct RemeshTarget {
  std::filesystem::path path;
  MeshFormat format = MeshFormat::ply;
};

// read_mesh .. place_samples as `run` has them, then remesh_surface, which writes the file too. `parameters`
// must outlive the stages. target_of: where the mesh of an item goes; done: called with what was made, when
// the file is whole; both from many threads.
GraphStages remesh_stages(const SampleParameters& parameters, const EmbreeDevice* device,
                          const RemeshParameters& mesh,
                          std::function<RemeshTarget(const PlanItem&)> target_of,
                          std::function<void(const PlanItem&, const RemeshReport&)> done);

}  // namespace meander
