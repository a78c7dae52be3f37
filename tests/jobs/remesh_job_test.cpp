// meander remesh as a user runs it: files, statuses, second runs, kills.
#include <charconv>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <sstream>

#include "io/file/folder_lock.h"
#include "io/json/json_reader.h"
#include "io/mesh/mesh_reader.h"
#include "kernels/mesh/prepare_mesh.h"
#include "support/catch.h"
#include "support/collection.h"
#include "support/fault_program.h"
#include "support/meander_program.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;
namespace fs = std::filesystem;

namespace {

PolygonMesh mesh_of(const fs::path& path, bool colors = false) {
  MeshFormat format{};
  REQUIRE(mesh_format_of(path, format));
  const FileBytes file(path);
  MeshSurroundings around;
  around.colors = colors;
  return read_mesh(file.bytes(), format, {}, around);
}

// The items of the table: id -> its object.
std::map<std::string, JsonObject> items_of(const fs::path& folder) {
  const JsonObject table(read_file(folder / "remesh.json"), "remesh.json");
  const JsonObject items(table.members().at("items"), "items");
  std::map<std::string, JsonObject> found;
  for (const auto& [id, text] : items.members()) found.emplace(id, JsonObject(text, id));
  return found;
}

// The meshes below a folder with their bytes: all files but the tables.
std::map<std::string, std::string> meshes_of(const fs::path& folder) {
  std::map<std::string, std::string> content;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    const std::string name = fs::relative(entry.path(), folder).string();
    if (entry.is_regular_file() && !name.starts_with("remesh.")) content[name] = read_file(entry.path());
  }
  return content;
}

void make_models(const fs::path& folder) {
  fs::create_directories(folder / "a");
  write_mesh(folder / "a" / "ball.off", icosphere(3));
  write_mesh(folder / "a" / "ring.obj", torus(30, 12));
  write_mesh(folder / "sheet.ply", grid_plane(12, 9));
  write_mesh(folder / "box.stl", cube());
}

ProcessResult remesh(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), "remesh");
  return meander_with(std::move(arguments));
}

}  // namespace

TEST_CASE("remesh job: the first vertices of a mesh are the points of run") {
  const ScratchFolder scratch;
  make_models(scratch / "models");
  const std::string models = (scratch / "models").string(), out = (scratch / "out").string();
  const std::vector<std::string> same = {"-n", "120", "--seed", "5", "--sequence", "stratified"};
  std::vector<std::string> arguments = {models, "-o", out};
  arguments.insert(arguments.end(), same.begin(), same.end());
  const ProcessResult made = remesh(arguments);
  REQUIRE(made.exit_code == 0);
  CHECK(contains(made.out, "4 models, 120 samples each"));
  arguments = {"run", models, "-o", (scratch / "s.h5").string()};
  arguments.insert(arguments.end(), same.begin(), same.end());
  REQUIRE(meander_with(arguments).exit_code == 0);
  REQUIRE(meander_with(
              {"export", (scratch / "s.h5").string(), "-o", (scratch / "points").string(), "--format", "xyz"})
              .exit_code == 0);
  const std::map<std::string, std::string> names = {{"a/ball.off", "a/ball.ply"},
                                                    {"a/ring.obj", "a/ring.ply"},
                                                    {"sheet.ply", "sheet.ply"},
                                                    {"box.stl", "box.ply"}};
  for (const auto& [id, name] : names) {
    INFO(id);
    const PolygonMesh mesh = mesh_of(fs::path(out) / name);
    std::istringstream points(read_file(scratch / ("points/" + id + ".xyz")));
    REQUIRE(mesh.vertex_count() >= 120);
    double nx = 0, ny = 0, nz = 0;
    std::string x, y, z;
    for (std::size_t i = 0; i < 120; ++i) {
      points >> x >> y >> z >> nx >> ny >> nz;
      REQUIRE(std::stod(x) == mesh.x[i]);
      REQUIRE(std::stod(y) == mesh.y[i]);
      REQUIRE(std::stod(z) == mesh.z[i]);
    }
    const JsonObject record = items_of(out).at(id);
    CHECK(record.text("status") == "ok");
    CHECK(record.text("file") == name);
    CHECK(record.integer("samples") == 120);
    CHECK(record.integer("vertices") == static_cast<std::int64_t>(mesh.vertex_count()));
    CHECK(record.integer("faces") == static_cast<std::int64_t>(mesh.polygon_count()));
  }
  CHECK(items_of(out).at("a/ring.obj").integer("euler") == 0);
  CHECK(items_of(out).at("sheet.ply").integer("euler") == 1);
  CHECK(items_of(out).at("box.stl").integer("euler") == 2);
}

