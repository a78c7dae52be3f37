// Measures and pictures.
#include <cmath>
#include <vector>

#include "bench/bench_shapes.h"
#include "kernels/analyse/box_discrepancy.h"
#include "kernels/analyse/box_limit.h"
#include "kernels/analyse/coverage.h"
#include "kernels/render/oriented_splats.h"
#include "kernels/render/splat_picture.h"
#include "kernels/render/view_detail.h"

namespace meander::bench {

namespace {

const std::vector<RotatedBox>& test_boxes(std::int64_t number) {
  static std::vector<std::vector<RotatedBox>> boxes(shape_count);
  std::vector<RotatedBox>& mine = boxes.at(static_cast<std::size_t>(number));
  const PreparedMesh& mesh = prepared_shape(number).surface;
  if (mine.empty()) mine = random_boxes(mesh.x, mesh.y, mesh.z, mesh.triangles, BoxParameters{});
  return mine;
}

Samples samples_of(std::int64_t number, std::uint32_t samples) {
  Model model = prepared_shape(number);
  run_stages(placing_stages(method_parameters("direct", samples), nullptr), model);
  return std::move(model.row.samples);
}

void clip_area(benchmark::State& state) {
  const PreparedMesh& mesh = prepared_shape(state.range(0)).surface;
  const std::vector<RotatedBox>& boxes = test_boxes(state.range(0));
  std::vector<double> area(1);
  std::size_t next = 0;
  for ([[maybe_unused]] auto _ : state)
    benchmark::DoNotOptimize(
        area_in_box(mesh.x, mesh.y, mesh.z, mesh.triangles, boxes[next++ % boxes.size()]));
  area[0] = area_in_box(mesh.x, mesh.y, mesh.z, mesh.triangles, boxes[0]);
  count_items(state, "face", static_cast<double>(mesh.triangle_count()));
  check_sum(state, shape_name(state.range(0)), area);
}
BENCHMARK(clip_area)->Apply(every_shape);

void draw_boxes(benchmark::State& state) {
  const PreparedMesh& mesh = prepared_shape(state.range(0)).surface;
  const BoxParameters parameters;
  std::vector<double> shares;
  for ([[maybe_unused]] auto _ : state) {
    shares.clear();
    for (const RotatedBox& box : random_boxes(mesh.x, mesh.y, mesh.z, mesh.triangles, parameters))
      shares.push_back(box.share);
  }
  count_items(state, "box", parameters.boxes);
  check_sum(state, shape_name(state.range(0)), shares);
}
BENCHMARK(draw_boxes)->Apply(every_shape);

void box_boundaries(benchmark::State& state) {
  const PreparedMesh& mesh = prepared_shape(state.range(0)).surface;
  const std::vector<RotatedBox>& boxes = test_boxes(state.range(0));
  std::vector<double> lengths;
  for ([[maybe_unused]] auto _ : state)
    lengths = boundary_lengths(mesh.x, mesh.y, mesh.z, mesh.triangles, boxes);
  count_items(state, "box", static_cast<double>(boxes.size()));
  check_sum(state, shape_name(state.range(0)), lengths);
}
BENCHMARK(box_boundaries)->Apply(every_shape);

void coverage(benchmark::State& state) {
  const PreparedMesh& mesh = prepared_shape(2).surface;
  const auto samples = static_cast<std::uint32_t>(state.range(0));
  const Samples set = samples_of(2, samples);
  const std::vector<double> points(set.points.begin(), set.points.end());
  std::vector<double> found(2);
  for ([[maybe_unused]] auto _ : state) {
    const Coverage made = coverage_of({mesh.x, mesh.y, mesh.z, mesh.triangles}, points, 1);
    found = {made.radius, made.mean};
  }
  count_items(state, "sample", samples);
  check_sum(state, shape_name(2), found);
}
BENCHMARK(coverage)->Arg(2048)->Arg(100000)->Unit(benchmark::kMillisecond);

void count_in_boxes(benchmark::State& state) {
  const auto samples = static_cast<std::uint32_t>(state.range(0));
  const Samples set = samples_of(2, samples);
  const std::vector<double> points(set.points.begin(), set.points.end());
  const std::vector<RotatedBox>& boxes = test_boxes(2);
  std::vector<double> ratio(1);
  for ([[maybe_unused]] auto _ : state) {
    ratio[0] = box_error_ratio(boxes, points);
    benchmark::DoNotOptimize(ratio.data());
  }
  count_items(state, "sample", samples);
  check_sum(state, shape_name(2), ratio);
}
BENCHMARK(count_in_boxes)->Arg(2048)->Arg(100000)->Unit(benchmark::kMillisecond);

void picture(benchmark::State& state) {
  const auto samples = static_cast<std::uint32_t>(state.range(0));
  const Samples set = samples_of(2, samples);
  RgbImage image;
  for ([[maybe_unused]] auto _ : state) {
    image = splat_picture(set.points, set.normals, 15.8);  // the torus: 4 pi^2 x 0.4
    benchmark::DoNotOptimize(image.pixels.data());
  }
  count_items(state, "sample", samples);
  check_sum(state, shape_name(2), image.pixels);
}
BENCHMARK(picture)->Arg(2048)->Arg(100000)->Unit(benchmark::kMillisecond);

// Splats of the torus from above in a picture of 1920 x 1080: all of them, blended and lit.
void splats(benchmark::State& state) {
  const auto count = static_cast<std::uint32_t>(state.range(0));
  const Samples set = samples_of(2, count);
  const double radius = std::sqrt(3 * 15.8 / (3.14159 * count));
  const std::vector<float> half_axes(2 * std::size_t{count}, static_cast<float>(radius));
  constexpr SrgbColor color = {232, 196, 158};
  const OrientedSplats drawn{set.points, set.normals, {}, half_axes, {&color, 1}};
  const SplatView view = fitted_view(set.points, {0.3, 0.2, 1}, {0, 1, 0}, 1920, 1080);
  RgbImage image;
  for ([[maybe_unused]] auto _ : state) {
    image = draw_splats(drawn, view).image;
    benchmark::DoNotOptimize(image.pixels.data());
  }
  count_items(state, "splat", count);
  check_sum(state, shape_name(2), image.pixels);
}
BENCHMARK(splats)->Arg(20000)->Arg(200000)->Unit(benchmark::kMillisecond);

// One view of so many curve vertices on a sphere: weights, sums, and 20,000 of them kept.
void view_of_samples(benchmark::State& state) {
  const auto count = static_cast<std::size_t>(state.range(0));
  std::vector<float> x(count), y(count), z(count);
  const std::vector<float> area(count, static_cast<float>(12.566 / static_cast<double>(count)));
  for (std::size_t i = 0; i < count; ++i) {
    // A Kronecker sequence over the sphere: every prefix is spread.
    const double at = static_cast<double>(i) + 0.5, height = 2 * std::fmod(at * 0.7548776662466927, 1.0) - 1,
                 ring = std::sqrt(1 - height * height), angle = 6.283185307179586 * at * 0.5698402909980532;
    x[i] = static_cast<float>(ring * std::cos(angle));
    y[i] = static_cast<float>(ring * std::sin(angle));
    z[i] = static_cast<float>(height);
  }
  ViewDetailParameters parameters;
  parameters.samples_per_area = 20000 / 3.14159;
  ViewDetail detail;
  for ([[maybe_unused]] auto _ : state) {
    detail = view_detail({x, y, z, area}, {0.3, 0.2, 1}, parameters);
    benchmark::DoNotOptimize(detail.kept.data());
  }
  state.counters["kept"] = static_cast<double>(detail.kept.size());
  count_items(state, "vertex", static_cast<double>(count));
  check_sum(state, "sphere", detail.kept);
}
BENCHMARK(view_of_samples)->Arg(1000000)->Unit(benchmark::kMillisecond);

}  // namespace

}  // namespace meander::bench
