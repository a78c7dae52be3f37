// What one model takes at its peak, measured, against what is reserved for it: every method, 1, 2 and 16
// threads.
#include <fmt/format.h>
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <numbers>

#include "io/store/row_codec.h"
#include "kernels/analyse/certify_samples.h"
#include "kernels/core/parallel.h"
#include "pipeline/memory_estimate.h"
#include "pipeline/sampling_graph.h"
#include "support/allocation_counter.h"
#include "support/catch.h"
#include "support/gltf_files.h"
#include "support/image_files.h"
#include "support/mesh_files.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;

namespace {

namespace fs = std::filesystem;

constexpr std::array<int, 3> thread_counts = {1, 2, 16};

struct Setting {
  std::string name;
  SampleParameters parameters;
  bool certify = false;

  // Takes longest, and as much memory with any number of threads.
  bool slow() const {
    return parameters.sequence == SequenceKind::spaced || parameters.finish == FinishKind::relax ||
           !parameters.describe.descriptors.empty();
  }
};

// The ways through the stages that differ in what they hold.
std::vector<Setting> settings(std::uint32_t samples) {
  std::vector<Setting> all;
  const auto add = [&](const char* name, auto change) {
    Setting setting{name, parameters_for("conformal")};
    change(setting.parameters);
    setting.parameters.samples = samples;
    all.push_back(std::move(setting));
  };
  using P = SampleParameters;
  add("conformal", [](P&) {});
  add("auto", [](P& p) { p = parameters_for("auto"); });
  add("balanced over charts", [](P& p) { p.curve = ElementOrder::balanced; });
  add("elements", [](P& p) { p.locate = LocatorKind::elements; });
  add("direct", [](P& p) { p.method = MethodChoice::direct; });
  const auto by_formula = [](P& p, const char* formula) {
    p.density.kind = DensityKind::formula;
    p.density.formula = formula;
  };
  add("auto, linear formula", [&](P& p) {
    p = parameters_for("auto");
    by_formula(p, "100 + x + 0*mean");
  });
  add("auto, formula in pieces", [&](P& p) {
    p = parameters_for("auto");
    by_formula(p, "1 + sin(7*x)^2");
  });
  add("auto spaced", [](P& p) {
    p = parameters_for("auto");
    p.sequence = SequenceKind::spaced;
  });
  add("direct spaced, best, along", [](P& p) {
    p.method = MethodChoice::direct;
    p.sequence = SequenceKind::spaced;
    p.spacing = SpacingKind::best;
    p.order = OrderKind::curve;
  });
  add("auto relaxed", [](P& p) {
    p = parameters_for("auto");
    p.finish = FinishKind::relax;
  });
  add("anisotropic spaced", [](P& p) {
    p.method = MethodChoice::anisotropic;
    p.sequence = SequenceKind::spaced;
  });
  add("auto in blocks", [](P& p) {
    p = parameters_for("auto");
    p.rows_only = true;
  });
  add("direct in blocks, random", [](P& p) {
    p.method = MethodChoice::direct;
    p.sequence = SequenceKind::random;
    p.rows_only = true;
  });
  add("conformal in blocks", [](P& p) { p.rows_only = true; });
  add("direct certify", [](P& p) { p.method = MethodChoice::direct; });
  all.back().certify = true;
  add("auto without topology", [](P& p) {
    p = parameters_for("auto");
    p.topology = false;
  });
  add("direct without topology", [](P& p) {
    p.method = MethodChoice::direct;
    p.topology = false;
  });
  add("conformal curved certify", [](P& p) { p.curved = true; });
  all.back().certify = true;
  add("direct mean density, curved", [](P& p) {
    p.method = MethodChoice::direct;
    p.density.kind = DensityKind::mean;
    p.curved = true;
  });
  add("direct described", [](P& p) {
    p.method = MethodChoice::direct;
    p.describe.descriptors = {Descriptor::d2, Descriptor::a3,       Descriptor::d1,    Descriptor::d3,
                              Descriptor::d4, Descriptor::geodesic, Descriptor::basics};
    p.describe.geodesic_sources = 256;
  });
  add("auto, attributes and texture coordinates", [](P& p) {
    p = parameters_for("auto");
    p.attributes = {{"_PLACE", 3}, {"part", 1}, {"quality", 1}};
    p.columns[&Samples::texcoord] = true;
  });
  add("direct shape DNA", [](P& p) {
    p.method = MethodChoice::direct;
    p.describe.descriptors = {Descriptor::shapedna};
  });
  add("anisotropic", [](P& p) { p.method = MethodChoice::anisotropic; });
  add("anisotropic gradient", [](P& p) {
    p.method = MethodChoice::anisotropic;
    p.tensor_charts.form = AlignmentForm::gradient;
    p.tensor_charts.segment.count = 8;
  });
  return all;
}

struct Peak {
  double reserved = 0, measured = 0;
  std::string stage;   // that held the most
  double placing = 0;  // of place_samples
  double ratio() const { return measured / reserved; }
};

// The stage that --certify adds.
void certify(GraphItem& item) {
  release_charts(item.model);
  certify_samples(item.model.row, item.model.surface, item.model.cancel);
}

// What writing a row in blocks takes: as many blocks as there are threads, made and encoded.
void write_blocks(GraphItem& item, const PlaceParameters& place, int threads) {
  StoreHeader header;
  header.samples = place.samples;
  header.ids = {item.plan->id};
  header.labels = {-1};
  const store::RecordInParts record(header, 0, item.model.row.report);
  std::vector<store::RecordInParts::Part> made(std::min(static_cast<std::uint32_t>(threads), record.parts()));
  parallel_tasks(made.size(), [&](std::size_t i) {
    const auto part = static_cast<std::uint32_t>(i);
    made[i] = record.encode(part, samples_at(item.model, place, record.begin_of(part), record.end_of(part)));
  });
}

// One model through all stages, alone.
Peak peak_of(const fs::path& path, const Setting& setting, int threads, const EmbreeDevice& device) {
  const SampleParameters& parameters = setting.parameters;
  PlanItem plan;
  plan.id = path.filename().string();
  plan.path = path;
  REQUIRE(mesh_format_of(path, plan.format));
  GraphParameters graph;
  graph.sample = parameters;
  graph.threads = threads;
  GraphStages stages = sampling_stages(graph.sample, &device);
  if (setting.certify) stages.push_back({"certify_samples", certify});
  if (leaves_sites(parameters))
    stages.push_back(
        {"write_row", [&](GraphItem& item) { write_blocks(item, place_parameters(parameters), threads); }});
  Peak peak;
  peak.reserved = static_cast<double>(estimate_bytes(peek_mesh(path, plan.format), parameters, threads));
  const std::int64_t before = allocated_bytes();
  std::string_view running = "start";
  const auto entered = [&](std::string_view stage) {
    const auto most = static_cast<double>(peak_allocated_bytes() - before);
    if (most > peak.measured) {
      peak.measured = most;
      peak.stage = running;
    }
    if (running == "place_samples") peak.placing = most;
    running = stage;
    reset_peak();
  };
  reset_peak();
  run_item_alone(plan, graph, stages, entered);
  entered("end");
  return peak;
}

// Checks a setting over the models and reports how close the estimate was. Estimates that are far too high
// would leave threads without work: the models that come closest take a quarter of theirs.
void check_models(const std::vector<fs::path>& models, const Setting& setting, int threads,
                  const EmbreeDevice& device) {
  double highest = 0;
  std::vector<double> ratios;
  std::string of;
  Setting few = setting;
  few.parameters.samples = 64;
  peak_of(models.front(), few, threads, device);  // what threads and libraries take once
  for (const fs::path& path : models) {
    const Peak peak = peak_of(path, setting, threads, device);
    ratios.push_back(peak.ratio());
    if (peak.ratio() > highest) of = path.filename().string() + " in " + peak.stage;
    highest = std::max(highest, peak.ratio());
    INFO(setting.name << ", " << threads << " threads, " << path.filename() << ": " << peak.stage << " takes "
                      << peak.measured / 1048576 << " MiB of " << peak.reserved / 1048576);
    CHECK(peak.measured <= peak.reserved);
  }
  if (std::getenv("MEANDER_SHOW_MEMORY") != nullptr) {
    std::nth_element(ratios.begin(), ratios.begin() + ratios.size() / 2, ratios.end());
    std::printf("%-28s %2d threads: median %.2f, most %.2f (%s) of the reservation\n", setting.name.c_str(),
                threads, ratios[ratios.size() / 2], highest, of.c_str());
    std::fflush(stdout);
  }
  CHECK(highest >= 0.25);
}

void check_models(const std::vector<fs::path>& models, std::uint32_t samples) {
  const oneapi::tbb::global_control most(oneapi::tbb::global_control::max_allowed_parallelism, 16);
  const EmbreeDevice device;
  for (const Setting& setting : settings(samples))
    for (const int threads : thread_counts) {
      if (setting.slow() && threads != thread_counts.back()) continue;
      oneapi::tbb::task_arena arena(threads);
      arena.execute([&] { check_models(models, setting, threads, device); });
    }
}

}  // namespace

