// Queries by distance and side: torus of 25,600 triangles, one thread.
//
// Cost models, and what one core took (CPU time on a shared machine), of points that were moved from the
// surface by up to 0.01 of half the longest side, by up to 0.1, and in the box:
//   nearest       some more nodes and leaves than one path down the tree has: 0.38, 0.68 and 1.3 us a point;
//                 by Embree's point queries (SurfaceLocator) 0.53, 1.7 and 4.3
//   sides_closed  a ball test, or the triangles near one segment: 0.27, 0.17 and 0.12 us
//   winding       nodes and leaves as near as the bound wants them: 5.5, 5.0 and 0.9 us for a bound of 0.5;
//                 2.1, 1.6 and 0.4 us for one of 10
//   sides_open    of nearly closed surfaces, with one triangle in a hundred missing: a step as by the rule
//                 closed, and a new anchor where open edges are near
//   sides_shell   a segment to a point before, and up to 124 to the cells around where none leads
#include <oneapi/tbb/global_control.h>

#include <cmath>
#include <vector>

#include "bench/bench_shapes.h"
#include "kernels/analyse/point_location.h"
#include "kernels/mesh/prepare_mesh.h"
#include "kernels/query/nearest_triangle.h"
#include "kernels/query/surface_sides.h"
#include "kernels/query/winding_number.h"
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
  for ([[maybe_unused]] auto _ : state) found = nearest_triangles(queried_tree(), along_curve(points).points);
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
  const std::vector<double> points = along_curve(query_points(reach_of(state))).points;
  SurfaceLocations found;
  for ([[maybe_unused]] auto _ : state) found = locate_points(surface, points);
  count_items(state, "point", static_cast<double>(points.size() / 3));
  check_sum(state, "torus of 25,600", found.distance);
}
BENCHMARK(nearest_by_embree)->Arg(10)->Arg(100)->Arg(0)->Unit(benchmark::kMillisecond);

void sides_closed(benchmark::State& state) {
  const oneapi::tbb::global_control one(oneapi::tbb::global_control::max_allowed_parallelism, 1);
  const std::vector<double> points = along_curve(query_points(reach_of(state))).points;
  const NearestTriangles found = nearest_triangles(queried_tree(), points);
  const OrientedSurface oriented = orient_outward(queried_torus());
  PointSides sides;
  for ([[maybe_unused]] auto _ : state)
    sides = point_sides(queried_tree(), oriented, SignRule::closed, points, found);
  count_items(state, "point", static_cast<double>(points.size() / 3));
  check_sum(state, "torus of 25,600", sides.winding);
}
BENCHMARK(sides_closed)->Arg(10)->Arg(100)->Arg(0)->Unit(benchmark::kMillisecond);

// The torus with a hundredth of its triangles missing, one by one.
void sides_of_open(benchmark::State& state, SignRule rule) {
  const oneapi::tbb::global_control one(oneapi::tbb::global_control::max_allowed_parallelism, 1);
  PolygonMesh file = test::torus(160, 80);
  std::vector<std::uint32_t> corners, begin{0};
  for (std::uint32_t p = 0; p < file.polygon_count(); ++p) {
    if (p % 100 == 0) continue;
    corners.insert(corners.end(), file.corners.begin() + file.polygon_begin[p],
                   file.corners.begin() + file.polygon_begin[p + 1]);
    begin.push_back(static_cast<std::uint32_t>(corners.size()));
  }
  file.corners = corners;
  file.polygon_begin = begin;
  const PreparedMesh mesh = prepare_mesh(file);
  const TriangleTree tree = build_triangle_tree(mesh.x, mesh.y, mesh.z, mesh.triangles);
  const OrientedSurface oriented = orient_outward(mesh);
  const std::vector<double> points = along_curve(query_points(reach_of(state))).points;
  const NearestTriangles found = nearest_triangles(tree, points);
  PointSides sides;
  for ([[maybe_unused]] auto _ : state) sides = point_sides(tree, oriented, rule, points, found);
  count_items(state, "point", static_cast<double>(points.size() / 3));
  check_sum(state, "torus with holes", sides.inside);
}
void sides_open(benchmark::State& state) { sides_of_open(state, SignRule::winding); }
void sides_shell(benchmark::State& state) { sides_of_open(state, SignRule::shell); }
BENCHMARK(sides_open)->Arg(10)->Arg(100)->Arg(0)->Unit(benchmark::kMillisecond);
BENCHMARK(sides_shell)->Arg(10)->Arg(100)->Arg(0)->Unit(benchmark::kMillisecond);

// The second number: tenths of the bound.
void winding(benchmark::State& state) {
  const oneapi::tbb::global_control one(oneapi::tbb::global_control::max_allowed_parallelism, 1);
  const std::vector<double> points = query_points(reach_of(state));
  const WindingTree tree = build_winding_tree(queried_tree(), {}, 0.1 * static_cast<double>(state.range(1)));
  std::vector<double> found;
  for ([[maybe_unused]] auto _ : state) found = winding_numbers(tree, points);
  count_items(state, "point", static_cast<double>(points.size() / 3));
  check_sum(state, "torus of 25,600", found);
}
BENCHMARK(winding)->ArgsProduct({{10, 100, 0}, {5, 100}})->Unit(benchmark::kMillisecond);

}  // namespace

}  // namespace meander::bench