TEST_CASE("remesh job: every format holds the same mesh") {
  const ScratchFolder scratch;
  write_mesh(scratch / "ball.off", icosphere(3));
  for (const std::string format : {"ply", "off", "obj"})
    REQUIRE(remesh({(scratch / "ball.off").string(), "-o", (scratch / format).string(), "-n", "60",
                    "--format", format, "--fit"})
                .exit_code == 0);
  const PolygonMesh ply = mesh_of(scratch / "ply/ball.ply");
  for (const std::string format : {"off", "obj"}) {
    const PolygonMesh other = mesh_of(scratch / (format + "/ball." + format));
    CHECK(other.x == ply.x);
    CHECK(other.z == ply.z);
    CHECK(other.corners == ply.corners);
  }
}

TEST_CASE("remesh job: a row per input with the status of a run, the same bytes for any number of threads") {
  const ScratchFolder scratch;
  const std::map<std::string, Status> expected = write_collection(scratch / "models");
  for (const std::string threads : {"1", "4"}) {
    const ProcessResult result = remesh({(scratch / "models").string(), "-o", (scratch / threads).string(),
                                         "-n", "40", "-j", threads, "--progress", "none"});
    CHECK(result.exit_code == 3);
  }
  CHECK(meshes_of(scratch / "1") == meshes_of(scratch / "4"));
  const auto items = items_of(scratch / "1");
  REQUIRE(items.size() == expected.size());
  for (const auto& [id, status] : expected) {
    INFO(id);
    REQUIRE(items.contains(id));
    CHECK(items.at(id).text("status") == std::string(name_of(status)));
    CHECK((status == Status::ok) == fs::is_regular_file(scratch / "1" / items.at(id).text("file").value()));
    if (status != Status::ok) CHECK(!items.at(id).text("message")->empty());
  }
  std::istringstream csv(read_file(scratch / "1/remesh.csv"));
  std::string line;
  std::size_t lines = 0;
  while (std::getline(csv, line)) ++lines;
  CHECK(lines == expected.size() + 1);
}

TEST_CASE("remesh job: a second run makes new and changed models only, and refuses other parameters") {
  const ScratchFolder scratch;
  make_models(scratch / "models");
  const std::string models = (scratch / "models").string(), out = (scratch / "out").string();
  REQUIRE(remesh({models, "-o", out, "-n", "80"}).exit_code == 0);
  const auto first = meshes_of(out);
  const auto time = fs::last_write_time(fs::path(out) / "sheet.ply");
  write_mesh(scratch / "models/late.off", icosphere(2));
  const ProcessResult second = remesh({models, "-o", out, "-n", "80", "--json"});
  REQUIRE(second.exit_code == 0);
  CHECK(JsonObject(second.out, "summary").integer("done_now") == 1);
  CHECK(JsonObject(second.out, "summary").integer("items") == 5);
  CHECK(fs::last_write_time(fs::path(out) / "sheet.ply") == time);
  const ProcessResult other = remesh({models, "-o", out, "-n", "81"});
  CHECK(other.exit_code == 2);
  CHECK(contains(other.err, "made with other parameters"));
  CHECK(contains(other.err, "\"samples\" was 80, now it is 81"));
  REQUIRE(remesh({models, "-o", out, "-n", "81", "--fresh"}).exit_code == 0);
  CHECK(meshes_of(out).at("sheet.ply") != first.at("sheet.ply"));
  // The mesh of an item that fails now is gone.
  write_file(scratch / "models/sheet.ply", "ply\nformat ascii 1.0\nend_header\n");
  CHECK(remesh({models, "-o", out, "-n", "81"}).exit_code == 3);
  CHECK(items_of(out).at("sheet.ply").text("status") == "empty");
  CHECK(!fs::exists(fs::path(out) / "sheet.ply"));
}

