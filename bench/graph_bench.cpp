// What the flow graph itself costs a model: stages that do nothing, rows without samples, a sink that keeps
// nothing.
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <string>
#include <vector>

#include "bench/bench_shapes.h"
#include "pipeline/sampling_graph.h"

namespace meander::bench {

namespace {

constexpr std::uint64_t items = 100000;

struct CountingSink : RowSink {
  std::vector<std::uint64_t> rows;
  void begin(std::uint64_t) override {}
  void write(EncodedRow row) override { rows.push_back(row.row); }
};

// By threads.
void empty_stages(benchmark::State& state) {
  const int threads = static_cast<int>(state.range(0));
  const oneapi::tbb::global_control most(oneapi::tbb::global_control::max_allowed_parallelism,
                                         static_cast<std::size_t>(threads));
  StoreHeader header;
  header.samples = 1;
  header.parameters_json = "{}";
  std::vector<PlanItem> plan(items);
  for (std::uint64_t i = 0; i < items; ++i) {
    plan[i].row = i;
    plan[i].id = std::to_string(i);
    header.ids.push_back(plan[i].id);
    header.labels.push_back(-1);
  }
  GraphParameters parameters;
  parameters.threads = threads;
  GraphStages stages;
  for (const char* name : {"read_mesh", "prepare_mesh", "locate_vertices", "place_samples"})
    stages.push_back({name, [](GraphItem&) {}});
  CountingSink sink;
  for ([[maybe_unused]] auto _ : state) {
    sink.rows.clear();
    std::atomic<bool> canceled{false};
    std::vector<NodeStatistics> statistics;
    oneapi::tbb::task_arena(threads).execute(
        [&] { run_sampling_graph(plan, parameters, stages, header, sink, canceled, statistics); });
  }
  std::sort(sink.rows.begin(), sink.rows.end());  // rows end in any order
  count_items(state, "model", static_cast<double>(items));
  check_sum(state, "rows", sink.rows);
}
BENCHMARK(empty_stages)->Arg(1)->Arg(2)->UseRealTime()->Unit(benchmark::kMillisecond);

}  // namespace

}  // namespace meander::bench
