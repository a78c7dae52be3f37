// Spectra, difference maps, spacing and distances between meshes.
//
// Cost models, and what one core of a 2.6 GHz EPYC took (SSE4.2 code):
//   add_periodogram          4 (R + 1)^2 N multiply-adds of 0.12 ns, plus 2 (R + 1) N rotations
//   add_differences          N log N for the tree + pairs x (one search step + 2 x 7 weights + 49
//   multiply-adds);
//                            pairs = N pi r^2 / 2 with r = sqrt(2) (range + 3 kernels), in units of the
//                            spacing: 55 N with the default map, 5 us a sample
//   add_surface_differences  the same with two deposits and three arc sines a pair: 14 us a sample
//   nearest_distances        N log N: tree and queries, 0.35 (N = 10^4) to 0.6 us (10^6) a point
//   locate_points            log T steps of Embree and some tens of exact triangle distances: 0.4 to 0.7 us a
//                            point on the surface; building takes 0.6 us a triangle
//   mesh_distance            two hierarchies, (samples + vertices) queries each way: 1 us a sample
#include <cmath>
#include <numbers>
#include <vector>

#include "bench/bench_shapes.h"
#include "kernels/analyse/differential_domain.h"
#include "kernels/analyse/mesh_distance.h"
#include "kernels/analyse/point_location.h"
#include "kernels/analyse/spacing.h"
#include "kernels/analyse/spectrum.h"
#include "kernels/core/random.h"

