// The stages of `meander describe`: rows of a finished store get descriptors.
#pragma once

#include <functional>
#include <string_view>

#include "io/store/store.h"
#include "kernels/core/failure.h"
#include "pipeline/sampling_graph.h"

namespace meander {

// What every row is described with; shared by all threads.
struct Describer {
  const StoreHeader& header;
  SampleParameters points, meshes;  // the descriptors that need the samples alone, and the others
  std::uint64_t memory_bytes = 0;   // for models
  bool allow_oversize = false;

  bool uses_meshes() const { return !meshes.describe.descriptors.empty(); }
  // Whether a column of that name comes from this job.
  bool makes(std::string_view name) const;
};

// From a row of `store` to the row with all descriptors of the header, mesh and all. A stage that throws ends
// the item: it is to be tried again without its mesh.
GraphStages stages_with_meshes(const Describer& describer, const StoreReader& store);

// The same with the descriptors of the samples alone; those that cannot be made are all 0. `failed` hears of
// a row whose samples could not be described; called from many threads.
GraphStages stages_with_points(const Describer& describer, const StoreReader& store,
                               std::function<void(const GraphItem&, Failure)> failed);

}  // namespace meander
