// The functions that Python calls by name, called from here: under sanitizers, which the Python package does
// without.
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "jobs/cli/usage_error.h"
#include "jobs/python/laboratory_call.h"
#include "support/catch.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;

namespace {

struct Arrays {
  std::vector<double> vertices, view{0.3, 0.4, 1}, up{0, 1, 0};
  std::vector<std::uint32_t> faces;
  explicit Arrays(const PolygonMesh& mesh) : faces(mesh.corners) {
    for (std::size_t v = 0; v < mesh.vertex_count(); ++v)
      vertices.insert(vertices.end(), {mesh.x[v], mesh.y[v], mesh.z[v]});
  }
};

GivenArray reals(const char* name, const std::vector<double>& values, std::uint64_t columns = 1) {
  return {name, std::span(values), values.size() / columns, columns};
}

LaboratoryResult call(const char* name, const std::string& options,
                      const std::vector<GivenArray>& arrays = {}, const LaboratoryResult* staged = nullptr) {
  return call_laboratory(
      name, LaboratoryArguments(options, arrays, {{}, staged != nullptr ? staged->staged : nullptr}));
}

std::vector<GivenArray> mesh_of(const Arrays& mesh) {
  return {reals("vertices", mesh.vertices, 3),
          {"faces", std::span(mesh.faces), mesh.faces.size() / 3, 3},
          reals("views", mesh.view, 3),
          reals("up", mesh.up, 3)};
}

double number(const LaboratoryResult& result, const std::string& name) {
  for (const auto& [key, value] : result.numbers)
    if (key == name) return value;
  throw std::logic_error("no number " + name);
}

template <class Value>
const std::vector<Value>& values(const LaboratoryResult& result, std::string_view name) {
  for (const LaboratoryResult::Array& array : result.arrays)
    if (array.name == name) return std::get<std::vector<Value>>(array.values);
  throw std::logic_error("no array " + std::string(name));
}

}  // namespace

TEST_CASE("laboratory functions: missing, misspelled and misshapen arguments are refused by name") {
  const Arrays ball(icosphere(1));
  const auto says = [&](const char* name, const char* options, const std::vector<GivenArray>& arrays,
                        const std::string& what) {
    try {
      call(name, options, arrays);
    } catch (const std::invalid_argument& error) {
      INFO(error.what());
      CHECK(std::string(error.what()).find(what) != std::string::npos);
      return;
    }
    FAIL_CHECK(std::string(name) + " was not refused");
  };
  says("stages", "{}", {}, "no function `stages`");
  says("stage", "{}", {}, "vertices must be an array");
  says("stage", "{}", {reals("vertices", ball.vertices, 1)}, "vertices has 1 columns where 3 are needed");
  says("stage", "{}", {reals("vertices", ball.vertices, 3), reals("faces", ball.vertices, 3)},
       "faces must be whole numbers");
  says("stage", R"({"n":-1})", mesh_of(ball), "n must be a whole number");
  says("stage", R"({"n":"many"})", mesh_of(ball), "n must be a whole number");
  says("stage", R"({"run":[1]})", mesh_of(ball), "run must be a list of texts");
  says("samples", "{}", {}, "a model that was staged is needed");
  says("points_in_square", R"({"method":"sobel","n":4})", {}, "no method `sobel`");
  CHECK_THROWS_AS(call("stage", R"({"run":["--metod","conformal"]})", mesh_of(ball)), UsageError);
}

TEST_CASE("laboratory functions: a staged model is sampled, measured and drawn") {
  const Arrays ball(icosphere(3));
  for (const char* run : {R"("run":["--method","conformal"])", R"("run":["--method","anisotropic"])"}) {
    INFO(run);
    const std::string options = std::string("{") + run + R"(,"n":300,"size":64,"cover":4})";
    const LaboratoryResult staged = call("stage", options, mesh_of(ball));
    CHECK(number(staged, "area") == Approx(4 * 3.14159).epsilon(0.02));
    const LaboratoryResult samples = call("samples", options, mesh_of(ball), &staged);
    const std::vector<double>& points = values<double>(samples, "points");
    REQUIRE(points.size() == 900);
    for (std::size_t i = 0; i < points.size(); i += 3)
      CHECK(std::hypot(points[i], points[i + 1], points[i + 2]) == Approx(1).margin(0.02));
    CHECK(values<std::uint8_t>(call("splats", options, mesh_of(ball), &staged), "images").size() ==
          64 * 64 * 3);
    const std::vector<double> sizes = {300};
    std::vector<std::uint32_t> counts = {300};
    const LaboratoryResult measured =
        call("measures_of_sets", R"({"boxes":100,"seed":1})",
             {reals("points", points, 3), {"sizes", std::span(counts), 1, 1}}, &staged);
    CHECK(values<double>(measured, "ratio").front() < 0.8);
    CHECK(values<double>(measured, "rho").front() > 0);
  }
}

