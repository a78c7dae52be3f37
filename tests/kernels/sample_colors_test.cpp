// Colors at samples: of single points, and of whole surfaces against their integrals.
#include "kernels/sample/sample_colors.h"

#include <cmath>
#include <limits>

#include "kernels/model/model.h"
#include "support/catch.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;

namespace {

constexpr float none = std::numeric_limits<float>::quiet_NaN();

// Samples of the triangle 0, 1, 2 of polygon 0.
Samples samples_at(const std::vector<float>& barycentric) {
  Samples samples;
  samples.barycentric = barycentric;
  for (std::size_t i = 0; i < barycentric.size() / 2; ++i) {
    samples.points.insert(samples.points.end(), {0, 0, 0});
    samples.face.push_back(0);
    samples.corners.insert(samples.corners.end(), {0, 1, 2});
  }
  return samples;
}

using Rgb = std::vector<std::uint8_t>;

Model sampled(PolygonMesh mesh, std::uint32_t samples) {
  SampleParameters parameters = parameters_for("auto");
  parameters.samples = samples;
  parameters.columns[&Samples::rgb] = true;
  Model model;
  model.file = std::move(mesh);
  model.key = make_random_key(1, {});
  run_stages(stages_of(parameters, nullptr), model);
  return model;
}

}  // namespace

TEST_CASE("sample_colors: displayed colors of vertices are interpolated and rounded") {
  PolygonMesh mesh;
  mesh.colors.vertex = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  const SampleColors made = sample_colors(mesh, samples_at({0, 0, 1, 0, 0, 1, .25f, .25f}));
  CHECK(made.rgb == Rgb{255, 0, 0, 0, 255, 0, 0, 0, 255, 128, 64, 64});
  CHECK(made.source == ColorSource::vertex);
  CHECK(made.fills == 0);
  mesh.colors.vertex = {2, -1, .5f, 2, -1, .5f, 2, -1, .5f};
  CHECK(sample_colors(mesh, samples_at({.5f, .25f})).rgb == Rgb{255, 0, 128});
}

TEST_CASE("sample_colors: a corner without a color, a polygon without one, and neither") {
  PolygonMesh mesh;
  mesh.colors.vertex = {1, 0, 0, none, none, none, 0, 0, 1};
  mesh.colors.face = {0, .2f, 1};
  SampleColors made = sample_colors(mesh, samples_at({.25f, .25f}));
  CHECK(made.rgb == Rgb{0, 51, 255});
  CHECK(made.source == ColorSource::face);
  mesh.colors.of_materials = true;
  CHECK(sample_colors(mesh, samples_at({.25f, .25f})).source == ColorSource::material);
  mesh.colors.face = {none, none, none};
  made = sample_colors(mesh, samples_at({.25f, .25f, 0, 0}));
  CHECK(made.rgb == Rgb(6, color_fill));
  CHECK(made.fills == 2);
  CHECK(made.source == ColorSource::none);
  mesh.colors = {};
  CHECK(sample_colors(mesh, samples_at({.25f, .25f})).fills == 1);
}

TEST_CASE("sample_colors: linear colors are multiplied and displayed as sRGB") {
  PolygonMesh mesh;
  mesh.colors.linear = true;
  mesh.colors.vertex = {.5f, 1, 0, .5f, 1, 0, .5f, 1, 0};
  // The reference values of the transfer function: 0.5 -> 187.5, 0.25 -> 136.96, 0.002 -> 6.59.
  CHECK(sample_colors(mesh, samples_at({0, 0})).rgb == Rgb{188, 255, 0});
  mesh.colors.face = {.5f, .002f, 1};
  CHECK(sample_colors(mesh, samples_at({0, 0})).rgb == Rgb{137, 7, 0});
  mesh.colors.vertex = {};
  CHECK(sample_colors(mesh, samples_at({0, 0})).rgb == Rgb{188, 7, 255});
}

TEST_CASE("sample_colors: the halves of a sphere keep their colors along the seam") {
  PolygonMesh sphere = icosphere(3);
  for (std::size_t p = 0; p < sphere.polygon_count(); ++p) {
    double height = 0;
    for (std::size_t c = sphere.polygon_begin[p]; c < sphere.polygon_begin[p + 1]; ++c)
      height += sphere.z[sphere.corners[c]];
    const bool upper = height > 0;
    sphere.colors.face.insert(sphere.colors.face.end(), {upper ? 1.0f : 0.0f, 0.0f, upper ? 0.0f : 1.0f});
  }
  const std::vector<float> faces = sphere.colors.face;
  const Model model = sampled(std::move(sphere), 4000);
  REQUIRE(model.row.report.status == Status::ok);
  CHECK(model.row.report.color_source == ColorSource::face);
  const Samples& samples = model.row.samples;
  REQUIRE(samples.rgb.size() == 12000);
  std::size_t red = 0;
  for (std::size_t i = 0; i < samples.count(); ++i) {
    const bool upper = faces[3 * samples.face[i]] == 1;
    REQUIRE(samples.rgb[3 * i] == (upper ? 255 : 0));
    REQUIRE(samples.rgb[3 * i + 1] == 0);
    REQUIRE(samples.rgb[3 * i + 2] == (upper ? 0 : 255));
    red += upper ? 1 : 0;
  }
  CHECK(red > 1900);
  CHECK(red < 2100);
}

TEST_CASE("sample_colors: the mean of 10,000 samples is the integral over the surface") {
  // Red is (1 + x) / 2 and green y^2 at the vertices of a square plate [-1, 1]^2 of fine cells, blue is 0.75.
  PolygonMesh plate = grid_plane(64, 64, 2, 2);
  double low_x = 1e9, low_y = 1e9;
  for (std::size_t v = 0; v < plate.vertex_count(); ++v) {
    low_x = std::min(low_x, plate.x[v]);
    low_y = std::min(low_y, plate.y[v]);
  }
  for (std::size_t v = 0; v < plate.vertex_count(); ++v) {
    const double x = plate.x[v] - low_x - 1, y = plate.y[v] - low_y - 1;
    plate.colors.vertex.push_back(static_cast<float>((1 + x) / 2));
    plate.colors.vertex.push_back(static_cast<float>(y * y));
    plate.colors.vertex.push_back(0.75f);
  }
  const Model model = sampled(std::move(plate), 10000);
  REQUIRE(model.row.report.status == Status::ok);
  double sums[3] = {0, 0, 0};
  for (std::size_t i = 0; i < 30000; ++i) sums[i % 3] += model.row.samples.rgb[i] / 255.0;
  // The integrals of a plate without cells are 1/2, 1/3 and 3/4; random samples would scatter by 0.003.
  CHECK(sums[0] / 10000 == Approx(0.5).margin(0.002));
  CHECK(sums[1] / 10000 == Approx(1 / 3.0).margin(0.002));
  CHECK(sums[2] / 10000 == Approx(191 / 255.0).margin(1e-12));
}

TEST_CASE("sample_colors: colors do not move the points, and without the option there are none") {
  PolygonMesh mesh = torus(12, 8);
  SampleParameters parameters = parameters_for("auto");
  parameters.samples = 128;
  Model plain;
  plain.file = mesh;
  plain.key = make_random_key(1, {});
  run_stages(stages_of(parameters, nullptr), plain);
  CHECK(plain.row.samples.rgb.empty());
  const Model colored = sampled(std::move(mesh), 128);
  CHECK(colored.row.samples.points == plain.row.samples.points);
  CHECK(colored.row.samples.rgb == Rgb(3 * 128, color_fill));
  CHECK(colored.row.report.color_fills == 128);
}