TEST_CASE("estimate_bytes: no generated mesh exceeds its reservation, every method, 1, 2 and 16 threads") {
  if (!counts_allocations()) {
    WARN("skipped: a sanitizer's malloc is not counted");
    return;
  }
  const ScratchFolder scratch;
  std::vector<fs::path> models;
  const auto add = [&](const char* name, const PolygonMesh& mesh) {
    models.push_back(scratch / name);
    write_mesh(models.back(), mesh);
  };
  add("tetrahedron.off", tetrahedron());
  add("sphere.ply", icosphere(5));
  add("torus.obj", torus(160, 60));
  add("plane.stl", grid_plane(70, 70));
  add("plate.off", two_sided_plate(40, 0.01));
  PolygonMesh many = icosphere(1);
  for (int i = 1; i < 60; ++i) many = merged(many, moved(icosphere(1), 1, 3.0 * i, 0, 0));
  add("many.off", many);
  // Many small triangles beside a few large ones: cells are cut exactly out of up to 16 triangles a sample.
  add("soup.obj", merged(moved(icosphere(5), 0.05, 3, 0, 0), cube()));
  check_models(models, 2048);
  check_models({models[0], models[2], models.back()}, 16384);
}

TEST_CASE("estimate_bytes: fine triangles in few cells beside large split ones stay within the reservation") {
  if (!counts_allocations()) {
    WARN("skipped: a sanitizer's malloc is not counted");
    return;
  }
  const ScratchFolder scratch;
  const oneapi::tbb::global_control most(oneapi::tbb::global_control::max_allowed_parallelism, 16);
  const EmbreeDevice device;
  // More triangles than are clipped; those of the ball are all in a block of the tree, with some of the cube.
  write_mesh(scratch / "ball.ply", merged(moved(icosphere(7), 0.03, 3, 0, 0), cube()));
  for (const bool topology : {true, false})
    for (const bool spaced : {false, true})
      for (const bool rows_only : {false, true})
        for (const int threads : {1, 16}) {
          Setting setting{topology ? "ball, few triangles split" : "the same without topology",
                          parameters_for("auto")};
          setting.parameters.topology = topology;
          setting.parameters.rows_only = rows_only;
          if (spaced) setting.parameters.sequence = SequenceKind::spaced;
          setting.parameters.samples = 2048;
          oneapi::tbb::task_arena(threads).execute(
              [&] { check_models({scratch / "ball.ply"}, setting, threads, device); });
        }
}

