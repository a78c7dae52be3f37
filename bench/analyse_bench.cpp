// Measures and pictures.
#include <vector>

#include "bench/bench_shapes.h"
#include "kernels/analyse/box_discrepancy.h"
#include "kernels/render/splat_picture.h"

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

}  // namespace

}  // namespace meander::bench
