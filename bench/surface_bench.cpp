// Parametric surfaces: their evaluation, the expression densities, and whole samplings.
#include "bench/bench_shapes.h"
#include "kernels/core/expression.h"
#include "kernels/surface/sample_surface.h"

namespace meander::bench {

namespace {

// Points on a line across the square.
std::vector<double> ramp(std::size_t count, double from) {
  std::vector<double> values(count);
  for (std::size_t i = 0; i < count; ++i) {
    const double x = from + 0.6180339887498949 * static_cast<double>(i);
    values[i] = x - static_cast<double>(static_cast<long long>(x));
  }
  return values;
}

void surface_tangents(benchmark::State& state) {
  const auto surface = make_surface(surface_names()[static_cast<std::size_t>(state.range(0))]);
  const std::vector<double> u = ramp(1024, 0.1), v = ramp(1024, 0.3);
  std::vector<SurfaceTangents> result(u.size());
  for ([[maybe_unused]] auto _ : state) {
    surface->tangents(u, v, result);
    benchmark::DoNotOptimize(result.data());
  }
  count_items(state, "point", static_cast<double>(u.size()));
  state.SetLabel(std::string(surface->name()));
}
BENCHMARK(surface_tangents)->DenseRange(0, 6)->Unit(benchmark::kMicrosecond);

void surface_jets(benchmark::State& state) {
  const auto surface = make_surface(surface_names()[static_cast<std::size_t>(state.range(0))]);
  const std::vector<double> u = ramp(1024, 0.1), v = ramp(1024, 0.3);
  std::vector<SurfaceJet> result(u.size());
  for ([[maybe_unused]] auto _ : state) {
    surface->jets(u, v, result);
    benchmark::DoNotOptimize(result.data());
  }
  count_items(state, "point", static_cast<double>(u.size()));
  state.SetLabel(std::string(surface->name()));
}
BENCHMARK(surface_jets)->DenseRange(0, 6)->Unit(benchmark::kMicrosecond);

void expression_density(benchmark::State& state) {
  const ExpressionPreset& preset = expression_presets()[static_cast<std::size_t>(state.range(0))];
  const Expression expression(preset.name);
  const std::vector<double> x = ramp(1024, 0.1), y = ramp(1024, 0.3);
  const std::array<std::span<const double>, 5> inputs = {{{}, {}, x, y, {}}};
  std::vector<double> result(x.size());
  for ([[maybe_unused]] auto _ : state) {
    expression.evaluate(inputs, result);
    benchmark::DoNotOptimize(result.data());
  }
  count_items(state, "point", static_cast<double>(x.size()));
  check_sum(state, std::string(preset.name).c_str(), result);
}
BENCHMARK(expression_density)->DenseRange(0, 4)->Unit(benchmark::kMicrosecond);

// Arguments: surface by number, samples, density (0 uniform, 1 mean curvature).
void sample_parametric(benchmark::State& state) {
  const auto surface = make_surface(surface_names()[static_cast<std::size_t>(state.range(0))]);
  SurfaceSampleParameters parameters;
  parameters.samples = static_cast<std::uint32_t>(state.range(1));
  if (state.range(2) == 1) parameters.density.kind = SurfaceDensityKind::mean;
  SurfaceSamples samples;
  for ([[maybe_unused]] auto _ : state) {
    samples = sample_surface(*surface, parameters);
    benchmark::DoNotOptimize(samples.points.data());
  }
  count_items(state, "sample", static_cast<double>(parameters.samples));
  state.counters["leaves"] = static_cast<double>(samples.leaves);
  state.counters["patches"] = static_cast<double>(samples.patches);
  check_sum(state, std::string(surface->name()).c_str(), samples.points);
}
BENCHMARK(sample_parametric)
    ->ArgsProduct({{0, 1, 2, 3}, {2048, 1000000}, {0, 1}})
    ->Unit(benchmark::kMillisecond);

}  // namespace

}  // namespace meander::bench
