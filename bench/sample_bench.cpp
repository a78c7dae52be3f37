// The 1-D set and the placement of samples.
#include <oneapi/tbb/global_control.h>

#include "bench/bench_shapes.h"
#include "kernels/partition/element_cells.h"
#include "kernels/sample/place_samples.h"

namespace meander::bench {

namespace {

void sequence(benchmark::State& state) {
  static constexpr const char* names[] = {"shifted", "stratified", "owen", "regular", "random"};
  const auto kind = static_cast<SequenceKind>(state.range(0));
  constexpr std::uint32_t count = 1 << 16;
  std::vector<double> positions;
  for ([[maybe_unused]] auto _ : state) {
    positions = sample_sequence(kind, count, 0.25, bench_key());
    benchmark::DoNotOptimize(positions.data());
  }
  count_items(state, "sample", count);
  check_sum(state, names[state.range(0)], positions);
}
BENCHMARK(sequence)->DenseRange(0, 4)->Unit(benchmark::kMillisecond);

void order(benchmark::State& state) {
  const auto count = static_cast<std::uint32_t>(state.range(0));
  std::vector<std::uint32_t> ranks;
  for ([[maybe_unused]] auto _ : state) {
    ranks = progressive_order(count, bench_key());
    benchmark::DoNotOptimize(ranks.data());
  }
  count_items(state, "sample", count);
  check_sum(state, "", ranks);
}
BENCHMARK(order)->Arg(2048)->Arg(100000)->Unit(benchmark::kMicrosecond);

// On the elements of a curve, or in cells; on one core.
void place(benchmark::State& state, const SurfaceOrder& order, const SampleParameters& parameters) {
  const Model& model = prepared_shape(state.range(0));
  const oneapi::tbb::global_control one(oneapi::tbb::global_control::max_allowed_parallelism, 1);
  const PlaceParameters where = place_parameters(parameters);
  OutputFrame frame = output_frame(model.surface, NormalizeKind::none);
  Samples result;
  for ([[maybe_unused]] auto _ : state) {
    RepairCounts repairs;
    Notes notes;
    result = place_samples({{model.surface, model.measure, bench_key()}, model.file, where}, order, frame,
                           repairs, notes);
    benchmark::DoNotOptimize(result.points.data());
  }
  count_items(state, "sample", parameters.samples);
  check_sum(state, shape_name(state.range(0)), result.points);
}

void place_on_elements(benchmark::State& state) {
  const Model& model = prepared_shape(state.range(0));
  const SampleParameters parameters = method_parameters("direct", static_cast<std::uint32_t>(state.range(1)));
  place(state, build_elements({model.surface, model.measure, bench_key()}, element_parameters(parameters)),
        parameters);
}
void place_in_cells(benchmark::State& state) {
  const Model& model = prepared_shape(state.range(0));
  const SampleParameters parameters = method_parameters("auto", static_cast<std::uint32_t>(state.range(1)));
  place(state, build_cells({model.surface, model.measure, bench_key()}, element_parameters(parameters)),
        parameters);
}
// Spaced samples in cells; range 2: spacing, range 3: order.
void place_spaced(benchmark::State& state) {
  const Model& model = prepared_shape(state.range(0));
  SampleParameters parameters = method_parameters("auto", static_cast<std::uint32_t>(state.range(1)));
  parameters.sequence = SequenceKind::spaced;
  parameters.spacing = static_cast<SpacingKind>(state.range(2));
  parameters.order = static_cast<OrderKind>(state.range(3));
  place(state, build_cells({model.surface, model.measure, bench_key()}, element_parameters(parameters)),
        parameters);
}
// The same as place_in_cells, relaxed in the end.
void place_relaxed(benchmark::State& state) {
  const Model& model = prepared_shape(state.range(0));
  SampleParameters parameters = method_parameters("auto", static_cast<std::uint32_t>(state.range(1)));
  parameters.finish = FinishKind::relax;
  place(state, build_cells({model.surface, model.measure, bench_key()}, element_parameters(parameters)),
        parameters);
}
BENCHMARK(place_relaxed)->ArgsProduct({{0, 2}, {2048, 10000, 100000}})->Unit(benchmark::kMillisecond);
BENCHMARK(place_on_elements)->ArgsProduct({{0, 1, 2}, {2048, 100000}})->Unit(benchmark::kMillisecond);
BENCHMARK(place_in_cells)->ArgsProduct({{0, 1, 2}, {2048, 100000}})->Unit(benchmark::kMillisecond);
BENCHMARK(place_spaced)
    ->ArgsProduct({{0, 2}, {2048, 10000, 100000}, {0, 1, 2}, {0, 1}})
    ->Unit(benchmark::kMillisecond);

}  // namespace

}  // namespace meander::bench
