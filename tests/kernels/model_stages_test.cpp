// The lists of stages, and the ModelSampler that runs them.
#include <algorithm>
#include <array>
#include <atomic>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "kernels/density/density.h"
#include "kernels/mesh/prepare_mesh.h"
#include "kernels/model/model.h"
#include "kernels/model/model_sampler.h"
#include "support/catch.h"
#include "support/test_meshes.h"
#include "support/threads.h"

using namespace meander;

namespace {

std::vector<double> positions_of(const PolygonMesh& mesh) {
  std::vector<double> positions;
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v)
    positions.insert(positions.end(), {mesh.x[v], mesh.y[v], mesh.z[v]});
  return positions;
}

SampleParameters small(std::string_view method) {
  SampleParameters parameters = parameters_for(method);
  parameters.samples = 256;
  parameters.density.kind = DensityKind::mean;
  parameters.describe.descriptors = {Descriptor::d2, Descriptor::geodesic, Descriptor::basics};
  parameters.curved = true;
  return parameters;
}

std::vector<std::string> names_of(const SampleParameters& parameters, const EmbreeDevice& device) {
  std::vector<std::string> names;
  for (const ModelStage& stage : stages_of(parameters, &device)) names.emplace_back(stage.name);
  return names;
}

bool same_samples(const Row& a, const Row& b) {
  return a.report.points_crc32c == b.report.points_crc32c && a.samples.points == b.samples.points &&
         a.samples.triangle == b.samples.triangle;
}

}  // namespace

TEST_CASE("stages: every method has its own list, without idle stages") {
  const EmbreeDevice device;
  using Names = std::vector<std::string>;
  CHECK(names_of(parameters_for("direct"), device) ==
        Names{"prepare_mesh", "locate_vertices", "place_samples"});
  CHECK(names_of(parameters_for("conformal"), device) == Names{"prepare_mesh", "coarsen_mesh", "cut_to_disk",
                                                               "flatten_chart", "build_curve",
                                                               "locate_vertices", "place_samples"});
  CHECK(names_of(parameters_for("anisotropic"), device) ==
        Names{"prepare_mesh", "follow_tensor", "chart_segments", "build_curve", "locate_vertices",
              "place_samples", "describe_shape"});
  SampleParameters elements = parameters_for("conformal");
  elements.locate = LocatorKind::elements;
  elements.describe.descriptors = {Descriptor::d2};
  CHECK(names_of(elements, device) == Names{"prepare_mesh", "coarsen_mesh", "cut_to_disk", "flatten_chart",
                                            "locate_vertices", "place_samples", "describe_shape"});
  SampleParameters first_hit = parameters_for("conformal");
  first_hit.locate = LocatorKind::first_hit;
  CHECK(names_of(first_hit, device) == Names{"prepare_mesh", "cut_to_disk", "flatten_chart", "build_curve",
                                             "locate_vertices", "place_samples"});
  CHECK_THROWS_AS(stages_of(parameters_for("conformal"), nullptr), std::invalid_argument);
  CHECK_THROWS_AS(parameters_for("conformall"), std::invalid_argument);
}

TEST_CASE("stages: mesh and masses are made once per model, by every method") {
  const EmbreeDevice device;
  const PolygonMesh mesh = test::torus(40, 20);
  for (const SamplingMethod& method : sampling_methods) {
    INFO(method.text);
    const SampleParameters parameters = small(method.text);
    const ModelStages stages = stages_of(parameters, &device);
    const std::vector<std::string> names = names_of(parameters, device);
    CHECK(std::count(names.begin(), names.end(), "prepare_mesh") == 1);
    const Row expected = ModelSampler(parameters).sample(mesh);

    // Once the mesh is prepared no stage asks for the vertices of the file, so none can prepare it again;
    // mesh and masses stay where they were made. That none is made for a moment, tests/product/once.cmake
    // checks.
    Model model;
    model.file = mesh;
    model.key = make_random_key(parameters.seed, {});
    const bool segmented = names.at(1) == "follow_tensor";
    const std::vector<double>& masses = (segmented ? model.segments.measure : model.measure).masses;
    const std::uint32_t* triangles = nullptr;
    const double* made = nullptr;
    for (const ModelStage& stage : stages) {
      INFO(stage.name);
      stage.run(model);
      model.file.x = model.file.y = model.file.z = {};
      if (triangles == nullptr) triangles = model.surface.triangles.data();
      // chart_segments puts those of halved segments in another order.
      if ((made == nullptr && !masses.empty()) || stage.name == "chart_segments") made = masses.data();
      CHECK(model.surface.triangles.data() == triangles);
      CHECK((masses.empty() || masses.data() == made));
      CHECK((segmented ? model.measure : model.segments.measure).masses.empty());
    }
    CHECK(made != nullptr);
    REQUIRE(model.row.report.status == Status::ok);
    CHECK(same_samples(model.row, expected));
  }
}