TEST_CASE("estimate_bytes: cells of long needles stay within the reservation, auto, shifted and spaced") {
  if (!counts_allocations()) {
    WARN("skipped: a sanitizer's malloc is not counted");
    return;
  }
  const ScratchFolder scratch;
  // The planes of the cells would part each of them again and again.
  const auto needles = [&](std::uint32_t count) {
    std::vector<double> xyz;
    std::vector<std::vector<std::uint32_t>> faces;
    for (std::uint32_t i = 0; i < count; ++i) {
      const double a = 0.61803398875 * i, b = 0.7548776662 * i, c = 0.5698402910 * i;
      const double x = a - std::floor(a), y = b - std::floor(b), z = c - std::floor(c);
      xyz.insert(xyz.end(), {x, y, z, y, z, x, y + 1e-3, z, x + 1e-3});
      faces.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    }
    const std::filesystem::path path = scratch / fmt::format("needles_{}.obj", count);
    write_mesh(path, polygon_mesh(xyz, faces));
    return path;
  };
  const EmbreeDevice device;
  const std::filesystem::path few = needles(5000), many = needles(16000);
  for (const SequenceKind sequence : {SequenceKind::shifted, SequenceKind::spaced})
    for (const std::uint32_t samples : {2048u, 4000u, 16384u})
      for (const int threads : {1, 2}) {
        if (sequence == SequenceKind::spaced && threads == 1) continue;  // slow, and as much memory
        Setting setting{"needles", parameters_for("auto")};
        setting.parameters.sequence = sequence;
        setting.parameters.samples = samples;
        oneapi::tbb::task_arena(threads).execute(
            [&] { check_models({samples == 2048 ? few : many}, setting, threads, device); });
      }
}

