// Geodesic distances.
//
// Cost models, and what one core took (CPU time on a shared machine, SSE4.2 code), torus of 35,000 vertices:
//   HeatGeodesics    two factors (three with a boundary) of O(V^1.5): 160 ms, 4.6 us a vertex; 140 entries a
//                    vertex in both together
//   to_vertices      each entry of both factors twice, a multiply-add a source: 10.5 ms a source alone, 8.1,
//                    6.2, 3.9 and 2.6 in batches of 2, 4, 8 and 16
//   exact_geodesics  windows grow faster than vertices: 6, 18 and 52 us a vertex for 360, 1,440 and 5,760
#include <cstdint>
#include <vector>

#include "bench/bench_shapes.h"
#include "kernels/analyse/exact_geodesics.h"
#include "kernels/describe/geodesic_histogram.h"
#include "kernels/mesh/prepare_mesh.h"
#include "support/test_meshes.h"

namespace meander::bench {

namespace {

// A torus of 35,000 vertices, the goal's size.
const PreparedMesh& large_torus() {
  static const PreparedMesh mesh = prepare_mesh(test::torus(250, 140));
  return mesh;
}

PointsOnMeshArrays spread_points(const PreparedMesh& mesh, std::size_t count) {
  PointsOnMeshArrays points;
  for (std::size_t i = 0; i < count; ++i) {
    points.triangle.push_back(static_cast<std::uint32_t>(i * mesh.triangle_count() / count));
    points.barycentric.insert(points.barycentric.end(), {0.25, 0.25});
  }
  return points;
}

void factorize_heat(benchmark::State& state) {
  const PreparedMesh& mesh = large_torus();
  std::vector<std::uint64_t> entries(1);
  for ([[maybe_unused]] auto _ : state) entries[0] = HeatGeodesics(mesh).factor_entries();
  count_items(state, "vertex", static_cast<double>(mesh.vertex_count()));
  check_sum(state, "torus of 35,000", entries);
}
BENCHMARK(factorize_heat)->Unit(benchmark::kMillisecond);

void heat_sources(benchmark::State& state) {
  const PreparedMesh& mesh = large_torus();
  static const HeatGeodesics geodesics(mesh);
  const auto batch = static_cast<std::size_t>(state.range(0));  // one batch: one thread
  const PointsOnMeshArrays sources = spread_points(mesh, batch);
  std::vector<double> distance(batch * mesh.vertex_count());
  for ([[maybe_unused]] auto _ : state) geodesics.to_vertices(sources, distance);
  count_items(state, "source", static_cast<double>(batch));
  check_sum(state, "torus of 35,000", distance);
}
BENCHMARK(heat_sources)->Arg(1)->Arg(2)->Arg(4)->Arg(8)->Arg(16)->Unit(benchmark::kMillisecond);

// 64 sources to 2048 samples, factors not counted.
void histogram_of_geodesics(benchmark::State& state) {
  const PreparedMesh& mesh = large_torus();
  static const HeatGeodesics geodesics(mesh);
  const PointsOnMeshArrays samples = spread_points(mesh, 2048);
  GeodesicHistogram histogram;
  for ([[maybe_unused]] auto _ : state) histogram = geodesic_histogram(geodesics, samples);
  count_items(state, "source", 64);
  check_sum(state, "torus of 35,000", histogram.share);
}
BENCHMARK(histogram_of_geodesics)->Unit(benchmark::kMillisecond)->UseRealTime();

void exact_source(benchmark::State& state) {
  const auto across = static_cast<std::uint32_t>(state.range(0));
  const PreparedMesh mesh = prepare_mesh(test::torus(5 * across / 2, across));
  const PointsOnMeshArrays source = spread_points(mesh, 1);
  std::vector<double> distance(mesh.vertex_count());
  for ([[maybe_unused]] auto _ : state) exact_geodesics(mesh, source, distance);
  count_items(state, "vertex", static_cast<double>(mesh.vertex_count()));
  check_sum(state, "torus", distance);
}
BENCHMARK(exact_source)->Arg(12)->Arg(24)->Arg(48)->Unit(benchmark::kMillisecond);

}  // namespace

}  // namespace meander::bench