TEST_CASE("stages: a charted model sampled again equals one sampled from the start") {
  const EmbreeDevice device;
  const PolygonMesh mesh = test::torus(40, 20);
  for (const SamplingMethod& method : sampling_methods) {
    INFO(method.text);
    SampleParameters parameters = small(method.text);
    Model charted;
    charted.file = mesh;
    run_stages(charting_stages(parameters), charted);
    for (const std::uint64_t seed : {1u, 2u}) {
      parameters.seed = seed;
      parameters.sequence = seed == 1 ? SequenceKind::shifted : SequenceKind::stratified;
      Model again = charted;
      again.key = make_random_key(seed, {});
      run_stages(placing_stages(parameters, &device), again);
      CHECK(same_samples(again.row, ModelSampler(parameters).sample(mesh)));
    }
  }
}

TEST_CASE("stages: charts over a coarse mesh, every order and locator, 1, 2 and 8 threads") {
  const EmbreeDevice device;
  const PolygonMesh mesh = test::merged(test::torus(60, 40), test::moved(test::icosphere(4), 0.5, 4, 0, 0));
  const auto run = [&](const SampleParameters& parameters, std::size_t threads) {
    Model model;
    model.file = mesh;
    model.key = make_random_key(1, {});
    test::on_threads(threads, [&] { run_stages(stages_of(parameters, &device), model); });
    return model;
  };
  SampleParameters parameters = parameters_for("conformal");
  parameters.samples = 700;
  parameters.coarsen = {1, 400, 64};
  for (const ElementOrder order : {ElementOrder::hilbert, ElementOrder::peano, ElementOrder::balanced})
    for (const LocatorKind locate : {LocatorKind::embree, LocatorKind::elements}) {
      parameters.curve = order;
      parameters.locate = locate;
      const Model first = run(parameters, 1);
      REQUIRE(!first.coarse.empty());
      CHECK(first.coarse.mesh.triangle_count() < 1200);
      CHECK(first.row.report.status == Status::ok);
      CHECK(first.row.report.method == Method::conformal);
      CHECK(first.row.report.flips == 0);
      CHECK(first.row.samples.count() == 700);
      for (const std::size_t threads : {2u, 8u}) CHECK(same_samples(first.row, run(parameters, threads).row));
    }
  // Samples at the vertices of the elements; the survey's locator takes the charts of the surface itself.
  parameters.curve = ElementOrder::hilbert;
  parameters.place = PlaceKind::vertex;
  CHECK(run(parameters, 1).row.samples.count() == 700);
  parameters.locate = LocatorKind::first_hit;
  const Model first_hit = run(parameters, 1);
  CHECK(first_hit.coarse.empty());
  CHECK(first_hit.row.samples.count() == 700);
}

TEST_CASE("stages: the triangle of a sample is the one a store names by polygon and corners") {
  const PolygonMesh mesh = test::merged(test::cube(), test::moved(test::icosphere(2), 1, 4, 0, 0));
  for (const SamplingMethod& method : sampling_methods) {
    INFO(method.text);
    SampleParameters parameters = parameters_for(method.text);
    parameters.samples = 500;
    parameters.tensor_charts.segment.count = 5;
    const EmbreeDevice device;
    Model model;
    model.file = mesh;
    run_stages(stages_of(parameters, &device), model);
    CHECK(model.row.samples.triangle == sample_triangles(mesh, model.surface, model.row.samples));
  }
}