TEST_CASE("estimate_bytes: relaxed samples of 300 sheets that face both ways stay within the reservation") {
  if (!counts_allocations()) {
    WARN("skipped: a sanitizer's malloc is not counted");
    return;
  }
  // Each sample has all others near it, and may move.
  std::vector<double> xyz;
  std::vector<std::vector<std::uint32_t>> faces;
  for (std::uint32_t i = 0; i < 300; ++i) {
    const double z = 1e-6 * i;
    xyz.insert(xyz.end(), {0, 0, z, 1, 0, z, 1, 1, z, 0, 1, z});
    const std::uint32_t a = 4 * i;
    if (i % 2 == 0)
      faces.push_back({a, a + 1, a + 2, a + 3});
    else
      faces.push_back({a, a + 3, a + 2, a + 1});
  }
  const ScratchFolder scratch;
  write_mesh(scratch / "sheets.off", polygon_mesh(xyz, faces));
  Setting setting{"auto relaxed, sheets", parameters_for("auto")};
  setting.parameters.finish = FinishKind::relax;
  setting.parameters.samples = 2048;
  const EmbreeDevice device;
  oneapi::tbb::task_arena(2).execute([&] { check_models({scratch / "sheets.off"}, setting, 2, device); });
}

TEST_CASE("estimate_bytes: models with most triangles in one small part stay within the reservation") {
  if (!counts_allocations()) {
    WARN("skipped: a sanitizer's malloc is not counted");
    return;
  }
  const ScratchFolder scratch;
  PolygonMesh parts = cube();
  for (int k = 0; k < 3; ++k) parts = merged(moved(icosphere(5), 0.1, 3 + 0.3 * k, 0, 0), parts);
  write_mesh(scratch / "balls.obj", parts);  // 61,452 triangles
  const EmbreeDevice device;
  for (const int threads : {1, 2}) {
    Setting setting{"balls", parameters_for("auto")};
    setting.parameters.samples = 16384;
    oneapi::tbb::task_arena(threads).execute(
        [&] { check_models({scratch / "balls.obj"}, setting, threads, device); });
  }
}

