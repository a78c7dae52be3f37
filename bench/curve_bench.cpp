// Curve keys and adaptive trees.
#include <vector>

#include "bench/bench_shapes.h"
#include "kernels/curve/curve_key.h"
#include "kernels/curve/curve_tree.h"

namespace meander::bench {

namespace {

constexpr std::size_t count = 1 << 14;
constexpr const char* kind_names[] = {"hilbert", "peano", "peano-meander"};

std::vector<double> random_numbers(std::size_t n) {
  std::vector<double> numbers(n);
  for (std::size_t i = 0; i < n; ++i) numbers[i] = random_pair(bench_key(), Stream::sequence, i).first;
  return numbers;
}

void plane_keys(benchmark::State& state) {
  const auto kind = static_cast<CurveKind>(state.range(0));
  const std::vector<double> u = random_numbers(2 * count);
  std::vector<std::uint64_t> keys(count);
  for ([[maybe_unused]] auto _ : state) {
    for (std::size_t i = 0; i < count; ++i) keys[i] = curve_key(kind, u[2 * i], u[2 * i + 1]);
    benchmark::DoNotOptimize(keys.data());
  }
  count_items(state, "point", count);
  check_sum(state, kind_names[state.range(0)], keys);
}
BENCHMARK(plane_keys)->DenseRange(0, 2);

void space_keys(benchmark::State& state) {
  const std::vector<double> u = random_numbers(3 * count);
  std::vector<std::uint64_t> keys(count);
  for ([[maybe_unused]] auto _ : state) {
    for (std::size_t i = 0; i < count; ++i)
      keys[i] = hilbert_key_3d({2 * u[3 * i] - 1, 2 * u[3 * i + 1] - 1, 2 * u[3 * i + 2] - 1});
    benchmark::DoNotOptimize(keys.data());
  }
  count_items(state, "point", count);
  check_sum(state, "", keys);
}
BENCHMARK(space_keys);

template <bool coarse>
void space_keys_at_once(benchmark::State& state) {
  const std::vector<double> u = random_numbers(3 * count);
  std::vector<float> points(u.size());
  for (std::size_t i = 0; i < u.size(); ++i) points[i] = static_cast<float>(2 * u[i] - 1);
  std::vector<std::uint64_t> keys(count);
  for ([[maybe_unused]] auto _ : state) {
    if (coarse)
      coarse_hilbert_keys_3d({points.data(), 3}, keys);
    else
      hilbert_keys_3d({points.data(), 3}, keys);
    benchmark::DoNotOptimize(keys.data());
  }
  count_items(state, "point", count);
  check_sum(state, coarse ? "coarse" : "whole", keys);
}
BENCHMARK_TEMPLATE(space_keys_at_once, true);
BENCHMARK_TEMPLATE(space_keys_at_once, false);

void refine_full_tree(benchmark::State& state) {
  const auto kind = static_cast<CurveKind>(state.range(0));
  const int levels = kind == CurveKind::hilbert ? 8 : 5;  // 65,536 and 59,049 leaves
  CurveTree tree;
  for ([[maybe_unused]] auto _ : state) {
    tree = curve_root(kind);
    for (int level = 0; level < levels; ++level)
      tree = refine(tree, std::vector<std::uint8_t>(tree.leaf_count(), 1));
    benchmark::DoNotOptimize(tree.key.data());
  }
  count_items(state, "leaf", static_cast<double>(tree.leaf_count()));
  check_sum(state, kind_names[state.range(0)], tree.key);
}
BENCHMARK(refine_full_tree)->DenseRange(0, 2)->Unit(benchmark::kMillisecond);

void build_curves_of_chart(benchmark::State& state) {
  const Model& model = flat_shape(state.range(0));
  const SampleParameters parameters = bench_parameters(20000);
  std::vector<CurveTree> trees;
  for ([[maybe_unused]] auto _ : state) {
    trees = build_curves(model.surface, model.charts, model.measure.masses, parameters.locator);
    benchmark::DoNotOptimize(trees.data());
  }
  count_items(state, "leaf", static_cast<double>(trees.at(0).leaf_count()));
  check_sum(state, shape_name(state.range(0)), trees.at(0).key);
}
BENCHMARK(build_curves_of_chart)->Apply(every_shape);

}  // namespace

}  // namespace meander::bench
