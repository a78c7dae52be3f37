#include "kernels/describe/describe_samples.h"

#include <atomic>
#include <chrono>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "kernels/describe/distance_histogram.h"
#include "kernels/describe/oriented_pairs.h"
#include "kernels/describe/shape_functions.h"
#include "kernels/describe/shell_harmonics.h"
#include "kernels/mesh/prepare_mesh.h"
#include "kernels/model/model.h"
#include "support/catch.h"
#include "support/test_meshes.h"

using namespace meander;

namespace {

// A star with so many corners that its triangles are searched, turned over or not.
PolygonMesh star(std::uint32_t corners, bool turned) {
  std::vector<double> xyz;
  std::vector<std::uint32_t> face;
  for (std::uint32_t i = 0; i < corners; ++i) {
    const double angle = 2 * std::numbers::pi * i / corners, radius = i % 2 == 0 ? 1 : 0.6;
    xyz.insert(xyz.end(), {radius * std::cos(angle), radius * std::sin(angle), 0});
    face.push_back(turned ? corners - 1 - i : i);
  }
  return test::polygon_mesh(xyz, {face});
}

}  // namespace

TEST_CASE("sample_triangles: finds the triangle of each sample of a polygon with many corners") {
  for (const bool turned : {false, true}) {
    SampleParameters parameters = parameters_for("direct");
    parameters.samples = 500;
    Model model;
    model.file = test::merged(star(60, turned), test::moved(star(40, !turned), 2, 0, 0, 1));
    run_stages(stages_of(parameters, nullptr), model);
    CHECK(sample_triangles(model.file, model.surface, model.row.samples) == model.row.samples.triangle);
    // In the other winding, too.
    Samples other = model.row.samples;
    for (std::size_t i = 0; i < other.count(); ++i)
      std::swap(other.corners[3 * i + 1], other.corners[3 * i + 2]);
    CHECK(sample_triangles(model.file, model.surface, other) == model.row.samples.triangle);
  }
}

TEST_CASE("descriptors: those of all pairs and tuples can be canceled") {
  const std::vector<float> points = [] {
    std::vector<float> numbers;
    for (int i = 0; i < 3000; ++i) numbers.push_back(static_cast<float>(i * 37 % 101));
    return numbers;
  }();
  std::vector<float> normals(points.size(), 0);
  for (std::size_t i = 0; i < normals.size(); i += 3) normals[i] = 1;
  const std::atomic<bool> stop = true;
  CancelToken canceled, late;
  canceled.canceled = &stop;
  late.deadline = std::chrono::steady_clock::now() - std::chrono::seconds(1);
  const RandomKey key = make_random_key(1, {});
  CHECK_THROWS_AS(distance_histogram(points, {}, canceled), RunCanceled);
  CHECK_THROWS_AS(distance_histogram(points, {.scale = HistogramScale::mean}, late), ItemError);
  CHECK_THROWS_AS(oriented_pair_histogram(points, normals, {}, late), ItemError);
  CHECK_THROWS_AS(shape_function_histogram(points, ShapeFunction::angle, key, {}, canceled), RunCanceled);
  CHECK_THROWS_AS(shell_harmonics(points, late), ItemError);
}

TEST_CASE("sample_triangles: weights and triangle reproduce the point, in polygons of several triangles") {
  SampleParameters parameters = parameters_for("direct");
  parameters.samples = 300;
  Model model;
  model.file = test::merged(test::cube(), test::moved(test::icosphere(2), 1, 4, 0, 0));
  run_stages(stages_of(parameters, nullptr), model);
  const Samples& samples = model.row.samples;
  const std::vector<std::uint32_t> triangles = sample_triangles(model.file, model.surface, samples);
  REQUIRE(triangles.size() == 300);
  CHECK(triangles == samples.triangle);
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    const std::uint32_t* const corner = model.surface.triangles.data() + 3 * triangles[i];
    const double b1 = samples.barycentric[2 * i], b2 = samples.barycentric[2 * i + 1];
    const Vector3 p = (1 - b1 - b2) * model.surface.position(corner[0]) +
                      b1 * model.surface.position(corner[1]) + b2 * model.surface.position(corner[2]);
    const Vector3 center = model.surface.center;
    CHECK(center.x + model.surface.unit * p.x == Approx(samples.points[3 * i]).margin(1e-6));
    CHECK(center.y + model.surface.unit * p.y == Approx(samples.points[3 * i + 1]).margin(1e-6));
    CHECK(center.z + model.surface.unit * p.z == Approx(samples.points[3 * i + 2]).margin(1e-6));
  }

  // A mesh that was not the one sampled.
  Samples elsewhere = samples;
  elsewhere.face.back() = static_cast<std::uint32_t>(model.file.polygon_count());
  CHECK_THROWS_AS(sample_triangles(model.file, model.surface, elsewhere), std::invalid_argument);
  PreparedMesh without = model.surface;
  for (std::uint32_t& polygon : without.polygon)
    if (polygon == samples.face[0]) polygon = samples.face[0] > 0 ? 0 : 1;
  CHECK_THROWS_AS(sample_triangles(model.file, without, samples), std::invalid_argument);
}