TEST_CASE("remesh job: files of others are not replaced") {
  const ScratchFolder scratch;
  make_models(scratch / "models");
  const std::string models = (scratch / "models").string();
  fs::create_directories(scratch / "out");
  write_mesh(scratch / "out/sheet.ply", cube());
  const std::string before = read_file(scratch / "out/sheet.ply");
  ProcessResult result = remesh({models, "-o", (scratch / "out").string(), "-n", "50"});
  CHECK(result.exit_code == 2);
  CHECK(contains(result.err, "exists (--fresh replaces it)"));
  CHECK(meshes_of(scratch / "out").size() == 1);
  CHECK(read_file(scratch / "out/sheet.ply") == before);
  // The folder of the inputs, and one in it.
  for (const std::string inside : {"models", "models/out"}) {
    result = remesh({models, "-o", (scratch / inside).string(), "-n", "50", "--fresh"});
    CHECK(result.exit_code == 2);
    CHECK(contains(result.err, "lies in the input folder"));
  }
  result = remesh({(scratch / "models/sheet.ply").string(), "-o", models, "-n", "50", "--fresh"});
  CHECK(result.exit_code == 2);
  CHECK(contains(result.err, "would be replaced"));
  // A table of somebody else.
  write_file(scratch / "out/remesh.json", "{\"items\":{}}");
  result = remesh({models, "-o", (scratch / "out").string(), "-n", "50"});
  CHECK(result.exit_code == 2);
  CHECK(contains(result.err, "is no table of `meander remesh`"));
}

TEST_CASE("remesh job: a later run replaces and removes only its own meshes") {
  const ScratchFolder scratch;
  const std::string models = (scratch / "models").string(), out = (scratch / "out").string();
  make_models(models);
  write_file(scratch / "models/bad.off", "");
  REQUIRE(remesh({models, "-o", out, "-n", "50"}).exit_code == 3);
  // A mesh of the user's under the name of an item that fails stays.
  write_mesh(scratch / "out/bad.ply", cube());
  const std::string own = read_file(scratch / "out/bad.ply");
  const ProcessResult refused = remesh({models, "-o", out, "-n", "50"});
  CHECK(refused.exit_code == 2);
  CHECK(contains(refused.err, "exists (--fresh replaces it)"));
  CHECK(remesh({models, "-o", out, "-n", "50", "--fresh"}).exit_code == 3);
  CHECK(read_file(scratch / "out/bad.ply") == own);
  fs::remove(scratch / "out/bad.ply");
  // Under the name of a new input it is refused, and replaced with --fresh.
  write_mesh(scratch / "models/new.off", icosphere(2));
  write_mesh(scratch / "out/new.ply", cube());
  CHECK(contains(remesh({models, "-o", out, "-n", "50"}).err, "exists (--fresh replaces it)"));
  CHECK(read_file(scratch / "out/new.ply") == own);
  CHECK(remesh({models, "-o", out, "-n", "50", "--fresh"}).exit_code == 3);
  CHECK(read_file(scratch / "out/new.ply") != own);
  // The mesh of an item that fails now was the command's own.
  write_file(scratch / "models/new.off", "");
  CHECK(remesh({models, "-o", out, "-n", "50"}).exit_code == 3);
  CHECK_FALSE(fs::exists(scratch / "out/new.ply"));
}

TEST_CASE("remesh job: a stopped run with --fresh does not claim files of others") {
  const ScratchFolder scratch;
  const std::string models = (scratch / "models").string(), out = (scratch / "out").string();
  make_models(models);
  fs::create_directories(out);
  for (const char* name : {"bad1", "bad2", "bad3"}) {
    write_file(scratch / "models" / (std::string(name) + ".off"), "");
    write_mesh(scratch / "out" / (std::string(name) + ".ply"), cube());
  }
  const std::string own = read_file(scratch / "out/bad1.ply");
  // One at a time: of several in flight, the first failure may be the last of the items.
  REQUIRE(remesh({models, "-o", out, "-n", "50", "--fresh", "--max-failures", "0", "-j", "1"}).exit_code ==
          75);
  const ProcessResult again = remesh({models, "-o", out, "-n", "50", "--max-failures", "9"});
  CHECK(again.exit_code == 2);
  CHECK(contains(again.err, "exists (--fresh replaces it)"));
  for (const char* name : {"bad1.ply", "bad2.ply", "bad3.ply"})
    CHECK(read_file(scratch / "out" / name) == own);
}