TEST_CASE("estimate_bytes: never decreases with more vertices or triangles") {
  constexpr std::array<std::uint64_t, 9> counts = {0, 1, 12, 150, 700, 2000, 9000, 120000, 3000000};
  for (const std::uint32_t samples : {1u, 64u, 1024u, 5000u, 100000u, 500000u})
    for (const Setting& setting : settings(samples))
      for (const int threads : thread_counts) {
        const auto bytes = [&](std::uint64_t vertices, std::uint64_t triangles) {
          return estimate_bytes({.vertices = vertices, .triangles = triangles}, setting.parameters, threads);
        };
        bool grows = true;
        for (std::size_t i = 1; i < counts.size(); ++i)
          for (const std::uint64_t other : counts) {
            grows = grows && bytes(other, counts[i - 1]) <= bytes(other, counts[i]);
            grows = grows && bytes(counts[i - 1], other) <= bytes(counts[i], other);
          }
        INFO(setting.name << ", " << samples << " samples, " << threads << " threads");
        CHECK(grows);
      }
}

TEST_CASE("estimate_bytes: a ramp whose chart overlaps itself fifteen times stays within the reservation") {
  if (!counts_allocations()) {
    WARN("skipped: a sanitizer's malloc is not counted");
    return;
  }
  PolygonMesh ramp;
  constexpr std::uint32_t turns = 15, steps = 48, rows = 4;
  for (std::uint32_t i = 0; i <= turns * steps; ++i)
    for (std::uint32_t k = 0; k <= rows; ++k) {
      const double at = 2 * std::numbers::pi * i / steps, radius = 1 + static_cast<double>(k) / rows;
      ramp.x.push_back(radius * std::cos(at));
      ramp.y.push_back(radius * std::sin(at));
      ramp.z.push_back(0.002 * at);
    }
  ramp.polygon_begin = {0};
  for (std::uint32_t i = 0; i < turns * steps; ++i)
    for (std::uint32_t k = 0; k < rows; ++k) {
      const std::uint32_t a = i * (rows + 1) + k, b = a + 1, c = a + rows + 1, d = c + 1;
      ramp.corners.insert(ramp.corners.end(), {a, c, b, b, c, d});
      const std::uint32_t begin = ramp.polygon_begin.back();
      ramp.polygon_begin.insert(ramp.polygon_begin.end(), {begin + 3, begin + 6});
    }
  const ScratchFolder scratch;
  write_mesh(scratch / "ramp.off", ramp);
  const EmbreeDevice device;
  for (const std::uint32_t samples : {20000u, 131072u})
    for (const int threads : {1, 2}) {
      if (samples > 20000 && threads == 1) continue;
      Setting setting{"ramp", parameters_for("conformal")};
      setting.parameters.samples = samples;
      oneapi::tbb::task_arena(threads).execute(
          [&] { check_models({scratch / "ramp.off"}, setting, threads, device); });
    }
}

