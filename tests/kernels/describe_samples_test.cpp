#include "kernels/describe/describe_samples.h"

#include <catch2/catch.hpp>
#include <stdexcept>

#include "kernels/mesh/prepare_mesh.h"
#include "kernels/model/model.h"
#include "support/test_meshes.h"

using namespace meander;

TEST_CASE(
    "sample_triangles: weights and the triangle found re-create the point, polygons of several triangles") {
  SampleParameters parameters = parameters_for("direct");
  set_samples(parameters, 300);
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
    const Vector3 centre = model.surface.centre;
    CHECK(centre.x + model.surface.unit * p.x == Approx(samples.points[3 * i]).margin(1e-6));
    CHECK(centre.y + model.surface.unit * p.y == Approx(samples.points[3 * i + 1]).margin(1e-6));
    CHECK(centre.z + model.surface.unit * p.z == Approx(samples.points[3 * i + 2]).margin(1e-6));
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