TEST_CASE("remesh job: a surface that is mostly without samples is reported") {
  const ScratchFolder scratch;
  PolygonMesh dust = cube();
  for (int i = 1; i < 12; ++i) dust = merged(dust, moved(cube(), 1, 3.0 * i, 0, 0));
  fs::create_directories(scratch / "models");
  write_mesh(scratch / "models/dust.off", dust);
  const ProcessResult result =
      remesh({(scratch / "models").string(), "-o", (scratch / "out").string(), "-n", "4"});
  CHECK(result.exit_code == 0);
  CHECK(contains(result.out, "1 models lost more than 10 % of their area with them"));
}

TEST_CASE("remesh job: models of one name in several formats get separate meshes") {
  const ScratchFolder scratch;
  fs::create_directories(scratch / "models");
  write_mesh(scratch / "models/a.off", icosphere(2));
  write_mesh(scratch / "models/a.obj", cube());
  REQUIRE(remesh({(scratch / "models").string(), "-o", (scratch / "out").string(), "-n", "20"}).exit_code ==
          0);
  CHECK(fs::exists(scratch / "out/a.off.ply"));
  CHECK(fs::exists(scratch / "out/a.obj.ply"));
}

TEST_CASE("remesh job: options without meaning here are refused") {
  const ScratchFolder scratch;
  write_mesh(scratch / "a.off", cube());
  const std::string model = (scratch / "a.off").string(), out = (scratch / "out").string();
  CHECK(remesh({model, "-o", out, "--normalize", "unit-box"}).exit_code == 2);
  CHECK(remesh({model, "-o", out, "--density", "texture"}).exit_code == 2);
  CHECK(remesh({model, "-o", out, "--format", "stl"}).exit_code == 2);
  CHECK(remesh({model, "-o", out, "--crease-angle", "0"}).exit_code == 2);
  CHECK(remesh({model, "-o", out, "--certify"}).exit_code == 2);
  CHECK(!fs::exists(out));
}

namespace {

// A sheet of 9 x 9 vertices over the unit square with a wave, and what it has at (x, y).
std::string painted_sheet(bool as_obj) {
  std::string vertices, coordinates, faces;
  const auto number = [](double value) { return std::to_string(value) + " "; };
  for (int j = 0; j < 9; ++j)
    for (int i = 0; i < 9; ++i) {
      const double x = i / 8., y = j / 8.;
      vertices += (as_obj ? "v " : "") + number(x) + number(y) + number(0);
      if (as_obj)
        vertices += number(x) + number(y) + number(0.2) + "\n";
      else
        vertices += std::to_string(i * 255 / 8) + " 51 " + std::to_string(j * 255 / 8) + " " +
                    number(x + 2 * y) + number(-x) + number(3 * y) + "\n";
      coordinates += "vt " + number(2 * x) + number(1 - y) + "\n";
    }
  const int first = as_obj ? 1 : 0;
  for (int j = 0; j < 8; ++j)
    for (int i = 0; i < 8; ++i) {
      const int a = first + 9 * j + i;
      for (const auto& [p, q, r] : {std::array{a, a + 1, a + 10}, std::array{a, a + 10, a + 9}}) {
        faces += as_obj ? "f" : "3";
        for (const int v : {p, q, r})
          faces += " " + std::to_string(v) + (as_obj ? "/" + std::to_string(v) : "");
        faces += "\n";
      }
    }
  if (as_obj) return vertices + coordinates + faces;
  return "ply\nformat ascii 1.0\nelement vertex 81\nproperty float x\nproperty float y\nproperty float z\n"
         "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty float heat\n"
         "property float flow_0\nproperty float flow_1\nelement face 128\n"
         "property list uchar int vertex_indices\nend_header\n" +
         vertices + faces;
}

const std::vector<double>& attribute_of(const PolygonMesh& mesh, const std::string& name) {
  for (const ScalarAttribute& attribute : mesh.vertex_attributes)
    if (attribute.name == name) return attribute.values;
  FAIL("no attribute " << name);
  static const std::vector<double> none;
  return none;
}

}  // namespace

