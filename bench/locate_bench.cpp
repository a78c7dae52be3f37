// Curve elements and point location.
#include "bench/bench_shapes.h"
#include "kernels/partition/element_cells.h"
#include "kernels/partition/elements.h"
#include "kernels/rays/embree_locator.h"

namespace meander::bench {

namespace {

// Second argument: samples. Charts by the first: with them the keys come from the chart, else from space.
void elements(benchmark::State& state, bool charts) {
  const Model& model = charts ? flat_shape(state.range(0)) : prepared_shape(state.range(0));
  ElementParameters parameters;
  parameters.samples = static_cast<std::uint64_t>(state.range(1));
  CurveElements result;
  for ([[maybe_unused]] auto _ : state) {
    result = build_elements({model.surface, model.measure, bench_key(), model.charts}, parameters);
    benchmark::DoNotOptimize(result.cumulative.data());
  }
  count_items(state, "element", static_cast<double>(result.count()));
  state.counters["elements"] = static_cast<double>(result.count());
  check_sum(state, shape_name(state.range(0)), result.cumulative);
}
void elements_in_space(benchmark::State& state) { elements(state, false); }
void elements_on_chart(benchmark::State& state) { elements(state, true); }
BENCHMARK(elements_in_space)->ArgsProduct({{0, 1, 2}, {2048, 100000}})->Unit(benchmark::kMillisecond);
BENCHMARK(elements_on_chart)->ArgsProduct({{0, 1, 2}, {2048, 100000}})->Unit(benchmark::kMillisecond);

// Pieces, tree and path of balanced bisection in space.
void cells_in_space(benchmark::State& state) {
  const Model& model = prepared_shape(state.range(0));
  const ElementParameters elements =
      element_parameters(method_parameters("auto", static_cast<std::uint32_t>(state.range(1))));
  ElementCells result;
  for ([[maybe_unused]] auto _ : state) {
    result = build_cells({model.surface, model.measure, bench_key()}, elements);
    benchmark::DoNotOptimize(result.cells.cell.data());
  }
  count_items(state, "sample", static_cast<double>(result.count()));
  std::vector<double> path;
  for (const Cell& cell : result.cells.cell) path.push_back(static_cast<double>(cell.direction[0]));
  check_sum(state, shape_name(state.range(0)), path);
}
BENCHMARK(cells_in_space)->ArgsProduct({{0, 1, 2}, {2048, 100000}})->Unit(benchmark::kMillisecond);

void locate_rays(benchmark::State& state) {
  static const EmbreeDevice device;
  const Model& model = flat_shape(state.range(0));
  const SampleParameters parameters = bench_parameters(static_cast<std::uint32_t>(state.range(1)));
  const std::vector<CurveTree> start =
      build_curves(model.surface, model.charts, model.measure.masses, parameters.locator);
  Located result;
  for ([[maybe_unused]] auto _ : state) {
    state.PauseTiming();
    std::vector<CurveTree> trees = start;
    state.ResumeTiming();
    result = locate_with_embree(device, model.surface, model.charts, model.measure.masses, trees, bench_key(),
                                parameters.locator);
    benchmark::DoNotOptimize(result.hits.data());
  }
  count_items(state, "ray", static_cast<double>(result.rays));
  state.counters["rays"] = static_cast<double>(result.rays);
  state.counters["leaves"] = static_cast<double>(result.leaves);
  check_sum(state, shape_name(state.range(0)), result.hits);
}
BENCHMARK(locate_rays)->ArgsProduct({{0, 1, 2}, {2048, 100000}})->Unit(benchmark::kMillisecond);

}  // namespace

}  // namespace meander::bench
