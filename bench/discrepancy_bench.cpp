// Point sets to compare with, and their discrepancies.
//
// Cost model, n points, one core (measured on one of two 2.6 GHz EPYC cores):
//   planar_points   15 ns (random, jittered), 60 (Halton), 110 (curves), 210 (scrambled Sobol) a point;
//   poisson_disk
//                   22 us a point at 2^14, n log n; lloyd 0.7 us a point and iteration
//   point index     50 ns a point: a Hilbert key, a radix sort, boxes bottom up
//   one shape       the nodes and leaves across its boundary: c sqrt(n), c = 0.09 us for triangles, 0.07 for
//   rotated
//                   and 0.04 for anchored boxes, 0.11 on the sphere: 2^14 shapes at n = 1.5 million take 1 -
//                   2 s
//   star, exact     0.28 ns x n^2: each column looks at half of the heights before it, twice, and moves a
//   quarter star, search    2^14 shapes as above and about 4 passes of 2 ns a point for each of 32 climbs
//   quarter circle  one sort of pi / 4 of the points
//   caps            7 ns a point and axis: a pass that counts, a second one only where the maximum may rise
#include <vector>

#include "bench/bench_shapes.h"
#include "kernels/analyse/discrepancy_plane.h"
#include "kernels/analyse/discrepancy_sphere.h"
#include "kernels/analyse/discrepancy_star.h"
#include "kernels/pointset/planar_points.h"
#include "kernels/pointset/sphere_points.h"