TEST_CASE("remesh job: colors, attributes and texture coordinates are those of the surface") {
  const ScratchFolder scratch;
  fs::create_directories(scratch / "models");
  std::ofstream(scratch / "models" / "a.ply") << painted_sheet(false);
  std::ofstream(scratch / "models" / "b.obj") << painted_sheet(true);
  for (const bool fit : {false, true}) {
    const fs::path out = scratch / (fit ? "fitted" : "plain");
    std::vector<std::string> arguments = {(scratch / "models" / "a.ply").string(),
                                          "-o",
                                          out.string(),
                                          "-n",
                                          "60",
                                          "--colors",
                                          "--attribute",
                                          "heat,flow:2"};
    if (fit) arguments.emplace_back("--fit");
    REQUIRE(remesh(arguments).exit_code == 0);
    const PolygonMesh mesh = mesh_of(out / "a.ply", true);
    REQUIRE(mesh.x.size() > 64);  // with vertices on the boundary
    REQUIRE(mesh.colors.vertex.size() == 3 * mesh.x.size());
    const std::vector<double>&heat = attribute_of(mesh, "heat"), &across = attribute_of(mesh, "flow_0"),
          &along = attribute_of(mesh, "flow_1");
    // Fitting moves samples by a part of the spacing; they keep what they had.
    const double apart = fit ? 0.1 : 1e-5;
    for (std::size_t v = 0; v < mesh.x.size(); ++v) {
      REQUIRE(std::abs(heat[v] - (mesh.x[v] + 2 * mesh.y[v])) < 3 * apart);
      REQUIRE(std::abs(across[v] + mesh.x[v]) < apart);
      REQUIRE(std::abs(along[v] - 3 * mesh.y[v]) < 3 * apart);
      REQUIRE(std::abs(mesh.colors.vertex[3 * v] - mesh.x[v]) < apart + 0.006);
      REQUIRE(std::abs(mesh.colors.vertex[3 * v + 1] - 0.2) < 1e-6);
      REQUIRE(std::abs(mesh.colors.vertex[3 * v + 2] - mesh.y[v]) < apart + 0.006);
    }
    CHECK(items_of(out).at("a.ply").text("lacks").value_or("") == "");
  }
  // Corners of the input have the values that they have there.
  const PolygonMesh plain = mesh_of(scratch / "plain" / "a.ply");
  for (std::size_t v = 0; v < plain.x.size(); ++v)
    if (plain.x[v] == 1 && plain.y[v] == 1) CHECK(attribute_of(plain, "heat")[v] == 3);

  const std::string textured = (scratch / "models" / "b.obj").string();
  REQUIRE(remesh({textured, "-o", (scratch / "st").string(), "-n", "60", "--texcoord"}).exit_code == 0);
  const PolygonMesh with = mesh_of(scratch / "st" / "b.ply");
  for (std::size_t v = 0; v < with.x.size(); ++v) {
    REQUIRE(std::abs(attribute_of(with, "s")[v] - 2 * with.x[v]) < 1e-5);
    REQUIRE(std::abs(attribute_of(with, "t")[v] - (1 - with.y[v])) < 1e-5);
  }
  REQUIRE(remesh({textured, "-o", (scratch / "obj").string(), "-n", "60", "--texcoord", "--colors",
                  "--format", "obj"})
              .exit_code == 0);
  // Sampled again, they are still there.
  const std::string store = (scratch / "s.h5").string();
  REQUIRE(meander_with({"run", (scratch / "obj" / "b.obj").string(), "-o", store, "-n", "20", "--texcoord",
                        "--colors"})
              .exit_code == 0);
  CHECK_FALSE(contains(meander_with({"info", store, "b.obj"}).out, "lacks"));
  const PolygonMesh again = mesh_of(scratch / "obj" / "b.obj", true);
  REQUIRE(again.colors.vertex.size() == 3 * again.x.size());
  for (std::size_t v = 0; v < again.x.size(); ++v)
    REQUIRE(std::abs(again.colors.vertex[3 * v] - again.x[v]) < 0.006);
  REQUIRE(remesh({textured, "-o", (scratch / "off").string(), "-n", "60", "--colors", "--format", "off"})
              .exit_code == 0);
  CHECK(mesh_of(scratch / "off" / "b.off", true).colors.vertex == again.colors.vertex);
}