TEST_CASE("estimate_bytes: models with attributes and texture coordinates stay within the reservation") {
  if (!counts_allocations()) {
    WARN("skipped: a sanitizer's malloc is not counted");
    return;
  }
  const ScratchFolder scratch;
  const PolygonMesh surface = torus(160, 60);
  PolygonMesh numbered = surface;
  numbered.vertex_attributes = {{"quality", surface.x}, {"wide_0", surface.y}, {"wide_1", surface.z}};
  write_mesh(scratch / "attributes.ply", numbered);
  // Each corner has texture coordinates of its own, as atlases of many charts have.
  std::string text;
  for (std::size_t v = 0; v < surface.vertex_count(); ++v)
    text += fmt::format("v {} {} {}\n", surface.x[v], surface.y[v], surface.z[v]);
  for (std::size_t k = 0; k < surface.corners.size(); ++k) text += fmt::format("vt 0.{} 0.5\n", k);
  for (std::size_t k = 0; k + 2 < surface.corners.size(); k += 3)
    text += fmt::format("f {}/{} {}/{} {}/{}\n", surface.corners[k] + 1, k + 1, surface.corners[k + 1] + 1,
                        k + 2, surface.corners[k + 2] + 1, k + 3);
  write_file(scratch / "atlas.obj", text);
  GltfFile file;
  std::vector<float> places, coordinates;
  for (std::size_t v = 0; v < surface.vertex_count(); ++v) {
    for (const double value : {surface.x[v], surface.y[v], surface.z[v]})
      places.push_back(static_cast<float>(value));
    coordinates.insert(coordinates.end(), {places[3 * v], places[3 * v + 1]});
  }
  file.add_points(places);
  file.add_indices(surface.corners);
  file.add_accessor(file.add_view(places), 5126, surface.vertex_count(), "VEC3");
  file.add_accessor(file.add_view(coordinates), 5126, surface.vertex_count(), "VEC2");
  write_file(scratch / "attributes.glb",
             file.glb(R"(,"meshes":[{"primitives":[{"attributes":{"POSITION":0,"_PLACE":2,"TEXCOORD_0":3},)"
                      R"("indices":1}]}],"nodes":[{"mesh":0}])"));
  const std::vector<fs::path> models = {scratch / "attributes.ply", scratch / "atlas.obj",
                                        scratch / "attributes.glb"};
  const EmbreeDevice device;
  for (const std::uint32_t samples : {1u, 2048u, 50000u}) {
    Setting setting{"attributes", parameters_for("auto")};
    setting.parameters.samples = samples;
    setting.parameters.attributes = {{"_PLACE", 3}, {"part", 1}, {"quality", 1}, {"wide", 2}};
    setting.parameters.columns[&Samples::texcoord] = true;
    oneapi::tbb::task_arena(1).execute([&] { check_models(models, setting, 1, device); });
  }
}

TEST_CASE("estimate_bytes: glTF copies, instances and morph targets stay within the reservation") {
  if (!counts_allocations()) {
    WARN("skipped: a sanitizer's malloc is not counted");
    return;
  }
  const ScratchFolder scratch;
  const auto points_of = [](const PolygonMesh& mesh) {
    std::vector<float> points;
    for (std::size_t v = 0; v < mesh.vertex_count(); ++v)
      for (const double value : {mesh.x[v], mesh.y[v], mesh.z[v]})
        points.push_back(static_cast<float>(value));
    return points;
  };
  const PolygonMesh small = icosphere(1), large = torus(300, 100);
  GltfFile copies;
  copies.add_points(points_of(small));
  copies.add_indices(small.corners);
  std::vector<float> places, turns;
  for (int i = 0; i < 2000; ++i) {
    places.insert(places.end(), {3.0F * static_cast<float>(i % 50), 3.0F * static_cast<float>(i / 50), 1});
    turns.insert(turns.end(), {0, 0, 1, static_cast<float>(i)});
  }
  copies.add_points(places);
  copies.add_accessor(copies.add_view(turns), 5126, 2000, "VEC4");
  const std::string mesh = R"(,"meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}])";
  write_file(scratch / "instances.glb",
             copies.glb(mesh + R"(,"nodes":[{"mesh":0,"extensions":{"EXT_mesh_gpu_instancing":{"attributes":)"
                               R"({"TRANSLATION":2,"ROTATION":3}}}}])"));
  std::string nodes;  // ten levels, each with two nodes that have both nodes of the next as children
  for (int level = 0; level < 10; ++level)
    for (int k = 0; k < 2; ++k)
      nodes += fmt::format(
          R"({{"translation":[{},{},0],"children":{}}},)", k * (3 << level), k,
          level == 9 ? std::string("[20]") : fmt::format("[{},{}]", 2 * level + 2, 2 * level + 3));
  write_file(scratch / "copies.glb", copies.glb(mesh + ",\"nodes\":[" + nodes + R"({"mesh":0}])"));
  GltfFile morph;
  morph.add_points(points_of(large));
  morph.add_indices(large.corners);
  write_file(scratch / "morph.glb",
             morph.glb(R"(,"meshes":[{"weights":[0.5,0.25],"primitives":[{"attributes":{"POSITION":0},)"
                       R"("indices":1,"targets":[{"POSITION":0},{"POSITION":0}]}]}],"nodes":[{"mesh":0}])"));
  const EmbreeDevice device;
  for (const char* const method : {"auto", "conformal"}) {
    Setting setting{"at rest", parameters_for(method)};
    setting.parameters.samples = 2048;
    oneapi::tbb::task_arena(1).execute([&] {
      check_models({scratch / "morph.glb", scratch / "copies.glb", scratch / "instances.glb"}, setting, 1,
                   device);
    });
  }
}

