// Pictures in strokes, 1,920 x 1,080, with light.
//
// Cost model, one core: a pixel under a stroke 10 to 20 ns (texture, mixing), a stroke 1 us (placement, two
// random blocks, sorting), a pixel of the picture 150 ns (paper, relief, light, two depth buffers).
#include <cmath>
#include <numbers>
#include <vector>

#include "bench/bench_shapes.h"
#include "kernels/render/stroke_picture.h"

namespace meander::bench {

namespace {

// A wavy sheet that faces the eye: all samples are seen.
struct Sheet {
  explicit Sheet(std::size_t samples) {
    constexpr std::uint32_t side = 200;
    for (std::uint32_t j = 0; j <= side; ++j)
      for (std::uint32_t i = 0; i <= side; ++i) {
        const Vector3 p = at(i / double{side}, j / double{side});
        positions.insert(positions.end(), {p.x, p.y, p.z});
      }
    for (std::uint32_t j = 0; j < side; ++j)
      for (std::uint32_t i = 0; i < side; ++i) {
        const std::uint32_t a = j * (side + 1) + i, b = a + 1, c = a + side + 1, d = c + 1;
        faces.insert(faces.end(), {a, b, d, a, d, c});
      }
    for (std::size_t i = 0; i < samples; ++i) {
      const double n = static_cast<double>(i), u = std::fmod(0.5 + 0.7548776662466927 * n, 1.0),
                   v = std::fmod(0.5 + 0.5698402909980532 * n, 1.0);
      const Vector3 p = at(u, v);
      points.insert(points.end(), {p.x, p.y, p.z});
      const double slope = 0.06 * 4 * std::numbers::pi * std::cos(4 * std::numbers::pi * u) / 1.6;
      const double length = std::sqrt(1 + slope * slope);
      for (const double k : {-slope / length, 0.0, 1 / length}) normals.push_back(static_cast<float>(k));
      for (const double k : {0.0, 1.0, 0.0}) directions.push_back(static_cast<float>(k));
      spacings.push_back(static_cast<float>(std::exp(std::sin(9 * u + 5 * v))));
      spacings.push_back(1);
    }
  }
  static Vector3 at(double u, double v) {
    return {1.6 * u, 0.9 * v, 0.06 * std::sin(4 * std::numbers::pi * u)};
  }
  StrokeModel spans() const { return {positions, faces, points, normals, directions, spacings}; }

  std::vector<double> positions, points;
  std::vector<std::uint32_t> faces;
  std::vector<float> normals, directions, spacings;
};

// Arguments: samples, medium.
void strokes(benchmark::State& state) {
  const Sheet sheet(static_cast<std::size_t>(state.range(0)));
  StrokePictureParameters parameters;
  parameters.medium = static_cast<StrokeMedium>(state.range(1));
  parameters.width = 1920;
  parameters.height = 1080;
  parameters.view = {0, 0.001, 1};
  RgbImage image;
  for ([[maybe_unused]] auto _ : state) {
    image = stroke_picture(sheet.spans(), parameters);
    benchmark::DoNotOptimize(image.pixels.data());
  }
  const StrokePlan plan = plan_strokes(sheet.spans(), parameters);
  state.counters["strokes"] = static_cast<double>(plan.strokes.size());
  state.counters["seen"] = static_cast<double>(plan.visible);
  check_sum(state, stroke_medium_names[static_cast<std::size_t>(state.range(1))].data(), image.pixels);
}
BENCHMARK(strokes)->ArgsProduct({{35000, 250000}, {0, 1, 2, 3, 4, 5, 6}})->Unit(benchmark::kMillisecond);

}  // namespace

}  // namespace meander::bench