TEST_CASE("remesh job: integers stay integers, without interpolated values") {
  const ScratchFolder scratch;
  std::ofstream(scratch / "a.ply")
      << "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
         "property float z\nproperty uchar label\nproperty uint big\nelement face 2\n"
         "property list uchar int vertex_indices\nproperty int kind\nend_header\n"
         "0 0 0 1 1\n1 0 0 40 4294967295\n1 1 0 40 1\n0 1 0 1 1\n3 0 1 2 5\n3 0 2 3 6\n";
  const ProcessResult made = remesh({(scratch / "a.ply").string(), "-o", (scratch / "out").string(), "-n",
                                     "60", "--attribute", "label,kind,big"});
  INFO(made.out << made.err);
  REQUIRE(made.exit_code == 0);
  const PolygonMesh mesh = mesh_of(scratch / "out" / "a.ply");
  const std::vector<double>&label = attribute_of(mesh, "label"), &kind = attribute_of(mesh, "kind");
  std::size_t ones = 0;
  for (std::size_t v = 0; v < mesh.x.size(); ++v) {
    REQUIRE((label[v] == 1 || label[v] == 40));
    REQUIRE((kind[v] == 5 || kind[v] == 6));
    ones += label[v] == 1;
  }
  CHECK((ones > 0 && ones < mesh.x.size()));
  for (const ScalarAttribute& attribute : mesh.vertex_attributes)
    CHECK(attribute.integers == (attribute.name != "big"));  // of which some vertices have none
  const ProcessResult linear = remesh({(scratch / "a.ply").string(), "-o", (scratch / "linear").string(),
                                       "-n", "60", "--attribute", "label:linear"});
  REQUIRE(linear.exit_code == 0);
  const PolygonMesh between = mesh_of(scratch / "linear" / "a.ply");
  for (std::size_t v = 0; v < between.x.size(); ++v)
    REQUIRE(std::abs(attribute_of(between, "label")[v] - (1 + 39 * between.x[v])) < 1e-3);
  const ProcessResult refused = remesh({(scratch / "a.ply").string(), "-o", (scratch / "no").string(), "-n",
                                        "60", "--attribute", "label:class"});
  CHECK(refused.exit_code == 2);
  CHECK(contains(refused.err, "`label:class` is for stores"));
}

TEST_CASE("remesh job: what a model lacks is reported, what a format cannot hold is refused") {
  const ScratchFolder scratch;
  make_models(scratch / "models");
  const std::string models = (scratch / "models").string();
  const ProcessResult made = remesh({models, "-o", (scratch / "out").string(), "-n", "40", "--colors",
                                     "--texcoord", "--attribute", "heat"});
  REQUIRE(made.exit_code == 0);
  CHECK(contains(made.out, "4 models have not all that the vertices should carry"));
  for (const auto& [id, item] : items_of(scratch / "out")) {
    CHECK(item.text("lacks").value_or("") == "colors,heat,texcoord");
    CHECK(contains(item.text("message").value_or(""), "colors,heat,texcoord"));
  }
  for (const std::vector<std::string>& wrong :
       std::vector<std::vector<std::string>>{{"--format", "off", "--texcoord"},
                                             {"--format", "off", "--attribute", "heat"},
                                             {"--format", "obj", "--attribute", "heat"},
                                             {"--attribute", "x"},
                                             {"--attribute", "two words"},
                                             {"--colors", "--attribute", "red"},
                                             {"--attribute", "a_1,a:2"}}) {
    std::vector<std::string> arguments = {models, "-o", (scratch / "no").string()};
    arguments.insert(arguments.end(), wrong.begin(), wrong.end());
    INFO(wrong.back());
    CHECK(remesh(arguments).exit_code == 2);
    CHECK_FALSE(fs::exists(scratch / "no"));
  }
}