TEST_CASE("laboratory functions: curves, pieces and fields of charts are returned") {
  const Arrays ring(torus(32, 16));
  const std::string conformal =
      R"({"run":["--method","conformal"],"n":200,"leaves":256,"level":4,"steps":2,"spots":100})";
  const LaboratoryResult charted = call("stage", conformal, mesh_of(ring));
  const LaboratoryResult curve = call("mesh_curve", conformal, mesh_of(ring), &charted);
  CHECK(values<double>(curve, "points").size() > 300);
  const std::string along = R"({"run":["--method","anisotropic"],"n":200})";
  const LaboratoryResult field = call("stage", along, mesh_of(ring));
  const LaboratoryResult charts = call("segment_charts", along, mesh_of(ring), &field);
  CHECK(values<double>(charts, "corners").size() == 9 * 32 * 16 * 2);
  CHECK(values<double>(call("segment_curves", along, mesh_of(ring), &field), "points").size() > 100);
  CHECK(values<double>(call("segment_pieces", along, mesh_of(ring), &field), "position").size() > 200);
  // A torus has no singularity where its principal directions follow the circles: indices add up to 0.
  CHECK(number(call("field_singularities", along, mesh_of(ring)), "euler") == 0);
}

TEST_CASE("laboratory functions: sets in the square and on the sphere are returned") {
  const LaboratoryResult square = call("points_in_square", R"({"method":"sobol","n":256})");
  const std::vector<double>& points = values<double>(square, "points");
  REQUIRE(points.size() == 512);
  const LaboratoryResult found =
      call("square_discrepancy", R"({"shapes":200})", {reals("points", points, 2)});
  CHECK(number(found, "boxes") < 0.05);
  CHECK(number(found, "triangles") > 0);
  const LaboratoryResult power = call("power_spectrum", R"({"radius":8})", {reals("points", points, 2)});
  CHECK(values<double>(power, "power").size() == 17 * 17);
  const LaboratoryResult sphere = call("points_on_sphere", R"({"method":"random","n":100})");
  for (std::size_t i = 0; i < 300; i += 3) {
    const double* p = values<double>(sphere, "points").data() + i;
    CHECK(std::hypot(p[0], p[1], p[2]) == Approx(1).margin(1e-6));
  }
  const LaboratoryResult curve =
      call("surface_curve", R"({"surface":"torus","leaves":64,"steps":1,"tolerance":0.001})");
  CHECK(values<double>(curve, "uv").size() >= 2 * 32);
}

TEST_CASE("laboratory functions: strokes, view detail and pictures have the requested size") {
  const Arrays ball(icosphere(2));
  const std::string options =
      R"({"run":["--method","anisotropic"],"n":100,"size":64,"cover":4,"medium":"ink","coverage":true})";
  const LaboratoryResult strokes = call("strokes", options, mesh_of(ball));
  CHECK(values<std::uint8_t>(strokes, "image").size() == 64 * 64 * 3);
  CHECK(number(strokes, "bare") <= 1);
  const LaboratoryResult detail = call("view_detail", R"({"n":500,"size":64,"cover":4})", mesh_of(ball));
  CHECK(!values<std::uint32_t>(detail, "kept").empty());
  std::vector<GivenArray> bare = mesh_of(ball);
  bare.resize(2);  // of one view, which has a default
  const LaboratoryResult picture = call("picture", R"({"size":64})", bare);
  CHECK(values<std::uint8_t>(picture, "image").size() == 64 * 64 * 3);
}
