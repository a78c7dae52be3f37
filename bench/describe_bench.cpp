// Descriptors of one model's samples.
//
// Cost model, one core (measured on one of two 2.6 GHz EPYC cores, 2048 to 32768 points):
//   distance histogram   per pair, 32 bins: 0.30 ns with AVX2 and AVX-512 (bound by counting), 2.0 scalar, by
//   the
//                        largest distance; 0.46 and 5 by the mean; 1024 bins: 0.4 and 0.55
//   shape functions      50 (D3, D4) to 80 ns (A3) a tuple
//   moments              60 to 140 ns a triangle
//   curved samples       normals 100 to 170 ns a triangle, then 30 ns a point in cache
#include <numbers>
#include <vector>

#include "bench/bench_shapes.h"
#include "kernels/analyse/weighted_distance_histogram.h"
#include "kernels/describe/depth_views.h"
#include "kernels/describe/distance_histogram.h"
#include "kernels/describe/laplacian_spectrum.h"
#include "kernels/describe/oriented_pairs.h"
#include "kernels/describe/shape_functions.h"
#include "kernels/describe/shape_moments.h"
#include "kernels/describe/shell_harmonics.h"
#include "kernels/sample/curved_samples.h"
#include "kernels/solve/intrinsic_delaunay.h"