TEST_CASE("remesh job: killed at any moment it leaves only complete files, and the same command resumes") {
  const ScratchFolder scratch;
  make_models(scratch / "models");
  const std::string models = (scratch / "models").string(), out = (scratch / "out").string();
  REQUIRE(remesh({models, "-o", (scratch / "whole").string(), "-n", "90"}).exit_code == 0);
  ProcessOptions options;
  options.environment = {{"MEANDER_TEST_FAULT", "slow:60"}};
  using std::chrono::milliseconds;
  const ProcessResult last =
      run_killed({fault_program, "remesh", models, "-o", out, "-n", "90", "-j", "1"}, options,
                 {3, 8, milliseconds(5), milliseconds(250)}, 0, [&] { fs::remove_all(out); });
  REQUIRE(last.exit_code == 0);
  CHECK(meshes_of(out) == meshes_of(scratch / "whole"));  // and no temporary file
  CHECK(items_of(out).size() == 4);
  CHECK_FALSE(fs::exists(fs::path(out) / "remesh.json.log"));
  CHECK_FALSE(fs::exists(fs::path(out) / "remesh.json.lock"));
}

TEST_CASE("remesh job: meshes that a killed process has logged are not made again") {
  const ScratchFolder scratch;
  make_models(scratch / "models");
  const std::string models = (scratch / "models").string(), out = (scratch / "out").string();
  ProcessOptions options;
  options.environment = {{"MEANDER_TEST_FAULT", "kill:box"}};  // the smallest, and so the last one
  const ProcessResult died =
      run_process({fault_program, "remesh", models, "-o", out, "-n", "90", "-j", "1"}, options);
  REQUIRE(died.signal == SIGKILL);
  REQUIRE(fs::exists(fs::path(out) / "remesh.json.log"));
  std::istringstream lines(read_file(fs::path(out) / "remesh.json.log"));
  int logged = 0;
  for (std::string line; std::getline(lines, line);) logged += contains(line, "\"record\"");
  REQUIRE(logged > 0);
  // A power cut may leave the last line in part.
  {
    std::ofstream log(fs::path(out) / "remesh.json.log", std::ios::app);
    log << "{\"id\":\"box.stl\",\"rec";
  }
  write_file(fs::path(out) / "box.ply.tmp123", "half");
  const ProcessResult again = remesh({models, "-o", out, "-n", "90", "--json"});
  REQUIRE(again.exit_code == 0);
  CHECK(JsonObject(again.out, "summary").integer("done_now") == 4 - logged);
  CHECK(items_of(out).size() == 4);
  CHECK_FALSE(fs::exists(fs::path(out) / "box.ply.tmp123"));
}

TEST_CASE("remesh job: an item that crashes the process is recorded, and skipped by later runs") {
  const ScratchFolder scratch;
  make_models(scratch / "models");
  const std::string models = (scratch / "models").string(), out = (scratch / "out").string();
  ProcessOptions options;
  options.environment = {{"MEANDER_TEST_FAULT", "segv:ring"}};
  const std::vector<std::string> command{fault_program, "remesh", models, "-o", out, "-n", "90"};
  REQUIRE(run_process(command, options).signal == SIGSEGV);
  for (int run = 0; run < 2; ++run) {
    const ProcessResult next = run_process(command, options);
    INFO(next.err);
    REQUIRE(next.exit_code == 3);
    const auto items = items_of(out);
    REQUIRE(items.size() == 4);
    CHECK(items.at("a/ring.obj").text("status") == "crashed");
    CHECK(contains(items.at("a/ring.obj").text("message").value_or(""), "place_samples"));
    CHECK(items.at("a/ball.off").text("status") == "ok");
  }
  // With --fresh it is tried again.
  CHECK(remesh({models, "-o", out, "-n", "90", "--fresh"}).exit_code == 0);
}

TEST_CASE("remesh job: only one process works in a folder at a time") {
  const ScratchFolder scratch;
  make_models(scratch / "models");
  const std::string models = (scratch / "models").string(), out = (scratch / "out").string();
  fs::create_directories(out);
  {
    const FileDescriptor held = lock_folder(out, "remesh.json.lock", false);
    const ProcessResult second = remesh({models, "-o", out, "-n", "50"});
    CHECK(second.exit_code == 75);
    CHECK(contains(second.err, "another process"));
    CHECK(meshes_of(out).empty());
  }
  CHECK(remesh({models, "-o", out, "-n", "50"}).exit_code == 0);
}