namespace meander::bench {

namespace {

constexpr std::int64_t few = 12288, many = 1572864;  // of the survey's counts

ShapeParameters shapes(std::uint32_t count) {
  ShapeParameters parameters;
  parameters.shapes = count;
  parameters.stable_rise = 0;  // always so many
  return parameters;
}

PlanarPoints points_of(std::int64_t count) {
  return planar_points(PlanarMethod::hilbert_stratified, static_cast<std::uint32_t>(count), 1);
}

void make_points(benchmark::State& state, PlanarMethod method) {
  const auto count = static_cast<std::uint32_t>(state.range(0));
  PlanarPoints points;
  for ([[maybe_unused]] auto _ : state) {
    points = planar_points(method, count, 1);
    benchmark::DoNotOptimize(points.x.data());
  }
  count_items(state, "point", count);
  check_sum(state, name_of(method).data(), points.x);
}
BENCHMARK_CAPTURE(make_points, random, PlanarMethod::random)->Arg(many)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(make_points, jittered, PlanarMethod::jittered)->Arg(many)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(make_points, halton, PlanarMethod::halton)->Arg(many)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(make_points, sobol_owen, PlanarMethod::sobol_owen)
    ->Arg(many)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(make_points, hilbert, PlanarMethod::hilbert_stratified)
    ->Arg(many)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(make_points, poisson_disk, PlanarMethod::poisson_disk)
    ->Arg(1 << 14)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(make_points, lloyd, PlanarMethod::lloyd)->Arg(1 << 14)->Unit(benchmark::kMillisecond);

void index_points(benchmark::State& state) {
  const PlanarPoints points = points_of(state.range(0));
  PointIndex<2> index;
  for ([[maybe_unused]] auto _ : state) {
    index = build_point_index(points.x, points.y);
    benchmark::DoNotOptimize(index.levels.data());
  }
  count_items(state, "point", static_cast<double>(state.range(0)));
  check_sum(state, "index", index.at[0]);
}
BENCHMARK(index_points)->Arg(few)->Arg(many)->Unit(benchmark::kMillisecond);

// measure(index, parameters) over 2048 shapes.
template <class Measure>
void measure_shapes(benchmark::State& state, const char* name, const Measure& measure) {
  const PlanarPoints points = points_of(state.range(0));
  const PointIndex<2> index = build_point_index(points.x, points.y);
  const ShapeParameters parameters = shapes(2048);
  std::vector<double> result(1);
  for ([[maybe_unused]] auto _ : state) {
    result[0] = measure(index, parameters).discrepancy;
    benchmark::DoNotOptimize(result.data());
  }
  count_items(state, "shape", parameters.shapes);
  check_sum(state, name, result);
}
void triangles(benchmark::State& state) {
  measure_shapes(state, "triangles",
                 [](const auto& index, const auto& p) { return triangle_discrepancy(index, p); });
}
BENCHMARK(triangles)->Arg(few)->Arg(many)->Unit(benchmark::kMillisecond);

void rotated_rectangles(benchmark::State& state) {
  measure_shapes(state, "rotated boxes",
                 [](const auto& index, const auto& p) { return rotated_box_discrepancy(index, p); });
}
BENCHMARK(rotated_rectangles)->Arg(few)->Arg(many)->Unit(benchmark::kMillisecond);

void density_boxes(benchmark::State& state) {
  measure_shapes(state, "density boxes", [](const auto& index, const auto& p) {
    return density_box_discrepancy(index, PlanarDensity::waves, p);
  });
}
BENCHMARK(density_boxes)->Arg(few)->Arg(many)->Unit(benchmark::kMillisecond);

// measure(x, y) of one set, time per point.
template <class Measure>
void measure_set(benchmark::State& state, const char* name, const Measure& measure) {
  const PlanarPoints points = points_of(state.range(0));
  std::vector<double> result(1);
  for ([[maybe_unused]] auto _ : state) {
    result[0] = measure(points.x, points.y);
    benchmark::DoNotOptimize(result.data());
  }
  count_items(state, "point", static_cast<double>(state.range(0)));
  check_sum(state, name, result);
}
void star_exact(benchmark::State& state) {
  measure_set(state, "star", [](const auto& x, const auto& y) { return star_discrepancy_exact(x, y); });
}
BENCHMARK(star_exact)->Arg(1024)->Arg(4096)->Arg(1 << 14)->Unit(benchmark::kMillisecond);

void star_search(benchmark::State& state) {
  measure_set(state, "star", [](const auto& x, const auto& y) { return star_discrepancy_search(x, y); });
}
BENCHMARK(star_search)->Arg(1 << 14)->Arg(many)->Unit(benchmark::kMillisecond);

void quarter_circles(benchmark::State& state) {
  measure_set(state, "quarter circles",
              [](const auto& x, const auto& y) { return quarter_circle_discrepancy(x, y); });
}
BENCHMARK(quarter_circles)->Arg(few)->Arg(many)->Unit(benchmark::kMillisecond);

void caps(benchmark::State& state) {
  const SpherePoints points =
      sphere_points(SphereMethod::hilbert_stratified, static_cast<std::uint32_t>(state.range(0)), 1);
  const ShapeParameters parameters = shapes(20);
  std::vector<double> result(1);
  for ([[maybe_unused]] auto _ : state) {
    result[0] = cap_discrepancy(points.x, points.y, points.z, parameters).discrepancy;
    benchmark::DoNotOptimize(result.data());
  }
  count_items(state, "axis", parameters.shapes);
  check_sum(state, "caps", result);
}
BENCHMARK(caps)->Arg(few)->Arg(many)->Unit(benchmark::kMillisecond);

void spherical_triangles(benchmark::State& state) {
  const SpherePoints points =
      sphere_points(SphereMethod::hilbert_stratified, static_cast<std::uint32_t>(state.range(0)), 1);
  const PointIndex<3> index = build_point_index(points.x, points.y, points.z);
  const ShapeParameters parameters = shapes(2048);
  std::vector<double> result(1);
  for ([[maybe_unused]] auto _ : state) {
    result[0] = spherical_triangle_discrepancy(index, parameters).discrepancy;
    benchmark::DoNotOptimize(result.data());
  }
  count_items(state, "shape", parameters.shapes);
  check_sum(state, "spherical triangles", result);
}
BENCHMARK(spherical_triangles)->Arg(few)->Arg(many)->Unit(benchmark::kMillisecond);

}  // namespace

}  // namespace meander::bench