TEST_CASE("stages: with rows_only the rows are the same, and adjacency is freed unless described") {
  const PolygonMesh mesh = test::torus(60, 40);
  const EmbreeDevice device;
  for (const SamplingMethod& method : sampling_methods)
    for (const bool described : {false, true}) {
      INFO(method.text << (described ? ", described" : ""));
      SampleParameters parameters = small(method.text);
      if (!described) parameters.describe.descriptors.clear();
      const auto run = [&] {
        Model model;
        model.file = mesh;
        run_stages(stages_of(parameters, &device), model);
        return model;
      };
      const Model all = run();
      parameters.rows_only = true;
      const Model rows = run();
      CHECK(same_samples(all.row, rows.row));
      CHECK(rows.row.report.genus == 1);
      REQUIRE(rows.row.descriptors.size() == all.row.descriptors.size());
      for (std::size_t d = 0; d < rows.row.descriptors.size(); ++d)
        CHECK(rows.row.descriptors[d].values == all.row.descriptors[d].values);
      CHECK(all.surface.has_topology());
      CHECK(rows.surface.has_topology() == (described || method.makes_charts));
    }
}

TEST_CASE("stages: without topology a consistent surface gets the same samples, and no counts") {
  const PolygonMesh mesh = test::torus(60, 40);
  for (const char* method : {"auto", "direct"}) {
    INFO(method);
    SampleParameters parameters = parameters_for(method);
    parameters.samples = 500;
    const Row full = ModelSampler(parameters).sample(mesh);
    parameters.topology = false;
    const Row bare = ModelSampler(parameters).sample(mesh);
    REQUIRE(bare.report.status == Status::ok);
    CHECK(same_samples(full, bare));
    CHECK(bare.samples.normals == full.samples.normals);
    CHECK(bare.report.area == full.report.area);
    CHECK(full.report.components == 1);
    CHECK(full.report.genus == 1);
    CHECK(bare.report.components == 0);
    CHECK(bare.report.genus == 0);
    CHECK(bare.report.boundaries == 0);
  }
}

TEST_CASE("stages: without topology normals follow the winding of the file") {
  PolygonMesh mesh = test::icosphere(2);
  for (std::size_t c = 0; c < mesh.corners.size(); c += 6)
    std::swap(mesh.corners[c + 1], mesh.corners[c + 2]);
  SampleParameters parameters = parameters_for("direct");
  parameters.samples = 400;
  parameters.topology = false;
  const Row row = ModelSampler(parameters).sample(mesh);
  REQUIRE(row.report.status == Status::ok);
  CHECK(row.report.repairs[Repair::flipped_faces] == 0);
  for (std::size_t i = 0; i < 400; ++i) {
    const float* const p = &row.samples.points[3 * i];
    const float* const n = &row.samples.normals[3 * i];
    const bool outside = p[0] * n[0] + p[1] * n[1] + p[2] * n[2] > 0;
    CHECK(outside == (row.samples.face[i] % 2 != 0));
  }
}

TEST_CASE("locate_on_mesh: samples taken without topology keep their place on a mesh with flipped faces") {
  PolygonMesh mesh = test::icosphere(2);
  for (std::size_t c = 0; c < mesh.corners.size(); c += 9)
    std::swap(mesh.corners[c + 1], mesh.corners[c + 2]);
  SampleParameters parameters = parameters_for("direct");
  parameters.samples = 400;
  parameters.topology = false;
  Row row = ModelSampler(parameters).sample(mesh);
  REQUIRE(row.report.status == Status::ok);
  const PreparedMesh full = prepare_mesh(mesh);
  REQUIRE(full.repairs[Repair::flipped_faces] > 0);
  locate_on_mesh(mesh, full, row.samples);
  std::size_t turned = 0;
  for (std::size_t i = 0; i < 400; ++i) {
    const std::size_t t = row.samples.triangle[i];
    turned += row.samples.face[i] % 3 == 0;
    CHECK(full.polygon[t] == row.samples.face[i]);
    const double b1 = static_cast<double>(row.samples.barycentric[2 * i]),
                 b2 = static_cast<double>(row.samples.barycentric[2 * i + 1]);
    const Vector3 on_mesh = (1 - b1 - b2) * full.position(full.triangles[3 * t]) +
                            b1 * full.position(full.triangles[3 * t + 1]) +
                            b2 * full.position(full.triangles[3 * t + 2]);
    const Vector3 in_file = full.center + full.unit * on_mesh;
    const float* const p = &row.samples.points[3 * i];
    CHECK(distance(in_file,
                   {static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])}) < 1e-6);
  }
  CHECK(turned > 50);
}

