// `run --attribute`, `--texcoord` and `--store` as a user sees them: values, counts, what is missing, and all
// that is done with such stores.
#include <fmt/format.h>

#include <cmath>
#include <csignal>
#include <filesystem>

#include "io/store/store_reader.h"
#include "support/archive_files.h"
#include "support/catch.h"
#include "support/fault_program.h"
#include "support/gltf_files.h"
#include "support/meander_program.h"
#include "support/mesh_files.h"
#include "support/store_rows.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;
using Catch::Matchers::ContainsSubstring;

namespace {

namespace fs = std::filesystem;
using Words = std::vector<std::string>;

constexpr std::size_t points_each = 300;

ProcessResult run_columns(const fs::path& input, const fs::path& store, const Words& more) {
  Words arguments = {"run", input.string(), "-o", store.string(), "-n", "300", "--progress", "none"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return meander_with(arguments);
}

double file_coordinate(const Row& row, std::size_t i, std::size_t axis) {
  return row.report.loc[axis] + row.report.scale * static_cast<double>(row.samples.points[3 * i + axis]);
}

// x + 2 y - z at the vertices as `quality`, (x, y, z) as `flow`, and the number of each face.
PolygonMesh with_linear_attributes(PolygonMesh mesh) {
  std::vector<double> quality, number;
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v)
    quality.push_back(mesh.x[v] + 2 * mesh.y[v] - mesh.z[v]);
  for (std::size_t f = 0; f < mesh.polygon_count(); ++f) number.push_back(static_cast<double>(f));
  mesh.vertex_attributes = {{"quality", quality}, {"flow_0", mesh.x}, {"flow_1", mesh.y}, {"flow_2", mesh.z}};
  mesh.face_attributes = {{"number", number}, {"quality", number}};
  return mesh;
}

// A cube with texture coordinates of its own on each side: (x, y) of the face's first two changing axes would
// need a formula per side; here u, v of a corner are 1/4 of its place in the polygon.
constexpr const char* textured_cube =
    "v -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\nv -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1\n"
    "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
    "f 4/1 3/2 2/3 1/4\nf 1/1 2/2 6/3 5/4\nf 2/1 3/2 7/3 6/4\nf 3/1 4/2 8/3 7/4\nf 4/1 1/2 5/3 8/4\n"
    "f 5/1 6/2 7/3 8/4\n";

GltfFile cube_with_attributes() {
  GltfFile file;
  file.add_points(gltf_cube_points);
  file.add_indices(gltf_cube_indices);
  std::vector<float> heat, coordinates;
  for (std::size_t v = 0; v < 8; ++v) {
    const float* const p = gltf_cube_points.data() + 3 * v;
    heat.push_back(p[0] + 2 * p[1] - p[2]);
    coordinates.insert(coordinates.end(), {p[0], 1 - p[1]});
  }
  file.add_accessor(file.add_view(heat), 5126, 8, "SCALAR");
  file.add_accessor(file.add_view(gltf_cube_points), 5126, 8, "VEC3");
  file.add_accessor(file.add_view(coordinates), 5126, 8, "VEC2");
  return file;
}

std::string gltf_cube() {
  return cube_with_attributes().glb(
      R"(,"meshes":[{"primitives":[{"attributes":{"POSITION":0,"_HEAT":2,"_PLACE":3,"TEXCOORD_0":4},)"
      R"("indices":1},{"attributes":{"POSITION":0,"_HEAT":2,"_PLACE":3,"TEXCOORD_0":4},"indices":1}]}],)"
      R"("nodes":[{"mesh":0}])");
}

void put_models(const fs::path& folder) {
  fs::create_directories(folder);
  write_mesh(folder / "ascii.ply", with_linear_attributes(icosphere(2)), MeshFile::ply_ascii);
  write_mesh(folder / "big.ply", with_linear_attributes(icosphere(2)), MeshFile::ply_big_endian);
  write_mesh(folder / "little.ply", with_linear_attributes(icosphere(2)), MeshFile::ply_little_endian);
  write_file(folder / "cube.glb", gltf_cube());
  write_file(folder / "cube.obj", textured_cube);
  write_mesh(folder / "plain.stl", cube());
  write_file(folder / "broken.off", "OFF\nnothing\n");
}

const Words all_columns = {"--attribute", "quality", "--attribute", "flow:3,number", "--attribute", "part",
                           "--attribute", "_HEAT",   "--attribute", "_PLACE:3",      "--texcoord"};
// Ascending: _HEAT, _PLACE, flow, number, part, quality.
enum Place : std::size_t { heat, place, flow, number, part, quality };

Words joined(Words words, const Words& more) {
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

bool all_nan(const std::vector<float>& values) {
  return std::all_of(values.begin(), values.end(), [](float v) { return std::isnan(v); });
}

void require_verified(const fs::path& store) {
  const ProcessResult result = meander_with({"verify", store.string()});
  INFO(result.out << result.err);
  REQUIRE(result.exit_code == 0);
}

// The unit square in two triangles, labeled 1 where x is 0 and 40 where it is 1, with x as `weight` and the
// kinds 5 and 6 of the faces.
std::string labeled_head(const std::string& format, const std::string& type) {
  return "ply\nformat " + format + " 1.0\nelement vertex 4\nproperty float x\nproperty float y\n" +
         "property float z\nproperty " + type + " label\nproperty float weight\nelement face 2\n" +
         "property list uchar int vertex_indices\nproperty " + type + " kind\nend_header\n";
}

std::string labeled_square(const std::string& type) {
  return labeled_head("ascii", type) + "0 0 0 1 0\n1 0 0 40 1\n1 1 0 40 1\n0 1 0 1 0\n3 0 1 2 5\n3 0 2 3 6\n";
}

std::string labeled_binary(const std::string& type) {
  std::string data = labeled_head("binary_little_endian", type);
  const auto add = [&](auto value) { data.append(reinterpret_cast<const char*>(&value), sizeof value); };
  const std::size_t bytes = type.ends_with("char") ? 1 : type.ends_with("short") ? 2 : 4;
  const auto number = [&](std::uint32_t value) { data.append(reinterpret_cast<const char*>(&value), bytes); };
  for (const auto& [x, y] : std::vector<std::pair<float, float>>{{0, 0}, {1, 0}, {1, 1}, {0, 1}}) {
    for (const float value : {x, y, 0.f}) add(value);
    number(x == 0 ? 1 : 40);
    add(x);
  }
  for (const std::uint32_t face : {0u, 1u}) {
    add(std::uint8_t{3});
    for (const std::uint32_t corner : {0u, face + 1, face + 2}) add(corner);
    number(face + 5);
  }
  return data;
}

}  // namespace

TEST_CASE("run --attribute: PLY properties of every type, linear functions and face numbers") {
  const ScratchFolder scratch;
  put_models(scratch / "in");
  const ProcessResult result = run_columns(scratch / "in", scratch / "s.h5", all_columns);
  INFO(result.out << result.err);
  REQUIRE(result.exit_code == 3);  // the broken file
  require_verified(scratch / "s.h5");
  CHECK(StoreReader(scratch / "s.h5").columns().chosen_count() == 7);
  for (const char* id : {"ascii.ply", "big.ply", "little.ply"}) {
    const Row row = row_of(scratch / "s.h5", id);
    const auto& attributes = row.samples.attributes;
    REQUIRE(attributes.size() == 6);
    for (std::size_t i = 0; i < points_each; ++i) {
      const double expected =
          file_coordinate(row, i, 0) + 2 * file_coordinate(row, i, 1) - file_coordinate(row, i, 2);
      CHECK(std::abs(attributes[quality][i] - expected) < 1e-5);
      for (std::size_t k = 0; k < 3; ++k)
        CHECK(std::abs(attributes[flow][3 * i + k] - file_coordinate(row, i, k)) < 1e-5);
      CHECK(attributes[number][i] == static_cast<float>(row.samples.face[i]));
    }
    for (const std::size_t lacking : {heat, place}) CHECK(all_nan(attributes[lacking]));
    CHECK(row.samples.classes[part] == std::vector<std::int32_t>(points_each, no_sample_class));
    CHECK(all_nan(row.samples.texcoord));
    CHECK(row.report.lacks == (1u << heat | 1u << place | 1u << part | 1u << 6));
  }
}

TEST_CASE("run --attribute: glTF attributes and primitive numbers") {
  const ScratchFolder scratch;
  put_models(scratch / "in");
  REQUIRE(run_columns(scratch / "in", scratch / "s.h5", all_columns).exit_code == 3);
  const Row row = row_of(scratch / "s.h5", "cube.glb");
  const auto& attributes = row.samples.attributes;
  for (std::size_t i = 0; i < points_each; ++i) {
    const double x = file_coordinate(row, i, 0), y = file_coordinate(row, i, 1),
                 z = file_coordinate(row, i, 2);
    CHECK(std::abs(attributes[heat][i] - (x + 2 * y - z)) < 1e-6);
    CHECK(std::abs(attributes[place][3 * i + 1] - y) < 1e-6);
    CHECK(row.samples.classes[part][i] == (row.samples.face[i] < 12 ? 0 : 1));
    CHECK(std::abs(row.samples.texcoord[2 * i] - x) < 1e-6);
    CHECK(std::abs(row.samples.texcoord[2 * i + 1] - (1 - y)) < 1e-6);
  }
  CHECK(row.report.lacks == (1u << flow | 1u << number | 1u << quality));
}

TEST_CASE("run --texcoord: each side of a cube has its own coordinates, with and without --colors") {
  const ScratchFolder scratch;
  put_models(scratch / "in");
  REQUIRE(run_columns(scratch / "in", scratch / "s.h5", {"--texcoord"}).exit_code == 3);
  REQUIRE(run_columns(scratch / "in", scratch / "colored.h5", {"--texcoord", "--colors"}).exit_code == 3);
  REQUIRE(run_columns(scratch / "in", scratch / "plain.h5", {}).exit_code == 3);
  require_verified(scratch / "colored.h5");
  const Row row = row_of(scratch / "s.h5", "cube.obj");
  // The corners of the sides in the order of their coordinates (0, 0), (1, 0), (1, 1), (0, 1).
  const int sides[6][4] = {{3, 2, 1, 0}, {0, 1, 5, 4}, {1, 2, 6, 5},
                           {2, 3, 7, 6}, {3, 0, 4, 7}, {4, 5, 6, 7}};
  const int corners[8][3] = {{-1, -1, -1}, {1, -1, -1}, {1, 1, -1}, {-1, 1, -1},
                             {-1, -1, 1},  {1, -1, 1},  {1, 1, 1},  {-1, 1, 1}};
  for (std::size_t i = 0; i < points_each; ++i) {
    const int* const side = sides[row.samples.face[i]];
    const double u = row.samples.texcoord[2 * i], v = row.samples.texcoord[2 * i + 1];
    for (std::size_t k = 0; k < 3; ++k) {
      const double from = corners[side[0]][k], along = corners[side[1]][k], up = corners[side[3]][k];
      CHECK(std::abs(from + u * (along - from) + v * (up - from) - file_coordinate(row, i, k)) < 1e-5);
    }
  }
  CHECK(row.report.lacks == 0);
  for (const char* id : {"cube.obj", "cube.glb", "plain.stl"}) {
    const Row plain = row_of(scratch / "plain.h5", id), colored = row_of(scratch / "colored.h5", id),
              mapped = row_of(scratch / "s.h5", id);
    CHECK(plain.samples.points == mapped.samples.points);
    CHECK(plain.samples.points == colored.samples.points);
    CHECK(std::memcmp(mapped.samples.texcoord.data(), colored.samples.texcoord.data(), 8 * points_each) == 0);
  }
}

TEST_CASE("run --attribute: missing attributes are counted by column, in the summary and in info") {
  const ScratchFolder scratch;
  put_models(scratch / "in");
  const ProcessResult result =
      run_columns(scratch / "in", scratch / "s.h5", {"--attribute", "quality", "--texcoord"});
  CHECK_THAT(result.out, ContainsSubstring("3 models lack attribute `quality`, at some or all points") &&
                             ContainsSubstring("4 models lack texture coordinates"));
  const ProcessResult again =
      run_columns(scratch / "in", scratch / "s.h5", {"--texcoord", "--attribute", "quality", "--json"});
  CHECK(again.exit_code == 3);
  CHECK_THAT(again.out,
             ContainsSubstring(R"("items_that_lack":{"attribute `quality`":3,"texture coordinates":4})"));
  const ProcessResult info = meander_with({"info", scratch / "s.h5"});
  CHECK_THAT(info.out,
             ContainsSubstring("columns points, normals, face_index, corners, barycentric, curve_rank, density, "
                               "texcoord, attributes/quality") &&
                 ContainsSubstring("3 models lack attribute `quality`"));
  CHECK_THAT(
      meander_with({"info", scratch / "s.h5", "--json"}).out,
      ContainsSubstring(R"("texcoord","attributes/quality"])") && ContainsSubstring("items_that_lack"));
  CHECK_THAT(meander_with({"info", scratch / "s.h5", "cube.obj"}).out,
             ContainsSubstring("lacks             attributes/quality\n"));
  CHECK_THAT(meander_with({"info", scratch / "s.h5", "plain.stl", "--json"}).out,
             ContainsSubstring(R"("lacks":["attributes/quality","texcoord"])"));
}

TEST_CASE("run --attribute: threads, archives, kills and a second run give the same bytes") {
  const ScratchFolder scratch;
  put_models(scratch / "in/set");
  const Words words = joined(all_columns, {"--store", "points,normals,face,texcoord"});
  REQUIRE(run_columns(scratch / "in/set", scratch / "one.h5", joined(words, {"-j", "1"})).exit_code == 3);
  const std::string expected = read_file(scratch / "one.h5");
  REQUIRE(run_columns(scratch / "in/set", scratch / "two.h5", joined(words, {"-j", "4"})).exit_code == 3);
  CHECK(read_file(scratch / "two.h5") == expected);
  REQUIRE(run_columns(scratch / "in/set", scratch / "two.h5", words).exit_code == 3);
  CHECK(read_file(scratch / "two.h5") == expected);
  fs::create_directories(scratch / "zip");
  write_file(scratch / "zip/set.zip", zip_bytes(entries_of(scratch / "in/set")));
  REQUIRE(run_columns(scratch / "zip/set.zip", scratch / "zip.h5", words).exit_code == 3);
  CHECK(read_file(scratch / "zip.h5") == expected);

  ProcessOptions killed;
  killed.environment = {{"MEANDER_TEST_FAULT", "kill:plain"}};
  const Words command = {fault_program,
                         "run",
                         (scratch / "in/set").string(),
                         "-o",
                         (scratch / "killed.h5").string(),
                         "-n",
                         "300",
                         "--progress",
                         "none",
                         "-j",
                         "1"};
  REQUIRE(run_process(joined(command, words), killed).signal == SIGKILL);
  REQUIRE(run_process(joined(command, words)).exit_code == 3);
  CHECK(read_file(scratch / "killed.h5") == expected);
}

TEST_CASE("run --attribute: array shards and merged stores give the same bytes") {
  const ScratchFolder scratch;
  put_models(scratch / "in");
  REQUIRE(run_columns(scratch / "in", scratch / "one.h5", all_columns).exit_code == 3);
  Words plan = {
      "plan", (scratch / "in").string(), "-o", (scratch / "array.h5").string(), "-n", "300", "--shards", "3"};
  const ProcessResult planned = meander_with(joined(plan, all_columns));
  INFO(planned.out << planned.err);
  REQUIRE(planned.exit_code == 0);
  const std::string folder = (scratch / "array.h5.run").string();
  for (const char* shard : {"0/3", "1/3", "2/3"}) {
    const int code = meander_with({"run", folder, "--shard", shard, "--progress", "none"}).exit_code;
    CHECK((code == 0 || code == 3));
  }
  REQUIRE(meander_with({"merge", folder}).exit_code == 3);  // broken.off
  CHECK(read_file(scratch / "array.h5") == read_file(scratch / "one.h5"));

  put_models(scratch / "first");
  put_models(scratch / "second");
  for (const char* id : {"ascii.ply", "big.ply", "broken.off"}) fs::remove(scratch / "first" / id);
  for (const char* id : {"little.ply", "cube.glb", "cube.obj", "plain.stl"})
    fs::remove(scratch / "second" / id);
  REQUIRE(run_columns(scratch / "first", scratch / "a.h5", all_columns).exit_code == 0);
  REQUIRE(run_columns(scratch / "second", scratch / "b.h5", all_columns).exit_code == 3);
  const ProcessResult merged =
      meander_with({"merge", scratch / "a.h5", scratch / "b.h5", "-o", scratch / "merged.h5"});
  INFO(merged.out << merged.err);
  REQUIRE(merged.exit_code == 3);
  CHECK(read_file(scratch / "merged.h5") == read_file(scratch / "one.h5"));
  REQUIRE(run_columns(scratch / "second", scratch / "c.h5", {"--texcoord"}).exit_code == 3);
  const ProcessResult refused =
      meander_with({"merge", scratch / "a.h5", scratch / "c.h5", "-o", scratch / "no.h5"});
  CHECK(refused.exit_code == 2);
  CHECK_THAT(refused.err, ContainsSubstring("attributes"));
}

TEST_CASE("run --attribute: a store is continued, and reused, only with the same columns") {
  const ScratchFolder scratch;
  put_models(scratch / "in");
  REQUIRE(run_columns(scratch / "in", scratch / "old.h5", all_columns).exit_code == 3);
  const std::string expected = read_file(scratch / "old.h5");
  for (const Words& other : {Words{}, Words{"--texcoord"}, joined(all_columns, {"--store", "normals"})}) {
    CHECK(run_columns(scratch / "in", scratch / "old.h5", other).exit_code == 2);
    const ProcessResult reused =
        run_columns(scratch / "in", scratch / "new.h5", joined(other, {"--reuse", scratch / "old.h5"}));
    CHECK(reused.exit_code == 2);
    CHECK_THAT(reused.err, ContainsSubstring("--reuse"));
  }
  REQUIRE(
      run_columns(scratch / "in", scratch / "new.h5", joined(all_columns, {"--reuse", scratch / "old.h5"}))
          .exit_code == 3);
  CHECK(read_file(scratch / "new.h5") == expected);
  fs::remove(scratch / "in/plain.stl");
  const ProcessResult vanished =
      run_columns(scratch / "in", scratch / "new.h5", joined(all_columns, {"--retry", "vanished"}));
  INFO(vanished.out << vanished.err);
  CHECK(vanished.exit_code == 3);
  REQUIRE(run_columns(scratch / "in", scratch / "less.h5", all_columns).exit_code == 3);
  CHECK(read_file(scratch / "new.h5") == read_file(scratch / "less.h5"));
}

TEST_CASE("run --attribute: invalid names are usage errors, all reported at once") {
  const ScratchFolder scratch;
  put_models(scratch / "in");
  const ProcessResult result =
      run_columns(scratch / "in", scratch / "s.h5",
                  {"--attribute", "a/b", "--attribute", "x:7", "--attribute", "twice", "--attribute",
                   "twice:2", "--attribute", ":3", "--attribute", "..", "--store", "tensor,rgb,uv,normals"});
  CHECK(result.exit_code == 2);
  CHECK_THAT(result.err, ContainsSubstring("`a/b` has `/` in its name") &&
                             ContainsSubstring("`x:7` has `7` behind its name") &&
                             ContainsSubstring("`twice` is named more than once") &&
                             ContainsSubstring("has no name") && ContainsSubstring("by dots alone") &&
                             ContainsSubstring("`tensor` needs --method anisotropic") &&
                             ContainsSubstring("`rgb` needs --colors") &&
                             ContainsSubstring("only parametric surfaces have `uv`"));
  Words many;
  for (int i = 0; i < 32; ++i) many = joined(many, {"--attribute", fmt::format("a{}", i)});
  const ProcessResult full = run_columns(scratch / "in", scratch / "full.h5", many);
  CHECK(full.exit_code == 3);
  require_verified(scratch / "full.h5");
  const ProcessResult more = run_columns(scratch / "in", scratch / "more.h5", joined(many, {"--texcoord"}));
  CHECK(more.exit_code == 2);
  CHECK_THAT(more.err, ContainsSubstring("33 columns"));
  CHECK(run_columns(scratch / "in", scratch / "s.h5", {"--store", "colour"}).exit_code == 2);
}

TEST_CASE("run --attribute: integers at vertices are classes, taken from the nearest corner") {
  const ScratchFolder scratch;
  for (const bool binary : {false, true}) {
    const fs::path folder = scratch / (binary ? "binary" : "ascii");
    fs::create_directories(folder);
    for (const char* type : {"char", "uchar", "short", "ushort", "int", "uint"})
      write_file(folder / (std::string(type) + ".ply"), binary ? labeled_binary(type) : labeled_square(type));
    const fs::path store = folder.string() + ".h5";
    const ProcessResult result =
        run_columns(folder, store, {"--attribute", "label", "--attribute", "weight", "--attribute", "kind"});
    INFO(result.out << result.err);
    REQUIRE(result.exit_code == 0);
    require_verified(store);
    const StoreReader reader(store);
    REQUIRE(reader.columns().attributes == std::vector<AttributeColumn>{{"kind", 1, AttributeKind::classes},
                                                                        {"label", 1, AttributeKind::classes},
                                                                        {"weight", 1}});
    CHECK_THAT(reader.parameters_json(),
               ContainsSubstring(R"("attributes":"kind:class,label:class,weight")"));
    for (std::uint64_t n = 0; n < reader.rows(); ++n) {
      const Row row = reader.read_row(n);
      INFO(reader.id(n));
      for (std::size_t i = 0; i < points_each; ++i) {
        const double b1 = row.samples.barycentric[2 * i], b2 = row.samples.barycentric[2 * i + 1],
                     b0 = 1 - b1 - b2;
        const std::size_t corner = b0 >= b1 && b0 >= b2 ? 0 : b1 >= b2 ? 1 : 2;
        const std::uint32_t v = row.samples.corners[3 * i + corner];
        CHECK(row.samples.classes[1][i] == (v == 0 || v == 3 ? 1 : 40));
        CHECK(row.samples.classes[0][i] == static_cast<std::int32_t>(row.samples.face[i]) + 5);
        CHECK(std::abs(row.samples.attributes[2][i] - file_coordinate(row, i, 0)) < 1e-6);
      }
    }
  }
  const ProcessResult linear =
      run_columns(scratch / "ascii", scratch / "l.h5", {"--attribute", "label:linear,kind:1:linear"});
  REQUIRE(linear.exit_code == 0);
  const Row row = StoreReader(scratch / "l.h5").read_row(0);
  CHECK(row.samples.classes.empty());
  for (std::size_t i = 0; i < points_each; ++i)
    CHECK(std::abs(row.samples.attributes[1][i] - (1 + 39 * file_coordinate(row, i, 0))) < 1e-4);
  // The kinds are those of the store: a word for another one is another parameter, plain ones take what it
  // has.
  CHECK(run_columns(scratch / "ascii", scratch / "l.h5", {"--attribute", "label,kind"}).exit_code == 2);
  CHECK(run_columns(scratch / "ascii", scratch / "ascii.h5", {"--attribute", "kind,label:class,weight"})
            .exit_code == 0);
  CHECK(run_columns(scratch / "ascii", scratch / "ascii.h5", {"--attribute", "kind,label:linear,weight"})
            .exit_code == 2);
}

TEST_CASE("run --attribute: integer vectors, values beyond int32, and floats in class columns") {
  const ScratchFolder scratch;
  const std::string head =
                        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
                        "property float z\n",
                    faces = "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
  fs::create_directories(scratch / "in");
  write_file(scratch / "in/a.ply",
             head + "property int v_0\nproperty uchar v_1\nproperty uint big\nproperty float f\n" + faces +
                 "0 0 0 1 2 7 3\n1 0 0 1 2 4294967295 3\n0 1 0 1 2 7 3\n3 0 1 2\n");
  write_file(scratch / "in/b.ply", head +
                                       "property float v_0\nproperty float v_1\nproperty float big\n"
                                       "property int f\n" +
                                       faces + "0 0 0 8 9 2.5 4\n1 0 0 8 9 7 4\n0 1 0 8 9 7 4\n3 0 1 2\n");
  const ProcessResult result =
      run_columns(scratch / "in", scratch / "s.h5", {"--attribute", "v:2", "--attribute", "big,f"});
  INFO(result.out << result.err);
  CHECK(result.exit_code == 0);
  require_verified(scratch / "s.h5");
  const StoreReader reader(scratch / "s.h5");
  CHECK_THAT(reader.parameters_json(), ContainsSubstring(R"("attributes":"big:class,f,v:2:class")"));
  const Row a = reader.read_row(0), b = reader.read_row(1);
  CHECK((a.report.lacks == 1 && b.report.lacks == 1 && a.report.missing == 0 && b.report.missing == 0));
  CHECK((a.report.repairs[Repair::bad_attributes] == 1 && b.report.repairs[Repair::bad_attributes] == 1));
  for (std::size_t i = 0; i < points_each; ++i) {
    CHECK((a.samples.classes[2][2 * i] == 1 && a.samples.classes[2][2 * i + 1] == 2));
    CHECK((b.samples.classes[2][2 * i] == 8 && b.samples.classes[2][2 * i + 1] == 9));
    CHECK((a.samples.attributes[1][i] == 3 && b.samples.attributes[1][i] == 4));
    for (const Row* row : {&a, &b})
      CHECK((row->samples.classes[0][i] == 7 || row->samples.classes[0][i] == no_sample_class));
  }
}

TEST_CASE("run --attribute: glTF integers are classes, normalized ones are fractions") {
  const ScratchFolder scratch;
  GltfFile file;
  file.add_points({0, 0, 0, 1, 0, 0, 0, 1, 0});
  const auto bytes = [&](const std::string& more) {
    file.add_accessor(
        file.add_view(std::vector<std::uint8_t>{1, 0, 0, 0, 40, 0, 0, 0, 40, 0, 0, 0}, ",\"byteStride\":4"),
        5121, 3, "SCALAR", more);
  };
  bytes("");
  bytes(",\"normalized\":true");
  file.add_accessor(file.add_view(std::vector<std::uint32_t>{7, 7, 4000000000u}), 5125, 3, "SCALAR");
  write_file(
      scratch / "in.glb",
      file.glb(R"(,"meshes":[{"primitives":[{"attributes":{"POSITION":0,"_LABEL":1,"_SHARE":2,"_ID":3}}]}],)"
               R"("nodes":[{"mesh":0}])"));
  const ProcessResult result =
      run_columns(scratch / "in.glb", scratch / "s.h5", {"--attribute", "_LABEL,_SHARE,_ID"});
  INFO(result.out << result.err);
  REQUIRE(result.exit_code == 0);
  require_verified(scratch / "s.h5");
  CHECK_THAT(StoreReader(scratch / "s.h5").parameters_json(),
             ContainsSubstring(R"("_ID:class,_LABEL:class,_SHARE")"));
  const Row row = StoreReader(scratch / "s.h5").read_row(0);
  CHECK(row.report.repairs[Repair::bad_attributes] == 1);
  for (std::size_t i = 0; i < points_each; ++i) {
    CHECK((row.samples.classes[1][i] == 1 || row.samples.classes[1][i] == 40));
    CHECK((row.samples.classes[0][i] == 7 || row.samples.classes[0][i] == no_sample_class));
    CHECK((row.samples.attributes[2][i] >= 1 / 255.f - 1e-6f &&
           row.samples.attributes[2][i] <= 40 / 255.f + 1e-6f));
  }
}

TEST_CASE("run --attribute: one that no model has is named with similar names, and every run exits with 3") {
  const ScratchFolder scratch;
  fs::create_directories(scratch / "in");
  write_file(scratch / "in/a.ply", labeled_square("uchar"));
  write_mesh(scratch / "in/b.stl", cube());
  const Words words = {"--attribute", "labl", "--attribute", "weight"};
  for (int run = 0; run < 3; ++run) {
    const ProcessResult result = run_columns(scratch / "in", scratch / "s.h5", words);
    INFO(result.out << result.err);
    CHECK(result.exit_code == 3);
    CHECK_THAT(result.out,
               ContainsSubstring("no model has the attribute `labl`; they have `label`, `kind`, `weight`") &&
                   ContainsSubstring("2 models lack attribute `labl`") &&
                   ContainsSubstring("  ok                           2"));
  }
  require_verified(scratch / "s.h5");
  const ProcessResult json = run_columns(scratch / "in", scratch / "s.h5", joined(words, {"--json"}));
  CHECK(json.exit_code == 3);
  CHECK_THAT(json.out, ContainsSubstring(R"("attributes_of_no_model":{"labl":["label","kind","weight"]})"));
  CHECK_THAT(meander_with({"info", scratch / "s.h5"}).out,
             ContainsSubstring("no model has the attribute `labl`\n"));
  CHECK_THAT(meander_with({"info", scratch / "s.h5", "--json"}).out,
             ContainsSubstring(R"("attributes_of_no_model":{"labl":[]})"));
  const StoreReader reader(scratch / "s.h5");
  CHECK((reader.report(0).missing == 0b01 && reader.report(1).missing == 0b11));
  // A new model that has it ends this.
  std::string other = labeled_square("uchar");
  other.replace(other.find("label"), 5, "labl");
  write_file(scratch / "in/c.ply", other);
  const ProcessResult later = run_columns(scratch / "in", scratch / "s.h5", words);
  INFO(later.out << later.err);
  CHECK(later.exit_code == 0);
  CHECK_THAT(later.out, !ContainsSubstring("no model has"));
  // The column was chosen when no model had the attribute: as numbers, of the nearest corner nonetheless.
  const Row row = row_of(scratch / "s.h5", "c.ply");
  for (const float value : row.samples.attributes[0]) CHECK((value == 1 || value == 40));
  // Where all models failed nothing is known of their attributes.
  write_file(scratch / "broken.off", "OFF\nnothing\n");
  CHECK_THAT(run_columns(scratch / "broken.off", scratch / "b.h5", words).out,
             !ContainsSubstring("no model has"));
}

TEST_CASE("run --attribute: the type of a column is decided by the first models by id") {
  const ScratchFolder scratch;
  fs::create_directories(scratch / "in");
  write_mesh(scratch / "in/a.stl", cube());
  write_file(scratch / "in/b.ply", labeled_square("float"));
  write_file(scratch / "in/c.ply", labeled_square("uchar"));
  REQUIRE(run_columns(scratch / "in", scratch / "s.h5", {"--attribute", "label", "-j", "4"}).exit_code == 0);
  REQUIRE(run_columns(scratch / "in", scratch / "t.h5", {"--attribute", "label", "-j", "1"}).exit_code == 0);
  CHECK(read_file(scratch / "s.h5") == read_file(scratch / "t.h5"));
  CHECK_THAT(StoreReader(scratch / "s.h5").parameters_json(), ContainsSubstring(R"("attributes":"label",)"));
  // Integers are never interpolated unless that is asked for.
  const Row later = row_of(scratch / "s.h5", "c.ply");
  for (const float value : later.samples.attributes[0]) CHECK((value == 1 || value == 40));
  // The store keeps its column when a model with integers comes in front.
  write_file(scratch / "in/0.ply", labeled_square("uchar"));
  REQUIRE(run_columns(scratch / "in", scratch / "s.h5", {"--attribute", "label"}).exit_code == 0);
  CHECK(StoreReader(scratch / "s.h5").rows() == 4);
  REQUIRE(run_columns(scratch / "in", scratch / "u.h5", {"--attribute", "label"}).exit_code == 0);
  CHECK(StoreReader(scratch / "u.h5").columns().attributes[0].is_classes());
  // There a float is a class where it is whole: here at the corners.
  const Row whole = row_of(scratch / "u.h5", "b.ply");
  for (const std::int32_t value : whole.samples.classes[0]) CHECK((value == 1 || value == 40));
}

TEST_CASE("run --attribute: objects, groups and materials of OBJ and glTF, with their names") {
  const ScratchFolder scratch;
  fs::create_directories(scratch / "in");
  const std::string quads = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n";
  write_file(scratch / "in/a.obj", quads + "o seat\nusemtl wood\nf 1 2 3 4\no leg\nf 5 6 7 8\n");
  write_file(scratch / "in/b.obj", quads + "g top\nf 1 2 3 4\ng\nf 5 6 7 8\n");
  GltfFile file;
  file.add_points(gltf_cube_points);
  file.add_indices(gltf_cube_indices);
  write_file(scratch / "in/c.glb", file.glb(R"(,"materials":[{"name":"steel"}],"meshes":[{"primitives":[)"
                                            R"({"attributes":{"POSITION":0},"indices":1,"material":0}]}],)"
                                            R"("nodes":[{"name":"lid","mesh":0}])"));
  write_mesh(scratch / "in/d.stl", cube());
  const Words words = {"--attribute", "object,group,material,part"};
  const ProcessResult result = run_columns(scratch / "in", scratch / "s.h5", words);
  INFO(result.out << result.err);
  REQUIRE(result.exit_code == 0);
  require_verified(scratch / "s.h5");
  const StoreReader reader(scratch / "s.h5");
  enum : std::size_t { group, material, object, part };
  const Row a = reader.read_row(0), b = reader.read_row(1), c = reader.read_row(2), d = reader.read_row(3);
  CHECK(a.names == R"({"material":["wood"],"object":["seat","leg"]})");
  CHECK(b.names == R"({"group":["top","default"]})");
  CHECK(c.names == R"({"material":["steel"],"object":["lid"],"part":["lid"]})");
  CHECK(d.names.empty());
  CHECK((a.report.missing == 0b1001 && b.report.missing == 0b1110 && c.report.missing == 0b0001));
  CHECK((d.report.missing == 0b1111 && d.report.lacks == 0b1111));
  std::size_t seats = 0;
  for (std::size_t i = 0; i < points_each; ++i) {
    seats += a.samples.classes[object][i] == 0;
    CHECK(a.samples.classes[object][i] == static_cast<std::int32_t>(a.samples.face[i]));
    CHECK(a.samples.classes[material][i] == 0);
    CHECK(b.samples.classes[group][i] == static_cast<std::int32_t>(b.samples.face[i]));
    CHECK((c.samples.classes[object][i] == 0 && c.samples.classes[part][i] == 0));
    CHECK(a.samples.classes[group][i] == no_sample_class);
  }
  CHECK((seats > points_each / 2 - 3 && seats < points_each / 2 + 3));
  // The points are those without them.
  REQUIRE(run_columns(scratch / "in", scratch / "plain.h5", {}).exit_code == 0);
  for (std::uint64_t row = 0; row < 4; ++row)
    CHECK(StoreReader(scratch / "plain.h5").read_row(row).samples.points ==
          reader.read_row(row).samples.points);
  const ProcessResult info = meander_with({"info", scratch / "s.h5", "a.obj"});
  CHECK_THAT(info.out, ContainsSubstring("  object            seat, leg\n") &&
                           ContainsSubstring("  material          wood\n"));
  CHECK_THAT(meander_with({"info", scratch / "s.h5", "a.obj", "--json"}).out,
             ContainsSubstring(R"("names":{"material":["wood"],"object":["seat","leg"]})"));

  // Names go wherever rows go: an update, rows that are reused, shards and packs of them, more descriptors.
  write_file(scratch / "in/e.obj", quads + "o \xC3\xA9t\xC3\xA9\nf 1 2 3 4\n");
  REQUIRE(run_columns(scratch / "in", scratch / "s.h5", words).exit_code == 0);
  REQUIRE(run_columns(scratch / "in", scratch / "one.h5", words).exit_code == 0);
  CHECK(read_file(scratch / "s.h5") == read_file(scratch / "one.h5"));
  CHECK(row_of(scratch / "one.h5", "e.obj").names == "{\"object\":[\"\xC3\xA9t\xC3\xA9\"]}");
  REQUIRE(run_columns(scratch / "in", scratch / "reused.h5", joined(words, {"--reuse", scratch / "s.h5"}))
              .exit_code == 0);
  CHECK(read_file(scratch / "reused.h5") == read_file(scratch / "one.h5"));
  const Words plan = {
      "plan", (scratch / "in").string(), "-o", (scratch / "array.h5").string(), "-n", "300", "--shards", "2"};
  REQUIRE(meander_with(joined(plan, words)).exit_code == 0);
  const std::string folder = (scratch / "array.h5.run").string();
  for (const char* shard : {"0/2", "1/2"})
    REQUIRE(meander_with({"run", folder, "--shard", shard, "--progress", "none"}).exit_code == 0);
  REQUIRE(meander_with({"merge", folder}).exit_code == 0);
  CHECK(read_file(scratch / "array.h5") == read_file(scratch / "one.h5"));
  REQUIRE(meander_with({"describe", scratch / "one.h5", "--descriptors", "d2", "-o", scratch / "d.h5"})
              .exit_code == 0);
  require_verified(scratch / "d.h5");
  CHECK(row_of(scratch / "d.h5", "a.obj").names == a.names);
}

TEST_CASE("run --attribute: parts.obj of the shared cases is half seat and half leg") {
  const fs::path parts = fs::path(MEANDER_SHARED_DATA) / "../cases/obj_groups/parts.obj";
  if (!fs::exists(parts)) {
    WARN("skipped: " << parts.string() << " is not there");
    return;
  }
  const ScratchFolder scratch;
  REQUIRE(run_columns(parts, scratch / "s.h5", {"--attribute", "object"}).exit_code == 0);
  const Row row = StoreReader(scratch / "s.h5").read_row(0);
  const std::vector<std::int32_t>& objects = row.samples.classes.at(0);
  const auto seats = std::count(objects.begin(), objects.end(), 0),
             legs = std::count(objects.begin(), objects.end(), 1);
  CHECK((seats + legs == points_each && std::abs(seats - legs) < 6));
  CHECK(row.names == R"({"object":["seat","leg"]})");
}

TEST_CASE("run --attribute: scene.ply of the shared cases has only the labels 1 and 40") {
  const fs::path scene = fs::path(MEANDER_SHARED_DATA) / "../cases/integer_labels/scene.ply";
  if (!fs::exists(scene)) {
    WARN("skipped: " << scene.string() << " is not there");
    return;
  }
  const ScratchFolder scratch;
  REQUIRE(run_columns(scene, scratch / "s.h5", {"--attribute", "label"}).exit_code == 0);
  const Row row = StoreReader(scratch / "s.h5").read_row(0);
  REQUIRE(row.samples.classes.size() == 1);
  std::size_t ones = 0;
  for (const std::int32_t value : row.samples.classes[0]) {
    CHECK((value == 1 || value == 40));
    ones += value == 1;
  }
  CHECK((ones > points_each / 3 && ones < 2 * points_each / 3));
}

TEST_CASE("run --store: kept columns equal those of the full store, and every reader says what is missing") {
  const ScratchFolder scratch;
  put_models(scratch / "in");
  const Words describe = {"--label-from-folder"};
  REQUIRE(run_columns(scratch / "in", scratch / "all.h5", describe).exit_code == 3);
  REQUIRE(
      run_columns(scratch / "in", scratch / "points.h5", joined(describe, {"--store", "points"})).exit_code ==
      3);
  REQUIRE(run_columns(scratch / "in", scratch / "some.h5", joined(describe, {"--store", "normals,density"}))
              .exit_code == 3);
  require_verified(scratch / "points.h5");
  require_verified(scratch / "some.h5");
  CHECK(fs::file_size(scratch / "points.h5") < fs::file_size(scratch / "some.h5"));
  CHECK(fs::file_size(scratch / "some.h5") < fs::file_size(scratch / "all.h5"));
  for (const char* id : {"ascii.ply", "cube.glb", "plain.stl"}) {
    const Row all = row_of(scratch / "all.h5", id), some = row_of(scratch / "some.h5", id),
              points = row_of(scratch / "points.h5", id);
    CHECK(all.samples.points == points.samples.points);
    CHECK(all.samples.points == some.samples.points);
    CHECK(all.samples.normals == some.samples.normals);
    CHECK(all.samples.density == some.samples.density);
    CHECK(all.report.points_crc32c == points.report.points_crc32c);
    CHECK((some.samples.face.empty() && some.samples.corners.empty() && points.samples.normals.empty()));
  }
  const std::string store = scratch / "points.h5", out = scratch / "out";
  const auto refused = [&](Words words, const char* column) {
    const ProcessResult result = meander_with(words);
    INFO(fmt::format("{}", fmt::join(words, " ")) << ": " << result.out << result.err);
    CHECK(result.exit_code == 2);
    CHECK_THAT(result.err,
               ContainsSubstring(fmt::format("has no `{}`", column)) && ContainsSubstring("--store"));
  };
  refused({"export", store, "--pointnet", "-o", out}, "normals");
  refused({"export", store, "--format", "xyz", "-o", out}, "normals");
  refused({"export", store, "--html", scratch / "page.html"}, "normals");
  refused({"export", store, "--format", "npz", "--arrays", "points,face_index", "-o", out}, "face_index");
  refused({"export", store, "--format", "webdataset", "--arrays", "density", "-o", out}, "density");
  refused({"describe", store, scratch / "in", "--descriptors", "geodesic", "-o", scratch / "d.h5"},
          "face_index");
  refused({"describe", store, "--descriptors", "pairs-unsigned", "-o", scratch / "d.h5"}, "normals");
  refused({"measure", "discrepancy", store + "::plain.stl", "--surface", scratch / "in"}, "density");
  refused({"render", "sheet", store, "-o", scratch / "sheet.png"}, "normals");
  refused({"render", "turntable", store, "--item", "plain.stl", "-o", scratch / "frames"}, "normals");
  // What can do without works.
  for (const char* format : {"ply", "off", "npz", "webdataset"}) {
    const ProcessResult result =
        meander_with({"export", store, "--format", format, "-o", scratch / (std::string("to-") + format)});
    INFO(format << result.out << result.err);
    CHECK(result.exit_code == 0);
  }
  const std::string ply = read_file(scratch / "to-ply/plain.stl.ply");
  CHECK_THAT(ply, ContainsSubstring("property double z\nend_header\n"));
  CHECK(ply.size() == ply.find("end_header\n") + 11 + 24 * points_each);
  const ProcessResult described =
      meander_with({"describe", store, "--descriptors", "d2,a3,d1,d3,d4,harmonics", "-o", scratch / "d.h5"});
  INFO(described.out << described.err);
  REQUIRE(described.exit_code == 0);
  require_verified(scratch / "d.h5");
  CHECK(StoreReader(scratch / "d.h5").columns() == StoreReader(store).columns());
  CHECK(meander_with({"retrieve", "query", scratch / "d.h5", "plain.stl", "--descriptor", "d2"}).exit_code ==
        0);
  CHECK_THAT(meander_with({"info", store}).out, ContainsSubstring("columns points\n"));
  REQUIRE(meander_with({"export", scratch / "some.h5", "plain.stl", "-o", scratch / "some"}).exit_code == 0);
  CHECK_THAT(read_file(scratch / "some/plain.stl.ply"),
             ContainsSubstring("property float nz\nproperty float density\nend_header\n"));
}

TEST_CASE("surface --store: parametric surfaces can omit some of their columns") {
  const ScratchFolder scratch;
  const auto run_surface = [&](const char* name, const Words& more) {
    const Words words = {"surface", "torus", "-n", "200", "-o", (scratch / name).string()};
    return meander_with(joined(words, more)).exit_code;
  };
  REQUIRE(run_surface("all.h5", {}) == 0);
  REQUIRE(run_surface("some.h5", {"--store", "uv,density"}) == 0);
  require_verified(scratch / "some.h5");
  const Row all = StoreReader(scratch / "all.h5").read_row(0),
            some = StoreReader(scratch / "some.h5").read_row(0);
  CHECK(all.samples.points == some.samples.points);
  CHECK(all.samples.uv == some.samples.uv);
  CHECK((some.samples.normals.empty() && some.samples.curve_rank.empty()));
  CHECK(run_surface("no.h5", {"--store", "face_index"}) == 2);
  CHECK(run_surface("no.h5", {"--store", "face"}) == 2);
  REQUIRE(meander_with({"export", scratch / "some.h5", "-o", scratch / "out"}).exit_code == 0);
  CHECK_THAT(
      read_file(scratch / "out/torus.ply"),
      ContainsSubstring(
          "property double z\nproperty float u\nproperty float v\nproperty float density\nend_header"));
}

TEST_CASE("export --arrays: texture coordinates and attributes are written") {
  const ScratchFolder scratch;
  put_models(scratch / "in");
  REQUIRE(run_columns(scratch / "in", scratch / "s.h5", all_columns).exit_code == 3);
  const ProcessResult result =
      meander_with({"export", scratch / "s.h5", "ascii.ply", "--format", "webdataset", "--arrays",
                    "texcoord,attribute:flow,attribute:number", "-o", scratch / "out"});
  INFO(result.out << result.err);
  REQUIRE(result.exit_code == 0);
  const std::string shard = read_file(scratch / "out/s-000000.tar");
  CHECK_THAT(shard, ContainsSubstring("00000000.texcoord.npy") &&
                        ContainsSubstring("00000000.attribute_flow.npy") &&
                        ContainsSubstring("'shape': (300, 3)") && ContainsSubstring("'shape': (300, 2)") &&
                        ContainsSubstring("'shape': (300,)"));
  const ProcessResult classes = meander_with({"export", scratch / "s.h5", "cube.glb", "--format", "npz",
                                              "--arrays", "attribute:part", "-o", scratch / "npz"});
  REQUIRE(classes.exit_code == 0);
  CHECK_THAT(read_file(scratch / "npz/cube.glb.npz"), ContainsSubstring("attribute_part.npy") &&
                                                          ContainsSubstring("'<i4'") &&
                                                          ContainsSubstring("'shape': (300,)"));
  for (const auto& [array, message] : std::vector<std::pair<std::string, std::string>>{
           {"attribute:none", "made without `--attribute none`"}, {"texcords", "did you mean `texcoord`?"}}) {
    const ProcessResult refused = meander_with(
        {"export", scratch / "s.h5", "--format", "npz", "--arrays", array, "-o", scratch / "no"});
    CHECK(refused.exit_code == 2);
    CHECK_THAT(refused.err, ContainsSubstring(message));
  }
}
