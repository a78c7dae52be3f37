// Encoding rows of the store.
#include "bench/bench_shapes.h"
#include "io/store/store.h"

namespace meander::bench {

namespace {

void encode(benchmark::State& state) {
  static constexpr const char* names[] = {"standard", "none"};
  ModelState model = prepared_shape(0);
  SampleParameters parameters = bench_parameters(static_cast<std::uint32_t>(state.range(1)));
  parameters.method = MethodChoice::direct;
  locate_model(model, parameters, nullptr);
  place_model(model, parameters);
  StoreHeader header;
  header.samples = parameters.place.samples;
  header.compression = static_cast<Compression>(state.range(0));
  header.parameters_json = "{}";
  header.ids = {"sphere.off"};
  header.labels = {-1};
  EncodedRow row;
  for ([[maybe_unused]] auto _ : state) {
    row = encode_row(header, 0, model.row);
    benchmark::DoNotOptimize(row.bytes.data());
  }
  count_items(state, "sample", static_cast<double>(header.samples));
  state.counters["bytes"] = static_cast<double>(row.bytes.size());
  check_sum(state, names[state.range(0)], row.bytes);
}
BENCHMARK(encode)->ArgsProduct({{0, 1}, {2048, 100000}})->Unit(benchmark::kMillisecond);

}  // namespace

}  // namespace meander::bench
