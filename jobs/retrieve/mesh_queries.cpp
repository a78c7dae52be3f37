#include "jobs/retrieve/mesh_queries.h"

#include <fmt/format.h>
#include <oneapi/tbb/info.h>

#include <algorithm>
#include <atomic>
#include <optional>
#include <utility>

#include "jobs/cli/usage_error.h"
#include "jobs/inputs/input_options.h"
#include "jobs/rows/planned_run.h"
#include "jobs/rows/run_header.h"
#include "jobs/rows/stored_parameters.h"
#include "kernels/describe/describe_samples.h"
#include "kernels/mesh/prepare_mesh.h"
#include "pipeline/sampling_graph.h"

namespace meander {

namespace {

constexpr double query_seconds = 120;

// The wanted rows of descriptors, one after the other.
std::vector<float> described(Model& model, const StoredParameters& parameters,
                             std::span<const DescriptorSchema> wanted) {
  Samples& samples = model.row.samples;
  // As for the rows of a store.
  if (!model.surface.has_topology()) model.surface = prepare_mesh(model.file, model.cancel);
  locate_on_mesh(model.file, model.surface, samples);
  std::vector<float> values;
  for (std::size_t k = 0; k < wanted.size(); ++k)
    for (const DescriptorRow& row :
         describe_samples(model.surface, samples, model.key, parameters.describe[k], model.cancel))
      if (row.name == wanted[k].name) {
        if (row.values.size() != wanted[k].width)
          throw ItemError(Status::internal, fmt::format("{} has {} values, and {} in the store", row.name,
                                                        row.values.size(), wanted[k].width));
        values.insert(values.end(), row.values.begin(), row.values.end());
      }
  return values;
}

StoreHeader header_of(const SampleParameters& sample, const Inputs& inputs) {
  RunOptions options;
  options.sample = sample;
  options.parameters_json = "{}";
  return run_header(options, inputs, nullptr);
}

}  // namespace

std::vector<MeshQuery> describe_queries(const StoreReader& store, const std::string& path,
                                        std::span<const DescriptorSchema> wanted,
                                        const std::vector<std::string>& arguments, std::uint64_t memory) {
  const StoredParameters stored = stored_parameters(store, path, wanted);
  Inputs inputs = collect_inputs(arguments);
  print_unread(inputs.notes);
  if (inputs.items.empty()) throw UsageError("--mesh: no mesh file is there");
  GraphParameters graph;
  graph.sample = stored.sample;
  for (const DescribeParameters& describe : stored.describe)  // for the estimate of memory
    graph.sample.describe.descriptors.push_back(describe.descriptors.front());
  graph.threads = std::max(1, oneapi::tbb::info::default_concurrency());
  graph.memory_bytes = memory;
  graph.timeout_seconds = query_seconds;
  reserve_memory(inputs.items, graph.sample, graph.threads, graph.memory_bytes);

  std::vector<MeshQuery> queries(inputs.items.size());
  std::optional<EmbreeDevice> device;
  if (casts_rays(stored.sample)) device.emplace();
  GraphStages stages = sampling_stages(stored.sample, device ? &*device : nullptr);
  stages.push_back({"describe_shape", [&](GraphItem& item) {
                      release_charts(item.model);
                      queries[item.plan->row].values = described(item.model, stored, wanted);
                    }});
  NoRows rows;
  std::atomic<bool> stopped = false;
  std::vector<NodeStatistics> statistics;
  const StoreHeader header = header_of(stored.sample, inputs);
  run_sampling_graph(inputs.items, graph, stages, header, rows, stopped, statistics,
                     [&](const FinishedItem& item) {
                       MeshQuery& query = queries[item.plan.row];
                       query.id = item.plan.id;
                       query.file = item.plan;
                       query.status = item.report.status;
                       query.reason = item.report.reason;
                       if (query.status != Status::ok) query.values.clear();
                     });
  return queries;
}

}  // namespace meander