TEST_CASE("estimate_bytes: a small glTF file that declares many copies is too large before it is read") {
  GltfFile file;
  file.add_points(gltf_cube_points);
  file.add_indices(gltf_cube_indices);
  file.add_accessor(-1, 5126, 10000000, "VEC3");
  const std::string instances = file.glb(
      R"(,"meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],"nodes":[{"mesh":0,"extensions":)"
      R"({"EXT_mesh_gpu_instancing":{"attributes":{"TRANSLATION":2}}}}])");
  SampleParameters parameters = parameters_for("auto");
  parameters.samples = 2048;
  CHECK(estimate_bytes(peek_mesh(MemorySource(instances), MeshFormat::gltf), parameters, 1) > std::uint64_t{8}
                                                                                                  << 30);
}

TEST_CASE("read_mesh: memory for images is reserved by their headers, before they are decoded") {
  const ScratchFolder scratch;
  const TestImage image(1500, 1000, [](std::uint32_t x, std::uint32_t y) {
    return std::vector<int>{static_cast<int>(x / 8), static_cast<int>(y / 8), 90};
  });
  constexpr double pixels = 1500.0 * 1000;
  write_file(scratch / "image.png", png_bytes(image));
  write_file(scratch / "m.mtl", "newmtl m\nmap_Kd image.png\n");
  write_file(scratch / "png.obj",
             "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl m\nf 1/1 2/2 3/3\n");
  GltfFile file;
  file.add_points({0, 0, 0, 1, 0, 0, 0, 1, 0});
  file.add_accessor(file.add_view(std::vector<float>{0, 0, 1, 0, 0, 1}), 5126, 3, "VEC2");
  const int view = file.add_view(jpeg_bytes(image, {true, false, false}));
  write_file(
      scratch / "jpeg.glb",
      file.glb(R"(,"meshes":[{"primitives":[{"attributes":{"POSITION":0,"TEXCOORD_0":1},"material":0}]}],)"
               R"("nodes":[{"mesh":0}],"textures":[{"source":0}],"images":[{"bufferView":)" +
               std::to_string(view) +
               R"(}],"materials":[{"pbrMetallicRoughness":{"baseColorTexture":{"index":0}}}])"));
  for (const auto& [name, density] : {std::pair{"png.obj", DensityKind::uniform},
                                      {"jpeg.glb", DensityKind::uniform},
                                      {"png.obj", DensityKind::texture},
                                      {"jpeg.glb", DensityKind::texture_inverse}}) {
    SampleParameters parameters = parameters_for("auto");
    parameters.samples = 512;
    parameters.columns[&Samples::rgb] = true;
    parameters.density.kind = density;
    const GraphStages stages = sampling_stages(parameters, nullptr);
    PlanItem plan;
    plan.path = scratch / name;
    REQUIRE(mesh_format_of(plan.path, plan.format));
    plan.reserved_bytes = estimate_bytes(peek_mesh(plan.path, plan.format), parameters,
                                         oneapi::tbb::this_task_arena::max_concurrency());
    GraphItem item;
    item.plan = &plan;
    item.reserved_bytes = plan.reserved_bytes;
    std::uint64_t needed = 0;
    const std::int64_t before = allocated_bytes();
    reset_peak();
    try {
      stages[0].body(item);
    } catch (const NeedsMoreMemory& more) {
      needed = more.bytes();
    }
    INFO(name);
    if (counts_allocations()) CHECK(static_cast<double>(peak_allocated_bytes() - before) < 3 * pixels);
    CHECK(static_cast<double>(needed) >= static_cast<double>(plan.reserved_bytes) + 3 * pixels);

    GraphItem again;
    again.plan = &plan;
    again.reserved_bytes = needed;
    reset_peak();
    for (const GraphStage& stage : stages) stage.body(again);
    CHECK(again.model.row.report.color_source == ColorSource::texture);
    CHECK(again.model.measure.density.in_pieces() == reads_textures(density));
    if (counts_allocations()) CHECK(peak_allocated_bytes() - before <= static_cast<std::int64_t>(needed));
  }
}