TEST_CASE("remesh job: an input of another size or date is remade, a missing one keeps its row") {
  const ScratchFolder scratch;
  make_models(scratch / "models");
  const std::string models = (scratch / "models").string(), out = (scratch / "out").string();
  REQUIRE(remesh({models, "-o", out, "-n", "60"}).exit_code == 0);
  write_mesh(scratch / "models/sheet.ply", grid_plane(5, 5));
  fs::last_write_time(scratch / "models/sheet.ply",
                      fs::file_time_type::clock::now() - std::chrono::hours(999));
  fs::remove(scratch / "models/box.stl");
  const ProcessResult second = remesh({models, "-o", out, "-n", "60", "--json"});
  REQUIRE(second.exit_code == 0);
  const JsonObject summary(second.out, "summary");
  CHECK(summary.integer("done_now") == 1);
  CHECK(summary.integer("vanished") == 1);
  CHECK(summary.integer("items") == 3);
  CHECK(items_of(out).contains("box.stl"));
  CHECK(fs::exists(fs::path(out) / "box.ply"));
}

TEST_CASE("remesh job: every item has a name of its own that no folder has") {
  const ScratchFolder scratch;
  const fs::path models = scratch / "models";
  const std::string out = (scratch / "out").string(), long_name(240, 'x');
  // a.off and a.obj become a.off.ply and a.obj.ply, which is taken; b.off would be the folder b.ply.
  for (const char* folder : {"", "b.ply", "d.off.ply"}) fs::create_directories(models / folder);
  for (const std::string name : {"a.off", "a.obj", "a.off.ply", "b.off", "b.ply/c.off", "d.off", "d.obj",
                                 "d.off.ply/e.off", "remesh.off"})
    write_mesh(models / name, tetrahedron());
  write_mesh(models / (long_name + ".off"), tetrahedron());
  const ProcessResult result = remesh({models.string(), "-o", out, "-n", "20"});
  INFO(result.err);
  REQUIRE(result.exit_code == 0);
  const auto items = items_of(out);
  REQUIRE(items.size() == 10);
  std::set<std::string> files;
  for (const auto& [id, record] : items) {
    const std::string file = record.text("file").value_or("");
    CHECK(files.insert(file).second);
    CHECK(mesh_of(fs::path(out) / file).x.size() >= 20);
  }
  CHECK(files.contains("a.obj.ply"));
  CHECK(files.contains("b~2.ply"));
  CHECK(meshes_of(out).size() == 10 - 1);  // remesh.ply is left out by its name
}

TEST_CASE("remesh job: a stopped run keeps what is done and resumes later") {
  const ScratchFolder scratch;
  make_models(scratch / "models");
  const std::string models = (scratch / "models").string(), out = (scratch / "out").string();
  ProcessOptions options;
  options.environment = {{"MEANDER_TEST_FAULT", "stop:sheet"}};
  const ProcessResult stopped =
      run_process({fault_program, "remesh", models, "-o", out, "-n", "90", "-j", "1"}, options);
  CHECK(stopped.exit_code == 75);
  CHECK(contains(stopped.err, "the same command continues"));
  CHECK(!items_of(out).contains("sheet.ply"));
  const ProcessResult again = remesh({models, "-o", out, "-n", "90"});
  CHECK(again.exit_code == 0);
  CHECK(items_of(out).size() == 4);
}

TEST_CASE("remesh job: the dirty meshes of the shared folder have the status of a run") {
  MEANDER_NEEDS_SHARED_DATA();
  const ScratchFolder scratch;
  const ProcessResult result = remesh(
      {shared_data("dirty").string(), "-o", (scratch / "out").string(), "-n", "50", "--progress", "none"});
  CHECK(result.exit_code == 3);
  std::size_t ok = 0;
  const auto items = items_of(scratch / "out");
  for (const auto& [id, record] : items) {
    ok += record.text("status") == "ok";
    CHECK(record.text("status") != "internal");
  }
  CHECK(items.size() == 81);
  CHECK(ok == 71);
}
