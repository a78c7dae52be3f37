// Queries by distance: torus of 25,600 triangles, one thread.
//
// Cost models: nearest triangles take some nodes and leaves more than one path down the tree: 0.5 us a point
// near the surface and 1.2 us in its box; Embree's point queries (SurfaceLocator) take 0.6 and 3.
#include <oneapi/tbb/global_control.h>

#include <cmath>
#include <vector>

#include "bench/bench_shapes.h"
#include "kernels/analyse/point_location.h"
#include "kernels/mesh/prepare_mesh.h"
#include "kernels/query/nearest_triangle.h"
#include "support/test_meshes.h"

namespace meander::bench {

namespace {

const PreparedMesh& queried_torus() {
  static const PreparedMesh mesh = prepare_mesh(test::torus(160, 80));
  return mesh;
}
const TriangleTree& queried_tree() {
  static const TriangleTree tree =
      build_triangle_tree(queried_torus().x, queried_torus().y, queried_torus().z, queried_torus().triangles);
  return tree;
}

// Points moved from the surface by up to `reach` along each axis, or in the box where it is 0.
std::vector<double> query_points(double reach) {
  constexpr std::size_t count = 100'000;
  const PreparedMesh& mesh = queried_torus();
  std::vector<double> points;
  for (std::size_t i = 0; i < count; ++i) {
    const UnitPair u = random_pair(bench_key(), Stream::sequence, i),
                   v = random_pair(bench_key(), Stream::sequence, i, 1);
    const Vector3 in_box{2 * u.first - 1, 2 * u.second - 1, 2 * v.first - 1};
    const Vector3 on =
        mesh.centroid(static_cast<std::size_t>(v.second * static_cast<double>(mesh.triangle_count())));
    const Vector3 p = reach > 0 ? on + reach * in_box : in_box;
    points.insert(points.end(), {p.x, p.y, p.z});
  }
  return points;
}

// Thousandths of half the longest side.
double reach_of(const benchmark::State& state) { return 0.001 * static_cast<double>(state.range(0)); }

void triangle_tree(benchmark::State& state) {
  const PreparedMesh& mesh = queried_torus();
  TriangleTree tree;
  for ([[maybe_unused]] auto _ : state) tree = build_triangle_tree(mesh.x, mesh.y, mesh.z, mesh.triangles);
  count_items(state, "face", static_cast<double>(mesh.triangle_count()));
  check_sum(state, "torus of 25,600", tree.order);
}
BENCHMARK(triangle_tree)->Unit(benchmark::kMillisecond);

void nearest(benchmark::State& state) {
  const oneapi::tbb::global_control one(oneapi::tbb::global_control::max_allowed_parallelism, 1);
  const std::vector<double> points = query_points(reach_of(state));
  NearestTriangles found;
  for ([[maybe_unused]] auto _ : state) found = nearest_triangles(queried_tree(), points);
  count_items(state, "point", static_cast<double>(points.size() / 3));
  check_sum(state, "torus of 25,600", found.distance);
}
BENCHMARK(nearest)->Arg(10)->Arg(100)->Arg(0)->Unit(benchmark::kMillisecond);

// Embree's point queries, points in the same order.
void nearest_by_embree(benchmark::State& state) {
  const oneapi::tbb::global_control one(oneapi::tbb::global_control::max_allowed_parallelism, 1);
  const PreparedMesh& mesh = queried_torus();
  static const EmbreeDevice device;
  static const SurfaceLocator surface(device, mesh.x, mesh.y, mesh.z, mesh.triangles);
  const std::vector<double> points = query_points(reach_of(state));
  std::vector<double> ordered;
  for (const std::size_t i : order_along_curve(points))
    ordered.insert(ordered.end(), {points[3 * i], points[3 * i + 1], points[3 * i + 2]});
  SurfaceLocations found;
  for ([[maybe_unused]] auto _ : state) found = locate_points(surface, ordered);
  count_items(state, "point", static_cast<double>(points.size() / 3));
  check_sum(state, "torus of 25,600", found.distance);
}
BENCHMARK(nearest_by_embree)->Arg(10)->Arg(100)->Arg(0)->Unit(benchmark::kMillisecond);

}  // namespace

}  // namespace meander::bench
