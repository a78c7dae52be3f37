// Cutting and flattening, and the linear system of flattening beside Eigen's solver.
#include <Eigen/SparseCholesky>

#include "bench/bench_shapes.h"
#include "kernels/solve/sparse_cholesky.h"

namespace meander::bench {

namespace {

void coarsen(benchmark::State& state) {
  const Model& model = prepared_shape(state.range(0));
  CoarseMesh coarse;
  for ([[maybe_unused]] auto _ : state) {
    coarse = coarsen_mesh(model.surface, model.measure.masses, 2048, {});
    benchmark::DoNotOptimize(coarse.triangle.data());
  }
  count_items(state, "face", static_cast<double>(model.surface.triangle_count()));
  state.counters["coarse_faces"] = static_cast<double>(coarse.mesh.triangle_count());
  check_sum(state, shape_name(state.range(0)), coarse.triangle);
}
BENCHMARK(coarsen)->Apply(every_shape);

void cut(benchmark::State& state) {
  const Model& model = prepared_shape(state.range(0));
  CutChart chart;
  for ([[maybe_unused]] auto _ : state) {
    chart = cut_to_disk(model.surface, model.surface.components.at(0), {});
    benchmark::DoNotOptimize(chart.triangles.data());
  }
  count_items(state, "face", static_cast<double>(model.surface.triangle_count()));
  check_sum(state, shape_name(state.range(0)), chart.triangles);
}
BENCHMARK(cut)->Apply(every_shape);

void flatten(benchmark::State& state) {
  const Model& model = cut_shape(state.range(0));
  FlatChart chart;
  for ([[maybe_unused]] auto _ : state) {
    state.PauseTiming();
    CutChart input = model.cuts.at(0);
    state.ResumeTiming();
    chart = flatten_chart(model.surface, std::move(input), {});
    benchmark::DoNotOptimize(chart.u.data());
  }
  count_items(state, "face", static_cast<double>(model.surface.triangle_count()));
  state.counters["extra_seams"] = static_cast<double>(chart.report.extra_seams);
  check_sum(state, shape_name(state.range(0)), chart.u);
}
BENCHMARK(flatten)->Apply(every_shape);

// The graph Laplacian of a cut shape with its boundary fixed: the pattern that flattening factorizes.
struct DirichletSystem {
  UnknownGraph graph;
  std::vector<double> values, diagonal;
};

DirichletSystem dirichlet_system(const CutChart& chart) {
  std::vector<std::uint8_t> on_boundary(chart.vertex_count(), 0);
  const auto next = [](std::size_t h) { return h - h % 3 + (h + 1) % 3; };
  for (std::size_t h = 0; h < chart.opposite.size(); ++h)
    if (chart.opposite[h] == no_index)
      on_boundary[chart.triangles[h]] = on_boundary[chart.triangles[next(h)]] = 1;
  std::vector<std::uint32_t> unknown(chart.vertex_count(), no_index);
  std::uint32_t count = 0;
  for (std::size_t v = 0; v < unknown.size(); ++v)
    if (!on_boundary[v]) unknown[v] = count++;
  DirichletSystem system;
  system.diagonal.assign(count, 0);
  system.graph.begin.assign(count + 1, 0);
  const auto each_edge = [&](const auto& body) {  // both directions of every edge that starts inside
    for (std::size_t h = 0; h < chart.opposite.size(); ++h)
      if (chart.opposite[h] != no_index && unknown[chart.triangles[h]] != no_index)
        body(unknown[chart.triangles[h]], unknown[chart.triangles[next(h)]]);
  };
  each_edge([&](std::uint32_t i, std::uint32_t j) {
    system.diagonal[i] += 1;
    if (j != no_index) ++system.graph.begin[i + 1];
  });
  for (std::size_t i = 0; i < count; ++i) system.graph.begin[i + 1] += system.graph.begin[i];
  system.graph.neighbors.resize(system.graph.begin.back());
  system.values.assign(system.graph.begin.back(), -1);
  std::vector<std::uint32_t> cursor(system.graph.begin.begin(), system.graph.begin.end() - 1);
  each_edge([&](std::uint32_t i, std::uint32_t j) {
    if (j != no_index) system.graph.neighbors[cursor[i]++] = j;
  });
  return system;
}

// Order, factorize, and solve for two right-hand sides: what boundary-first flattening does once per chart.
void solve_system(benchmark::State& state) {
  const DirichletSystem system = dirichlet_system(cut_shape(state.range(0)).cuts.at(0));
  std::vector<double> x, y;
  std::size_t entries = 0;
  for ([[maybe_unused]] auto _ : state) {
    SparseCholesky cholesky;
    cholesky.factorize(system.graph, system.values, system.diagonal, elimination_order(system.graph));
    x.assign(system.diagonal.size(), 1);
    y.assign(system.diagonal.size(), 2);
    cholesky.solve(x, y);
    entries = cholesky.factor_entries();
    benchmark::DoNotOptimize(x.data());
  }
  count_items(state, "unknown", static_cast<double>(x.size()));
  state.counters["factor_entries"] = static_cast<double>(entries);
  check_sum(state, shape_name(state.range(0)), x);
}
BENCHMARK(solve_system)->Apply(every_shape);

// The same by Eigen: SimplicialLDLT with its own minimum degree order.
void solve_system_eigen(benchmark::State& state) {
  const DirichletSystem system = dirichlet_system(cut_shape(state.range(0)).cuts.at(0));
  const auto count = static_cast<Eigen::Index>(system.diagonal.size());
  Eigen::MatrixX2d x;
  for ([[maybe_unused]] auto _ : state) {
    std::vector<Eigen::Triplet<double>> lower;
    for (std::uint32_t i = 0; i < system.diagonal.size(); ++i) {
      lower.emplace_back(i, i, system.diagonal[i]);
      for (std::uint32_t k = system.graph.begin[i]; k < system.graph.begin[i + 1]; ++k)
        if (system.graph.neighbors[k] < i) lower.emplace_back(i, system.graph.neighbors[k], system.values[k]);
    }
    Eigen::SparseMatrix<double> matrix(count, count);
    matrix.setFromTriplets(lower.begin(), lower.end());
    const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver(matrix);
    Eigen::MatrixX2d right(count, 2);
    right.col(0).setConstant(1);
    right.col(1).setConstant(2);
    x = solver.solve(right);
    benchmark::DoNotOptimize(x.data());
  }
  count_items(state, "unknown", static_cast<double>(count));
  check_sum(state, shape_name(state.range(0)), std::vector<double>(x.data(), x.data() + count));
}
BENCHMARK(solve_system_eigen)->Apply(every_shape);

}  // namespace

}  // namespace meander::bench
