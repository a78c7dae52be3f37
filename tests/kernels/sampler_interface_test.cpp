// The headers that other programs include: kernels/public.
#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "kernels/mesh/polygon_mesh.h"
#include "kernels/model/model_sampler.h"
#include "kernels/public/descriptors.h"
#include "kernels/public/sampler.h"
#include "kernels/public/surface.h"
#include "kernels/retrieve/descriptor_distance.h"
#include "support/catch.h"
#include "support/test_meshes.h"

using namespace meander;
using Catch::Matchers::ContainsSubstring;

namespace {

// A cube of six quads, and two triangles that halve the first of them.
const std::vector<double> cube = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 0, 0, 1, 1, 0, 1, 1, 1, 1, 0, 1, 1};
const std::vector<std::uint32_t> quads = {0, 3, 2, 1, 4, 5, 6, 7, 0, 1, 5, 4,
                                          1, 2, 6, 5, 2, 3, 7, 6, 3, 0, 4, 7};

std::string problem_of(const Settings& settings) {
  try {
    const Sampler sampler(settings);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

}  // namespace

TEST_CASE("Sampler: settings by name are the parameters of the same names") {
  const PolygonMesh torus = test::torus(20, 10);
  std::vector<double> positions;
  for (std::size_t v = 0; v < torus.vertex_count(); ++v)
    positions.insert(positions.end(), {torus.x[v], torus.y[v], torus.z[v]});
  SampleParameters parameters = parameters_for("direct");
  parameters.samples = 300;
  parameters.seed = 7;
  parameters.density.kind = DensityKind::mean;
  parameters.density.floor = 0.25;
  parameters.sequence = SequenceKind::stratified;
  parameters.describe.descriptors = {Descriptor::d2, Descriptor::basics};
  const std::array<std::uint8_t, 16> content = {3, 1};
  const Row row = ModelSampler(parameters).sample(torus, content);
  const Sampler sampler({{"samples", 300},
                         {"seed", 7u},
                         {"method", "direct"},
                         {"density", "mean"},
                         {"density_floor", 0.25},
                         {"sequence", std::string("stratified")},
                         {"describe", "d2,basics"}});
  const SampledModel model = sampler.sample({positions, torus.corners}, content);
  REQUIRE(model.report.status == Status::ok);
  CHECK((model.samples.points == row.samples.points));
  CHECK((model.samples.density == row.samples.density));
  CHECK(model.report.area == row.report.area);
  REQUIRE(model.descriptors.size() == 2);
  CHECK(model.descriptors[0].name == "d2");
  CHECK((model.descriptors[0].values == row.descriptors[0].values));
  CHECK_FALSE((sampler.sample({positions, torus.corners}).samples.points == model.samples.points));
}

TEST_CASE("Sampler: the list of settings has defaults that change nothing") {
  const std::vector<SettingInfo> list = list_sampler_settings();
  Settings defaults;
  for (const SettingInfo& setting : list)
    if (!setting.initial.empty()) defaults.emplace(setting.name, setting.initial);
  CHECK(defaults.size() > 15);
  CHECK(defaults.at("samples").text() == "2048");
  CHECK(defaults.at("colors").text() == "false");
  const Mesh mesh{cube, quads, 4};
  CHECK((Sampler(defaults).sample(mesh).samples.points == Sampler().sample(mesh).samples.points));
  const auto method =
      std::find_if(list.begin(), list.end(), [](const SettingInfo& s) { return s.name == "method"; });
  REQUIRE(method != list.end());
  CHECK(method->words == std::vector<std::string>{"auto", "conformal", "direct", "anisotropic"});
  CHECK(list_surface_settings().front().low == 1);
}

TEST_CASE("Sampler: settings that are unknown, wrong, without effect or contradictory are refused") {
  CHECK(problem_of({{"samples", 1}}).empty());
  CHECK(problem_of({{"sampels", 1}}) == "there is no setting `sampels`; did you mean `samples`?");
  CHECK(problem_of({{"samples", 0}}) == "samples: it is 0, must be 1 to 2147483648");
  CHECK_THAT(problem_of({{"samples", "many"}}), ContainsSubstring("`many` is not a number"));
  CHECK_THAT(problem_of({{"method", "directt"}}), ContainsSubstring("did you mean `direct`?"));
  CHECK_THAT(problem_of({{"colors", "yes"}}), ContainsSubstring("neither true nor false"));
  CHECK_THAT(problem_of({{"density_floor", 0.5}}), ContainsSubstring("density_floor applies to"));
  CHECK_THAT(problem_of({{"method", "conformal"}, {"topology", "none"}}), ContainsSubstring("topology"));
  CHECK_THAT(problem_of({{"samples", 0}, {"method", "x"}}), ContainsSubstring("; "));
}

TEST_CASE("Sampler: polygons, attributes, colors and texture coordinates are read from arrays") {
  const std::vector<double> wanted = {0, 1, 0, 0, 3, 0};
  std::vector<double> heights;
  for (std::size_t v = 0; v < 8; ++v) heights.push_back(cube[3 * v + 2]);
  const std::vector<float> red_and_blue = {1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0,
                                           0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1};
  std::vector<float> coordinates;
  for (const std::uint32_t corner : quads)
    coordinates.insert(coordinates.end(), {static_cast<float>(cube[3 * corner]), 0.5f});
  Mesh mesh{cube, quads, 4};
  mesh.face_attributes = {{"wanted", wanted}};
  mesh.vertex_attributes = {{"height", heights}};
  mesh.vertex_colors = red_and_blue;
  mesh.texcoords = coordinates;
  const SampledModel model = Sampler({{"samples", 512},
                                      {"density", "face-attribute:wanted"},
                                      {"attributes", "height"},
                                      {"colors", true},
                                      {"texcoord", true}})
                                 .sample(mesh);
  REQUIRE(model.report.reason == "");
  CHECK(model.report.faces == 6);
  std::array<std::uint32_t, 6> count{};
  for (const std::uint32_t face : model.samples.face) ++count.at(face);
  CHECK(count == std::array<std::uint32_t, 6>{0, 128, 0, 0, 384, 0});
  double error = 0;
  for (std::size_t i = 0; i < 512; ++i) {
    const float* const p = &model.samples.points[3 * i];
    error = std::max<double>({error, std::abs(model.samples.attributes[0][i] - p[2]),
                              std::abs(model.samples.texcoord[2 * i] - p[0]),
                              std::abs(model.samples.rgb[3 * i + 2] / 255.0 - p[2]) - 0.002});
  }
  CHECK(error < 1e-6);

  // The same polygons by their offsets.
  const std::vector<std::uint32_t> begin = {0, 4, 8, 12, 16, 20, 24};
  Mesh offsets{cube, quads};
  offsets.face_begin = begin;
  CHECK((Sampler().sample(offsets).samples.points == Sampler().sample({cube, quads, 4}).samples.points));
}

TEST_CASE("Sampler: arrays whose lengths do not fit are refused by name") {
  const Sampler sampler({{"samples", 16}});
  const auto problem = [&](const std::function<void(Mesh&)>& spoil) -> std::string {
    Mesh mesh{cube, quads, 4};
    spoil(mesh);
    try {
      sampler.sample(mesh);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  };
  const std::vector<float> few(3);
  const std::vector<double> two(2);
  const std::vector<std::uint32_t> falling = {0, 12, 8, 24}, early = {0, 4};
  CHECK(problem([](Mesh&) {}) == "");
  CHECK_THAT(problem([](Mesh& m) { m.positions = m.positions.first(4); }), ContainsSubstring("positions"));
  CHECK_THAT(problem([](Mesh& m) { m.corners = m.corners.first(7); }),
             ContainsSubstring("7 corners are no faces of 4 corners each"));
  CHECK_THAT(problem([](Mesh& m) { m.corners_per_face = 2; }), ContainsSubstring("2 corners each"));
  CHECK_THAT(problem([&](Mesh& m) { m.face_begin = falling; }), ContainsSubstring("face_begin"));
  CHECK_THAT(problem([&](Mesh& m) { m.face_begin = early; }), ContainsSubstring("face_begin"));
  CHECK(problem([&](Mesh& m) { m.normals = few; }) == "normals has 3 numbers where the vertices have 24");
  CHECK_THAT(problem([&](Mesh& m) { m.vertex_colors = few; }), ContainsSubstring("vertex_colors"));
  CHECK_THAT(problem([&](Mesh& m) { m.face_colors = few; }), ContainsSubstring("face_colors"));
  CHECK_THAT(problem([&](Mesh& m) { m.texcoords = few; }), ContainsSubstring("texcoords"));
  CHECK_THAT(problem([&](Mesh& m) {
               m.vertex_attributes = {{"heat", two}};
             }),
             ContainsSubstring("`heat` has 2 numbers where the vertices have 8"));
  CHECK_THAT(problem([&](Mesh& m) {
               m.face_attributes = {{"part", two}};
             }),
             ContainsSubstring("the faces have 6"));
}

TEST_CASE("Sampler: a mesh that cannot be sampled has a status, and a stopped call throws") {
  const Sampler sampler;
  const std::vector<double> line = {0, 0, 0, 1, 0, 0, 2, 0, 0};
  const std::vector<std::uint32_t> face = {0, 1, 2}, outside = {0, 1, 7};
  const SampledModel flat = sampler.sample({line, face});
  CHECK(flat.report.status == Status::zero_area);
  CHECK_FALSE(flat.report.reason.empty());
  CHECK(flat.samples.count() == 0);
  CHECK(sampler.sample({line, outside}).report.status == Status::index_out_of_range);
  CHECK(sampler.sample({}).report.status == Status::empty);

  CancelToken late;
  late.deadline = std::chrono::steady_clock::now() - std::chrono::seconds(1);
  CHECK(sampler.sample({cube, quads, 4}, {}, late).report.status == Status::timeout);
  std::atomic<bool> stop{true};
  CancelToken stopped;
  stopped.canceled = &stop;
  CHECK_THROWS_AS(sampler.sample({cube, quads, 4}, {}, stopped), RunCanceled);
}

TEST_CASE("sample_surface: a name, a formula and a function of one surface have its area") {
  const Settings settings = {{"samples", 256}, {"tolerance", 1e-5}};
  const double pi = std::acos(-1.0);
  const SurfaceFunction cylinder = [](std::span<const double> u, std::span<const double> v,
                                      std::span<double> positions) {
    for (std::size_t i = 0; i < u.size(); ++i) {
      const double angle = 2 * std::acos(-1.0) * u[i];
      positions[3 * i] = std::cos(angle);
      positions[3 * i + 1] = std::sin(angle);
      positions[3 * i + 2] = v[i];
    }
  };
  const SampledModel named = sample_surface("sphere", settings);
  REQUIRE(named.report.status == Status::ok);
  CHECK(named.samples.count() == 256);
  CHECK(named.samples.uv.size() == 512);
  CHECK(named.report.area == Approx(4 * pi).epsilon(1e-4));
  CHECK(sample_surface("cos(2*pi*u), sin(2*pi*u), v", settings).report.area == Approx(2 * pi).epsilon(1e-4));
  const SampledModel called = sample_surface(cylinder, settings);
  CHECK(called.report.area == Approx(2 * pi).epsilon(1e-4));
  const std::array<std::uint8_t, 3> content = {1, 2, 3};
  CHECK_FALSE((sample_surface(cylinder, settings, content).samples.uv == called.samples.uv));
  for (const std::string_view name : surface_names())
    CHECK(sample_surface(name, {{"samples", 4}}).report.status == Status::ok);
}

TEST_CASE("sample_surface: what is wrong throws, passes through or is a status") {
  CHECK_THROWS_WITH(sample_surface("spere"), ContainsSubstring("did you mean `sphere`?"));
  CHECK_THROWS_AS(sample_surface("u, v, w"), std::invalid_argument);
  CHECK_THROWS_WITH(sample_surface("sphere", {{"method", "auto"}}), ContainsSubstring("no setting `method`"));
  const SurfaceFunction refuses = [](std::span<const double>, std::span<const double>, std::span<double>) {
    throw std::domain_error("not here");
  };
  CHECK_THROWS_AS(sample_surface(refuses), std::domain_error);
  const SurfaceFunction nowhere = [](std::span<const double>, std::span<const double>, std::span<double> p) {
    std::fill(p.begin(), p.end(), std::numeric_limits<double>::quiet_NaN());
  };
  CHECK(sample_surface(nowhere).report.status == Status::non_finite);
}

TEST_CASE("descriptor_distance: of two rows, and of all pairs, as a base of rows has it") {
  const std::vector<std::vector<float>> rows = {{0.5f, 0.5f, 0}, {0, 0.5f, 0.5f}, {1, 0, 0}};
  CHECK(descriptor_distance(rows[0], rows[1], DistanceKind::l1) == 1);
  CHECK(descriptor_distance(rows[0], rows[1], DistanceKind::emd) == 1);
  CHECK(descriptor_distance(rows[0], rows[0], DistanceKind::chi2) == 0);
  for (const DistanceKind kind :
       {DistanceKind::l1, DistanceKind::l2, DistanceKind::emd, DistanceKind::chi2, DistanceKind::cosine}) {
    const std::vector<float> all = descriptor_distances(rows, kind);
    REQUIRE(all.size() == 9);
    for (std::size_t i = 0; i < 9; ++i) CHECK(all[i] == descriptor_distance(rows[i / 3], rows[i % 3], kind));
  }
  CHECK_THROWS_AS(descriptor_distance(rows[0], std::vector<float>{1}, DistanceKind::l1),
                  std::invalid_argument);
  CHECK_THROWS_AS(descriptor_distance({}, {}, DistanceKind::l1), std::invalid_argument);
  CHECK_THROWS_AS(descriptor_distances({}, DistanceKind::l1), std::invalid_argument);
  CHECK_THROWS_AS(descriptor_distance(rows[0], std::vector<float>{0, 0, std::nanf("")}, DistanceKind::l2),
                  std::invalid_argument);
}