namespace meander::bench {

namespace {

std::vector<float> points_of(std::int64_t count) {
  std::vector<float> points;
  for (std::int64_t i = 0; i < count; ++i)
    for (std::uint32_t k = 0; k < 3; ++k)
      points.push_back(static_cast<float>(
          random_pair(bench_key(), Stream::point_set, static_cast<std::uint64_t>(i), k).first));
  return points;
}

// Arguments: points, bins, scale, instructions.
void distances(benchmark::State& state) {
  const std::vector<float> points = points_of(state.range(0));
  DistanceHistogramParameters parameters;
  parameters.bins = static_cast<std::uint32_t>(state.range(1));
  parameters.scale = static_cast<HistogramScale>(state.range(2));
  parameters.instructions = static_cast<InstructionSet>(state.range(3));
  if (!is_available(parameters.instructions)) {
    state.SkipWithError("not on this processor");
    return;
  }
  DistanceHistogram histogram;
  for ([[maybe_unused]] auto _ : state) {
    histogram = distance_histogram(points, parameters);
    benchmark::DoNotOptimize(histogram.counts.data());
  }
  count_items(state, "pair", static_cast<double>(histogram.pairs));
  check_sum(state, name_of(parameters.instructions).data(), histogram.counts);
}
BENCHMARK(distances)
    ->ArgsProduct({{2048, 8192, 32768}, {32, 1024}, {0, 1}, {1, 2, 3}})
    ->Unit(benchmark::kMillisecond);

// Arguments: points, sense of the normals, instructions.
void oriented_pairs(benchmark::State& state) {
  const std::vector<float> points = points_of(state.range(0));
  std::vector<float> normals;  // from the middle of the box
  for (std::size_t i = 0; i < points.size(); i += 3) {
    const Vector3 from = {points[i] - 0.5, points[i + 1] - 0.5, points[i + 2] - 0.5};
    const Vector3 normal = (1 / norm(from)) * from;
    for (const double value : {normal.x, normal.y, normal.z}) normals.push_back(static_cast<float>(value));
  }
  OrientedPairParameters parameters;
  parameters.sense = static_cast<NormalSense>(state.range(1));
  parameters.instructions = static_cast<InstructionSet>(state.range(2));
  if (!is_available(parameters.instructions)) {
    state.SkipWithError("not on this processor");
    return;
  }
  OrientedPairHistogram histogram;
  for ([[maybe_unused]] auto _ : state) {
    histogram = oriented_pair_histogram(points, normals, parameters);
    benchmark::DoNotOptimize(histogram.counts.data());
  }
  count_items(state, "pair", static_cast<double>(histogram.pairs));
  check_sum(state, name_of(parameters.instructions).data(), histogram.counts);
}
BENCHMARK(oriented_pairs)
    ->ArgsProduct({{1024, 2048, 8192}, {0, 1}, {1, 2, 3}})
    ->Unit(benchmark::kMillisecond);

void weighted_distances(benchmark::State& state) {
  const std::vector<float> points = points_of(state.range(0));
  const std::vector<double> exact(points.begin(), points.end());
  const std::vector<double> weights(exact.size() / 3, 1.0);
  DistanceHistogram histogram;
  for ([[maybe_unused]] auto _ : state) {
    histogram = weighted_distance_histogram(exact, weights);
    benchmark::DoNotOptimize(histogram.shares.data());
  }
  count_items(state, "pair", static_cast<double>(histogram.pairs));
  check_sum(state, "weighted", histogram.shares);
}
BENCHMARK(weighted_distances)->Arg(8192)->Unit(benchmark::kMillisecond);

void shape_functions(benchmark::State& state) {
  const std::vector<float> points = points_of(2048);
  const auto function = static_cast<ShapeFunction>(state.range(0));
  ShapeHistogram histogram;
  for ([[maybe_unused]] auto _ : state) {
    histogram = shape_function_histogram(points, function, bench_key());
    benchmark::DoNotOptimize(histogram.shares.data());
  }
  count_items(state, function == ShapeFunction::centroid ? "point" : "tuple",
              function == ShapeFunction::centroid ? 2048 : ShapeFunctionParameters().tuples);
  check_sum(state, name_of(function).data(), histogram.shares);
}
BENCHMARK(shape_functions)->DenseRange(0, 3)->Unit(benchmark::kMillisecond);

void harmonics_on_shells(benchmark::State& state) {
  const std::vector<float> points = points_of(state.range(0));
  std::vector<float> values;
  for ([[maybe_unused]] auto _ : state) {
    values = shell_harmonics(points);
    benchmark::DoNotOptimize(values.data());
  }
  count_items(state, "point", static_cast<double>(state.range(0)));
  check_sum(state, "harmonics", values);
}
BENCHMARK(harmonics_on_shells)->Arg(1024)->Arg(8192)->Unit(benchmark::kMillisecond);

// Argument: rows of a square flat torus. 40 eigenvalues, as of `shapedna`.
void eigenvalues(benchmark::State& state) {
  const auto n = static_cast<std::uint32_t>(state.range(0));
  IntrinsicSurface torus;
  torus.vertex_count = n * n;
  const auto square = [&](std::uint32_t i, std::uint32_t j) { return (i % n) + n * (j % n); };
  const double side = 1.0 / n, diagonal = std::numbers::sqrt2 / n;
  for (std::uint32_t j = 0; j < n; ++j)
    for (std::uint32_t i = 0; i < n; ++i) {
      const std::uint32_t h = 6 * square(i, j);
      torus.triangles.insert(torus.triangles.end(), {square(i, j), square(i + 1, j), square(i + 1, j + 1),
                                                     square(i, j), square(i + 1, j + 1), square(i, j + 1)});
      torus.length.insert(torus.length.end(), {side, side, diagonal, diagonal, side, side});
      torus.opposite.insert(torus.opposite.end(),
                            {6 * square(i, j + n - 1) + 4, 6 * square(i + 1, j) + 5, h + 3, h + 2,
                             6 * square(i, j + 1), 6 * square(i + n - 1, j) + 1});
    }
  std::vector<double> values;
  for ([[maybe_unused]] auto _ : state) {
    values = laplacian_spectrum(torus, 40);
    benchmark::DoNotOptimize(values.data());
  }
  count_items(state, "vertex", static_cast<double>(torus.vertex_count));
  check_sum(state, "eigenvalues", values);
}
BENCHMARK(eigenvalues)->Arg(32)->Arg(141)->Unit(benchmark::kMillisecond);

void moments(benchmark::State& state) {
  const PreparedMesh& mesh = prepared_shape(state.range(0)).surface;
  std::vector<double> result;
  for ([[maybe_unused]] auto _ : state) {
    const auto basics = shape_basics(shape_moments(mesh.x, mesh.y, mesh.z, mesh.triangles));
    result.assign(basics.begin(), basics.end());
    benchmark::DoNotOptimize(result.data());
  }
  count_items(state, "triangle", static_cast<double>(mesh.triangle_count()));
  check_sum(state, shape_name(state.range(0)), result);
}
BENCHMARK(moments)->Apply(every_shape);

void depth_images(benchmark::State& state) {
  const PreparedMesh& mesh = prepared_shape(state.range(0)).surface;
  std::vector<float> values;
  for ([[maybe_unused]] auto _ : state) {
    values = depth_views(mesh);
    benchmark::DoNotOptimize(values.data());
  }
  count_items(state, "triangle", static_cast<double>(mesh.triangle_count()));
  check_sum(state, shape_name(state.range(0)), values);
}
BENCHMARK(depth_images)->Apply(every_shape);

void normals_split_at_creases(benchmark::State& state) {
  const PreparedMesh& mesh = prepared_shape(state.range(0)).surface;
  std::vector<double> normals;
  for ([[maybe_unused]] auto _ : state) {
    normals = crease_normals(mesh.x, mesh.y, mesh.z, mesh.triangles);
    benchmark::DoNotOptimize(normals.data());
  }
  count_items(state, "triangle", static_cast<double>(mesh.triangle_count()));
  check_sum(state, shape_name(state.range(0)), normals);
}
BENCHMARK(normals_split_at_creases)->Apply(every_shape);

void lift(benchmark::State& state) {
  const PreparedMesh& mesh = prepared_shape(state.range(0)).surface;
  const auto normals = crease_normals(mesh.x, mesh.y, mesh.z, mesh.triangles);
  std::vector<std::uint32_t> triangle(1 << 16);
  std::vector<float> weights(2 * triangle.size());
  for (std::size_t i = 0; i < triangle.size(); ++i) {
    const UnitPair u = random_pair(bench_key(), Stream::point_set, i);
    triangle[i] = static_cast<std::uint32_t>(u.first * static_cast<double>(mesh.triangle_count()));
    weights[2 * i] = static_cast<float>(0.5 * u.second);
    weights[2 * i + 1] = 0.25f;
  }
  std::vector<double> points;
  for ([[maybe_unused]] auto _ : state) {
    points = lift_samples(mesh.x, mesh.y, mesh.z, mesh.triangles, normals, triangle, weights);
    benchmark::DoNotOptimize(points.data());
  }
  count_items(state, "point", static_cast<double>(triangle.size()));
  check_sum(state, shape_name(state.range(0)), points);
}
BENCHMARK(lift)->Apply(every_shape);

}  // namespace

}  // namespace meander::bench
