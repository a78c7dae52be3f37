// Cutting and flattening.
#include "bench/bench_shapes.h"

namespace meander::bench {

namespace {

void cut(benchmark::State& state) {
  const ModelState& model = prepared_shape(state.range(0));
  CutChart chart;
  for ([[maybe_unused]] auto _ : state) {
    chart = cut_to_disk(model.mesh, model.mesh.components.at(0), {});
    benchmark::DoNotOptimize(chart.triangles.data());
  }
  count_items(state, "face", static_cast<double>(model.mesh.triangle_count()));
  check_sum(state, shape_name(state.range(0)), chart.triangles);
}
BENCHMARK(cut)->Apply(every_shape);

void flatten(benchmark::State& state) {
  const ModelState& model = cut_shape(state.range(0));
  FlatChart chart;
  for ([[maybe_unused]] auto _ : state) {
    state.PauseTiming();
    CutChart input = model.cuts.at(0);
    state.ResumeTiming();
    chart = flatten_chart(model.mesh, std::move(input), {});
    benchmark::DoNotOptimize(chart.u.data());
  }
  count_items(state, "face", static_cast<double>(model.mesh.triangle_count()));
  state.counters["extra_seams"] = static_cast<double>(chart.report.extra_seams);
  check_sum(state, shape_name(state.range(0)), chart.u);
}
BENCHMARK(flatten)->Apply(every_shape);

}  // namespace

}  // namespace meander::bench