TEST_CASE("SampleParameters: options that need topology are refused without it") {
  const auto problems = [](const char* method, const auto& change) {
    SampleParameters parameters = parameters_for(method);
    parameters.topology = false;
    change(parameters);
    return validate(parameters).size();
  };
  const auto as_is = [](SampleParameters&) {};
  CHECK(problems("auto", as_is) == 0);
  CHECK(problems("direct", as_is) == 0);
  CHECK(problems("conformal", as_is) == 1);
  CHECK(problems("anisotropic", as_is) == 1);
  CHECK(problems("auto", [](SampleParameters& p) { p.density.kind = DensityKind::mean; }) == 1);
  CHECK(problems("auto", [](SampleParameters& p) { p.curved = true; }) == 1);
  CHECK(problems("auto", [](SampleParameters& p) {
          p.describe.descriptors = {Descriptor::d2, Descriptor::geodesic, Descriptor::basics};
        }) == 2);
}

TEST_CASE("ModelSampler: one object serves many threads, with the same samples as one thread") {
  const ModelSampler sampler(small("conformal"));
  std::vector<PolygonMesh> meshes;
  for (int i = 0; i < 8; ++i) meshes.push_back(test::torus(20 + i, 10));
  std::vector<Row> alone, together(meshes.size());
  for (const PolygonMesh& mesh : meshes) alone.push_back(sampler.sample(mesh));
  std::vector<std::thread> threads;
  for (std::size_t i = 0; i < meshes.size(); ++i)
    threads.emplace_back([&, i] { together[i] = sampler.sample(meshes[i]); });
  for (std::thread& thread : threads) thread.join();
  for (std::size_t i = 0; i < meshes.size(); ++i) {
    REQUIRE(together[i].report.status == Status::ok);
    CHECK(same_samples(together[i], alone[i]));
    CHECK(together[i].descriptors.front().values == alone[i].descriptors.front().values);
  }
}

TEST_CASE("ModelSampler: a mesh with polygons and attributes is sampled directly") {
  PolygonMesh mesh = test::cube();
  mesh.face_attributes.push_back({"wanted", {0, 1, 0, 0, 3, 0}});
  SampleParameters parameters = parameters_for("auto");
  parameters.samples = 512;
  parameters.density.kind = DensityKind::face_attribute;
  parameters.density.attribute = "wanted";
  const Row row = ModelSampler(parameters).sample(mesh);
  REQUIRE(row.report.status == Status::ok);
  CHECK(row.report.faces == 6);
  std::array<std::uint32_t, 6> count{};
  for (const std::uint32_t face : row.samples.face) ++count.at(face);
  CHECK(count == std::array<std::uint32_t, 6>{0, 128, 0, 0, 384, 0});

  // Triangles alone: the samples of the arrays. The content keys both.
  const PolygonMesh plain = test::torus(20, 10);
  parameters.density = {};
  const ModelSampler sampler(parameters);
  const std::array<std::uint8_t, 16> content = {7};
  const Row of_mesh = sampler.sample(plain, content);
  CHECK(
      same_samples(of_mesh, sampler.sample(polygon_mesh_of({positions_of(plain), plain.corners}), content)));
  CHECK_FALSE(of_mesh.samples.points == sampler.sample(plain).samples.points);
}

TEST_CASE("ModelSampler: invalid parameters are refused, bad meshes and timeouts are statuses") {
  SampleParameters parameters = parameters_for("direct");
  parameters.jitter = 2;
  CHECK_THROWS_AS(ModelSampler(parameters), std::invalid_argument);
  const ModelSampler sampler(parameters_for("direct"));
  const std::vector<double> corners = {0, 0, 0, 1, 0, 0, 2, 0, 0};
  const std::vector<std::uint32_t> face = {0, 1, 2}, outside = {0, 1, 7};
  const Row flat = sampler.sample(polygon_mesh_of({corners, face}));
  CHECK(flat.report.status == Status::zero_area);
  CHECK_FALSE(flat.report.reason.empty());
  CHECK(flat.samples.count() == 0);
  CHECK(sampler.sample(polygon_mesh_of({corners, outside})).report.status == Status::index_out_of_range);

  const PolygonMesh mesh = test::icosphere(5);
  CancelToken late;
  late.deadline = std::chrono::steady_clock::now() - std::chrono::seconds(1);
  CHECK(sampler.sample(mesh, {}, late).report.status == Status::timeout);
  std::atomic<bool> stop{true};
  CancelToken stopped;
  stopped.canceled = &stop;
  CHECK_THROWS_AS(sampler.sample(mesh, {}, stopped), RunCanceled);
}