TEST_CASE("estimate_bytes: large sets in regions stay within the reservation", "[slow]") {
  if (!counts_allocations()) {
    WARN("skipped: a sanitizer's malloc is not counted");
    return;
  }
  const ScratchFolder scratch;
  const std::vector<fs::path> models = {scratch / "torus.off"};
  write_mesh(models[0], torus(400, 200));
  const oneapi::tbb::global_control most(oneapi::tbb::global_control::max_allowed_parallelism, 2);
  const EmbreeDevice device;
  for (const Setting& setting : settings(2000000)) {
    if (!places_in_regions(setting.parameters) || !setting.parameters.describe.descriptors.empty()) continue;
    for (const int threads : {1, 2})
      oneapi::tbb::task_arena(threads).execute([&] { check_models(models, setting, threads, device); });
  }
}

TEST_CASE("estimate_bytes: no shared model exceeds its reservation, every method, 1, 2 and 16 threads",
          "[slow]") {
  MEANDER_NEEDS_SHARED_DATA();
  if (!counts_allocations()) {
    WARN("skipped: a sanitizer's malloc is not counted");
    return;
  }
  std::vector<fs::path> models;
  for (const char* folder : {"paper", "retrieval", "dirty"})
    for (const auto& entry : fs::recursive_directory_iterator(shared_data(folder))) {
      MeshFormat format{};
      if (entry.is_regular_file() && mesh_format_of(entry.path(), format)) models.push_back(entry.path());
    }
  std::sort(models.begin(), models.end());
  check_models(models, 2048);
}

TEST_CASE("estimate_bytes: a million spaced samples stay within the reservation", "[slow]") {
  if (!counts_allocations()) {
    WARN("skipped: a sanitizer's malloc is not counted");
    return;
  }
  const ScratchFolder scratch;
  const fs::path path = scratch / "torus.ply";
  write_mesh(path, torus(160, 60));
  const oneapi::tbb::global_control most(oneapi::tbb::global_control::max_allowed_parallelism, 2);
  const EmbreeDevice device;
  constexpr std::uint32_t samples = 1000000;
  for (const char* const method : {"auto", "direct"})
    for (const OrderKind order : {OrderKind::progressive, OrderKind::curve})
      for (const SequenceKind sequence : {SequenceKind::shifted, SequenceKind::spaced})
        for (const int threads : {1, 2}) {
          Setting setting{method, parameters_for(method)};
          setting.parameters.sequence = sequence;
          setting.parameters.order = order;
          setting.parameters.samples = samples;
          oneapi::tbb::task_arena arena(threads);
          const Peak peak = arena.execute([&] { return peak_of(path, setting, threads, device); });
          INFO(method << (order == OrderKind::curve ? ", along" : ", progressive")
                      << (sequence == SequenceKind::spaced ? ", spaced, " : ", shifted, ") << threads
                      << " threads: " << peak.stage << " takes " << peak.measured / samples
                      << " bytes a sample of " << peak.reserved / samples << "; place_samples "
                      << peak.placing / samples);
          CHECK(peak.measured <= peak.reserved);
          CHECK(peak.ratio() >= 0.25);
        }
}