namespace meander::bench {

namespace {

// Uniform numbers in [0, 1).
std::vector<double> uniform_numbers(std::size_t count, std::uint64_t seed) {
  const RandomKey key = make_random_key(seed, {});
  std::vector<double> numbers(count);
  for (std::size_t i = 0; i < count; ++i) numbers[i] = random_pair(key, Stream::sequence, i).first;
  return numbers;
}

void periodogram(benchmark::State& state) {
  const auto samples = static_cast<std::size_t>(state.range(0));
  const auto radius = static_cast<std::uint32_t>(state.range(1));
  const std::vector<double> x = uniform_numbers(samples, 1), y = uniform_numbers(samples, 2);
  PowerSpectrum spectrum;
  for ([[maybe_unused]] auto _ : state) {
    spectrum = make_power_spectrum(radius);
    add_periodogram(spectrum, x, y);
    benchmark::DoNotOptimize(spectrum.sum.data());
  }
  count_items(state, "term", 4.0 * (radius + 1) * (radius + 1) * static_cast<double>(samples));
  check_sum(state, "random points", spectrum.sum);
}
BENCHMARK(periodogram)
    ->Args({1024, 64})
    ->Args({4096, 128})
    ->Args({16384, 256})
    ->Unit(benchmark::kMillisecond);

void planar_differences(benchmark::State& state) {
  const auto samples = static_cast<std::size_t>(state.range(0));
  const std::vector<double> x = uniform_numbers(samples, 1), y = uniform_numbers(samples, 2);
  DifferenceMap map;
  for ([[maybe_unused]] auto _ : state) {
    map = make_difference_map();
    add_differences(map, x, y, 1 / std::sqrt(static_cast<double>(samples)), {1, 1});
    benchmark::DoNotOptimize(map.sum.data());
  }
  count_items(state, "sample", static_cast<double>(samples));
  check_sum(state, "random points", map.sum);
}
BENCHMARK(planar_differences)->Arg(2500)->Arg(10000)->Arg(100000)->Unit(benchmark::kMillisecond);

std::vector<double> sphere_points(std::size_t samples) {
  const std::vector<double> u = uniform_numbers(samples, 1), v = uniform_numbers(samples, 2);
  std::vector<double> points;
  for (std::size_t i = 0; i < samples; ++i) {
    const double z = 2 * u[i] - 1, r = std::sqrt(1 - z * z), angle = 2 * std::numbers::pi * v[i];
    points.insert(points.end(), {r * std::cos(angle), r * std::sin(angle), z});
  }
  return points;
}

void surface_differences(benchmark::State& state) {
  const auto samples = static_cast<std::size_t>(state.range(0));
  const std::vector<double> points = sphere_points(samples);
  const std::vector<double> spacing(samples, std::sqrt(4 * std::numbers::pi / static_cast<double>(samples)));
  DifferenceMap map;
  for ([[maybe_unused]] auto _ : state) {
    map = make_difference_map();
    add_surface_differences(map, points, points, spacing);
    benchmark::DoNotOptimize(map.sum.data());
  }
  count_items(state, "sample", static_cast<double>(samples));
  check_sum(state, "random points on the sphere", map.sum);
}
BENCHMARK(surface_differences)->Arg(3000)->Arg(30000)->Unit(benchmark::kMillisecond);

void nearest_in_plane(benchmark::State& state) {
  const auto samples = static_cast<std::size_t>(state.range(0));
  const std::vector<double> x = uniform_numbers(samples, 1), y = uniform_numbers(samples, 2);
  std::vector<double> distances;
  for ([[maybe_unused]] auto _ : state) {
    distances = nearest_distances(x, y, 1, 1);
    benchmark::DoNotOptimize(distances.data());
  }
  count_items(state, "sample", static_cast<double>(samples));
  check_sum(state, "random points", distances);
}
BENCHMARK(nearest_in_plane)->Arg(10000)->Arg(1000000)->Unit(benchmark::kMillisecond);

void nearest_in_space(benchmark::State& state) {
  const auto samples = static_cast<std::size_t>(state.range(0));
  const std::vector<double> points = sphere_points(samples);
  std::vector<double> distances;
  for ([[maybe_unused]] auto _ : state) {
    distances = nearest_distances(points);
    benchmark::DoNotOptimize(distances.data());
  }
  count_items(state, "sample", static_cast<double>(samples));
  check_sum(state, "random points on the sphere", distances);
}
BENCHMARK(nearest_in_space)->Arg(10000)->Arg(1000000)->Unit(benchmark::kMillisecond);

TriangleSpans spans_of(std::int64_t number) {
  const PreparedMesh& mesh = prepared_shape(number).surface;
  return {mesh.x, mesh.y, mesh.z, mesh.triangles};
}

const EmbreeDevice& bench_device() {
  static const EmbreeDevice device;
  return device;
}

void build_locator(benchmark::State& state) {
  const TriangleSpans mesh = spans_of(state.range(0));
  std::vector<double> distance(1);
  for ([[maybe_unused]] auto _ : state) {
    const SurfaceLocator surface(bench_device(), mesh.x, mesh.y, mesh.z, mesh.triangles);
    distance[0] = surface.nearest({2, 3, 4}).distance;
    benchmark::DoNotOptimize(distance.data());
  }
  count_items(state, "face", static_cast<double>(mesh.triangles.size()) / 3);
  check_sum(state, shape_name(state.range(0)), distance);
}
BENCHMARK(build_locator)->Apply(every_shape);

// Points on the surface itself.
void locate_near(benchmark::State& state) {
  const TriangleSpans mesh = spans_of(state.range(0));
  const SurfaceLocator surface(bench_device(), mesh.x, mesh.y, mesh.z, mesh.triangles);
  const std::vector<double> points = area_samples(mesh, 20000, 1);
  SurfaceLocations found;
  for ([[maybe_unused]] auto _ : state) found = locate_points(surface, points);
  count_items(state, "query", 20000);
  check_sum(state, shape_name(state.range(0)), found.triangle);
}
BENCHMARK(locate_near)->Apply(every_shape);

void draw_area_samples(benchmark::State& state) {
  const TriangleSpans mesh = spans_of(state.range(0));
  std::vector<double> points;
  for ([[maybe_unused]] auto _ : state) points = area_samples(mesh, 100000, 1);
  count_items(state, "sample", 100000);
  check_sum(state, shape_name(state.range(0)), points);
}
BENCHMARK(draw_area_samples)->Apply(every_shape);

// Between the two spheres, 100,000 samples each way.
void sphere_distance(benchmark::State& state) {
  const TriangleSpans coarse = spans_of(0), fine = spans_of(1);
  MeshDistanceParameters parameters;
  parameters.samples = 100000;
  std::vector<double> mean(2);
  for ([[maybe_unused]] auto _ : state) {
    const MeshDistance found = mesh_distance(bench_device(), coarse, fine, parameters);
    mean = {found.forward.mean, found.backward.mean};
  }
  count_items(state, "sample", 200000);
  check_sum(state, "both spheres", mean);
}
BENCHMARK(sphere_distance)->Unit(benchmark::kMillisecond);

}  // namespace

}  // namespace meander::bench
