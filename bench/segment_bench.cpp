// Random-walk segmentation.
//
// Cost models, and what one core took (CPU time on a shared machine, SSE4.2 code), torus of 70,000 triangles:
//   segment_steps   tensors and exponentials of every edge: 0.35 us a triangle, over the threads
//   segment_seeds   Dijkstra: three full passes and a little for each further seed: 22, 37 and 48 ms for 2,
//   16
//                   and 64
//   segment_walk    one factor of the dual graph, 36 entries a triangle: 12 ms order, 50 ms factor; every
//   batch
//                   of 16 seeds each entry twice, 40 ms: 69, 112 and 140 ms for 2, 16 and 64 (the latter on
//                   two threads)
//   segment_split   tidy and split: 4 ms
#include <cstdint>
#include <vector>

#include "bench/bench_shapes.h"
#include "kernels/mesh/prepare_mesh.h"
#include "kernels/segment/seeds.h"
#include "kernels/segment/segment_mesh.h"
#include "kernels/solve/elimination_order.h"
#include "kernels/solve/sparse_cholesky.h"
#include "support/direction_field.h"
#include "support/test_meshes.h"

namespace meander::bench {

namespace {

// A torus of 35,000 vertices, the goal's size, with a field of ratio 4 up and down.
struct Subject {
  PreparedMesh mesh = prepare_mesh(test::torus(250, 140));
  TensorField field = test::field_along(mesh, {0, 0.3, 1}, 4);
  TriangleSteps steps = triangle_steps(mesh, field);
};
const Subject& subject() {
  static const Subject torus;
  return torus;
}

void segment_steps(benchmark::State& state) {
  TriangleSteps steps;
  for ([[maybe_unused]] auto _ : state) steps = triangle_steps(subject().mesh, subject().field);
  count_items(state, "triangle", static_cast<double>(subject().mesh.triangle_count()));
  check_sum(state, "torus of 70,000", steps.weight);
}
BENCHMARK(segment_steps)->Unit(benchmark::kMillisecond);

void segment_seeds(benchmark::State& state) {
  std::vector<std::uint32_t> seeds;
  for ([[maybe_unused]] auto _ : state)
    seeds =
        farthest_seeds(subject().mesh, subject().steps.length, static_cast<std::uint32_t>(state.range(0)));
  count_items(state, "triangle", static_cast<double>(subject().mesh.triangle_count()));
  check_sum(state, "torus of 70,000", seeds);
}
BENCHMARK(segment_seeds)->Arg(2)->Arg(16)->Arg(64)->Unit(benchmark::kMillisecond);

// Order, factor, and the solves for all seeds.
void segment_walk(benchmark::State& state) {
  const std::vector<std::uint32_t> seeds =
      farthest_seeds(subject().mesh, subject().steps.length, static_cast<std::uint32_t>(state.range(0)));
  std::vector<std::uint32_t> label;
  for ([[maybe_unused]] auto _ : state)
    label = random_walk_labels(subject().mesh, subject().steps.weight, seeds);
  count_items(state, "triangle", static_cast<double>(subject().mesh.triangle_count()));
  check_sum(state, "torus of 70,000", label);
}
BENCHMARK(segment_walk)->Arg(2)->Arg(16)->Arg(64)->Unit(benchmark::kMillisecond);

// The two parts of the walk that do not depend on the seeds: 0 orders, 1 factorizes too.
void segment_factor(benchmark::State& state) {
  const Subject& torus = subject();
  UnknownGraph graph;
  std::vector<double> values, diagonal(torus.mesh.triangle_count(), 1e-3);
  graph.begin.push_back(0);
  for (std::uint32_t h = 0; h < torus.mesh.opposite.size(); ++h) {
    graph.neighbors.push_back(torus.mesh.opposite[h] / 3);
    values.push_back(-torus.steps.weight[h]);
    diagonal[h / 3] += torus.steps.weight[h];
    if (h % 3 == 2) graph.begin.push_back(h + 1);
  }
  std::vector<std::uint32_t> order;
  std::size_t entries = 0;
  for ([[maybe_unused]] auto _ : state) {
    order = elimination_order(graph);
    if (state.range(0) == 0) continue;
    SparseCholesky cholesky;
    cholesky.factorize(graph, values, diagonal, order);
    entries = cholesky.factor_entries();
  }
  count_items(state, "triangle", static_cast<double>(torus.mesh.triangle_count()));
  state.counters["factor_entries"] = static_cast<double>(entries);
  check_sum(state, "torus of 70,000", order);
}
BENCHMARK(segment_factor)->Arg(0)->Arg(1)->Unit(benchmark::kMillisecond);

void segment_split(benchmark::State& state) {
  const Subject& torus = subject();
  const std::vector<std::uint32_t> walked =
      random_walk_labels(torus.mesh, torus.steps.weight, farthest_seeds(torus.mesh, torus.steps.length, 16));
  SegmentedMesh split;
  for ([[maybe_unused]] auto _ : state) {
    std::vector<std::uint32_t> label = walked;
    tidy_segments(torus.mesh, torus.steps.length, 20, label);
    split = split_into_segments(torus.mesh, label);
  }
  count_items(state, "triangle", static_cast<double>(torus.mesh.triangle_count()));
  check_sum(state, "torus of 70,000", split.mesh.triangles);
}
BENCHMARK(segment_split)->Unit(benchmark::kMillisecond);

void segment_whole(benchmark::State& state) {
  SegmentedMesh split;
  for ([[maybe_unused]] auto _ : state) split = segment_mesh(subject().mesh, subject().field, {16, 20, {}});
  count_items(state, "triangle", static_cast<double>(subject().mesh.triangle_count()));
  check_sum(state, "torus of 70,000", split.mesh.triangles);
}
BENCHMARK(segment_whole)->Unit(benchmark::kMillisecond);

}  // namespace

}  // namespace meander::bench
