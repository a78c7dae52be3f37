// Meshes as queries: sampled and described as the rows of a store were.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "io/store/store_reader.h"
#include "jobs/cli/usage_error.h"
#include "jobs/inputs/inputs.h"
#include "pipeline/sampling_graph.h"

namespace meander {

struct MeshQuery {
  std::string id;
  PlanItem file;
  Status status = Status::internal;
  std::string reason;         // empty when ok
  std::vector<float> values;  // of the wanted descriptors, one after the other; empty unless ok
};

// One query for each mesh that the arguments name or contain (as the INPUT of `run`), in the order of their
// ids. A mesh that cannot be read, sampled or described has its status and reason; folders that could not be
// read are named on standard error. `path` names the store. Models that need more than `memory` bytes
// together wait for each other; one alone has 120 s. Throws UsageError: see stored_parameters and
// collect_inputs; no mesh at all.
std::vector<MeshQuery> describe_queries(const StoreReader& store, const std::string& path,
                                        std::span<const DescriptorSchema> wanted,
                                        const std::vector<std::string>& arguments, std::uint64_t memory);

}  // namespace meander
