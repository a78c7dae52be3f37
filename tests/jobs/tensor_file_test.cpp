// `meander run --tensor file:PATH`: tensors from a text file, a folder of them and an HDF5 file.
#include <fmt/format.h>

#include <chrono>
#include <filesystem>
#include <map>

#include "io/store/store_reader.h"
#include "io/store/store_verify.h"
#include "support/catch.h"
#include "support/fault_program.h"
#include "support/hdf5_dataset.h"
#include "support/mesh_files.h"
#include "support/run_process.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;

namespace {

const std::string constant = "1,0.25,0,2,0,3";  // what all rows of the tables say
const std::vector<double> constant_row = {1, 0.25, 0, 2, 0, 3};

std::vector<std::string> tensors_command(const std::filesystem::path& input,
                                         const std::filesystem::path& store, const std::string& tensor,
                                         const std::vector<std::string>& more) {
  std::vector<std::string> arguments = {fault_program,  "run",      input.string(), "-o",
                                        store.string(), "-n",       "64",           "--method",
                                        "anisotropic",  "--tensor", tensor};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

ProcessResult run_tensors(const std::filesystem::path& input, const std::filesystem::path& store,
                          const std::string& tensor, const std::vector<std::string>& more = {}) {
  return run_process(tensors_command(input, store, tensor, more));
}

std::string file_of(const std::filesystem::path& path) { return "file:" + path.string(); }

// Small models by their ids.
std::map<std::string, PolygonMesh> models() {
  return {{"ball.off", icosphere(2)},
          {"plane.obj", grid_plane(5, 4, 1, 2)},
          {"tori/fat.off", torus(12, 8)},
          {"tori/thin.ply", moved(torus(16, 6), 2, 0, 1, 0)}};
}

std::map<std::string, PolygonMesh> write_models(const std::filesystem::path& folder) {
  const auto all = models();
  std::filesystem::create_directories(folder / "tori");
  for (const auto& [id, mesh] : all) write_mesh(folder / id, mesh);
  return all;
}

std::string rows_text(std::size_t rows, const std::string& row = "1 0.25 0 2 0 3") {
  std::string text = "# xx xy xz yy yz zz\n";
  for (std::size_t r = 0; r < rows; ++r) text += row + "\n";
  return text;
}

std::vector<double> rows_values(std::size_t rows) {
  std::vector<double> values;
  for (std::size_t r = 0; r < rows; ++r)
    values.insert(values.end(), constant_row.begin(), constant_row.end());
  return values;
}

// The points of both stores are those of the same tensors, whatever they came from.
void check_same_points(const StoreReader& a, const StoreReader& b, const std::string& id) {
  INFO(id);
  const Row one = a.read_row(*a.find(id)), two = b.read_row(*b.find(id));
  REQUIRE(one.report.status == Status::ok);
  CHECK(one.report.method == Method::anisotropic);
  CHECK(one.samples.points == two.samples.points);
  CHECK(one.samples.points.size() == 3 * 64);
}

void check_unreadable(const StoreReader& store, const ProcessResult& result, const std::string& id,
                      const std::string& sentence) {
  const ItemReport report = store.report(*store.find(id));
  INFO(id << ": " << report.reason);
  CHECK(report.status == Status::unreadable);
  CHECK(report.reason.find(sentence) != std::string::npos);
  CHECK(result.err.find(id + ": unreadable: ") != std::string::npos);
}

}  // namespace

TEST_CASE("run --tensor file: one text file per model gives the points of the same constant tensor") {
  const ScratchFolder scratch;
  write_mesh(scratch / "ball.off", icosphere(2));
  write_file(scratch / "t.txt", rows_text(icosphere(2).vertex_count()));
  const ProcessResult result =
      run_tensors(scratch / "ball.off", scratch / "s.h5", file_of(scratch / "t.txt"));
  INFO(result.err);
  REQUIRE(result.exit_code == 0);
  REQUIRE(run_tensors(scratch / "ball.off", scratch / "c.h5", "constant:" + constant).exit_code == 0);
  REQUIRE(run_tensors(scratch / "ball.off", scratch / "i.h5", "isotropic").exit_code == 0);
  const StoreReader store(scratch / "s.h5"), other(scratch / "c.h5"), isotropic(scratch / "i.h5");
  check_same_points(store, other, "ball.off");
  CHECK(store.read_row(0).samples.points != isotropic.read_row(0).samples.points);
  CHECK(store.parameters_json().find("file:" + (scratch / "t.txt").string()) != std::string::npos);
  CHECK(verify_store(scratch / "s.h5").problems.empty());
}

TEST_CASE("run --tensor file: a folder has ID.txt, or the id with .txt as its extension") {
  const ScratchFolder scratch;
  const auto all = write_models(scratch / "in");
  std::filesystem::create_directories(scratch / "t/tori");
  write_file(scratch / "t/ball.off.txt", rows_text(all.at("ball.off").vertex_count()));
  write_file(scratch / "t/ball.txt", rows_text(3));  // ID.txt comes first
  write_file(scratch / "t/tori/fat.txt", rows_text(all.at("tori/fat.off").vertex_count()));
  SECTION("whole") {
    write_file(scratch / "t/plane.obj.txt", rows_text(all.at("plane.obj").vertex_count()));
    write_file(scratch / "t/tori/thin.txt", rows_text(all.at("tori/thin.ply").vertex_count()));
    const ProcessResult result = run_tensors(scratch / "in", scratch / "s.h5", file_of(scratch / "t"));
    INFO(result.err);
    REQUIRE(result.exit_code == 0);
    REQUIRE(run_tensors(scratch / "in", scratch / "c.h5", "constant:" + constant).exit_code == 0);
    const StoreReader store(scratch / "s.h5"), other(scratch / "c.h5");
    for (const auto& [id, mesh] : all) check_same_points(store, other, id);
  }
  SECTION("one missing, one of another length; the others are done, and the missing one can be added") {
    write_file(scratch / "t/plane.txt", rows_text(3));
    const ProcessResult result = run_tensors(scratch / "in", scratch / "s.h5", file_of(scratch / "t"));
    INFO(result.err);
    REQUIRE(result.exit_code == 3);
    {
      const StoreReader store(scratch / "s.h5");
      REQUIRE(store.rows() == all.size());
      check_unreadable(
          store, result, "tori/thin.ply",
          "the tensors of " + (scratch / "t/tori/thin.txt").string() + ": the file cannot be opened");
      check_unreadable(store, result, "plane.obj", "the tensor table has 3 rows");
      for (const char* id : {"ball.off", "tori/fat.off"})
        CHECK(store.report(*store.find(id)).status == Status::ok);
    }
    CHECK(verify_store(scratch / "s.h5").problems.empty());
    write_file(scratch / "t/plane.txt", rows_text(all.at("plane.obj").vertex_count()));
    write_file(scratch / "t/tori/thin.ply.txt", rows_text(all.at("tori/thin.ply").vertex_count()));
    const ProcessResult again =
        run_tensors(scratch / "in", scratch / "s.h5", file_of(scratch / "t"), {"--retry", "unreadable"});
    INFO(again.err);
    REQUIRE(again.exit_code == 0);
    REQUIRE(run_tensors(scratch / "in", scratch / "calm.h5", file_of(scratch / "t")).exit_code == 0);
    CHECK(read_file(scratch / "s.h5") == read_file(scratch / "calm.h5"));
  }
  SECTION("rows that are not tensors") {
    write_file(scratch / "t/plane.txt", "1 2 3 4\n");
    write_file(scratch / "t/tori/thin.txt",
               rows_text(all.at("tori/thin.ply").vertex_count(), "-1 0 0 -1 0 -1"));
    write_file(scratch / "t/ball.off.txt", "# nothing\n");
    const ProcessResult result = run_tensors(scratch / "in", scratch / "s.h5", file_of(scratch / "t"));
    REQUIRE(result.exit_code == 3);
    const StoreReader store(scratch / "s.h5");
    check_unreadable(store, result, "plane.obj", "line 1: 4 numbers, but a row has six");
    check_unreadable(store, result, "tori/thin.ply", "positive definite");
    check_unreadable(store, result, "ball.off", "ball.off.txt: the tensor table has no row");
  }
}

TEST_CASE("run --tensor file: datasets of an HDF5 file are found by id, and mistakes fail their row") {
  const ScratchFolder scratch;
  const auto all = write_models(scratch / "in");
  const auto file = scratch / "t.h5";
  const auto add = [&](const std::string& id, std::size_t rows) {
    add_hdf5_dataset(file, id, {rows, 6}, rows_values(rows));
  };
  add("ball.off", all.at("ball.off").vertex_count());
  add("tori/fat.off", all.at("tori/fat.off").vertex_count());
  SECTION("whole") {
    add("plane.obj", all.at("plane.obj").vertex_count());
    add("tori/thin.ply", all.at("tori/thin.ply").vertex_count());
    const ProcessResult result = run_tensors(scratch / "in", scratch / "s.h5", file_of(file));
    INFO(result.err);
    REQUIRE(result.exit_code == 0);
    REQUIRE(run_tensors(scratch / "in", scratch / "c.h5", "constant:" + constant).exit_code == 0);
    const StoreReader store(scratch / "s.h5"), other(scratch / "c.h5");
    for (const auto& [id, mesh] : all) check_same_points(store, other, id);
  }
  SECTION("one missing, one of another shape") {
    add_hdf5_dataset(file, "plane.obj", {all.at("plane.obj").vertex_count(), 4},
                     std::vector<double>(4 * all.at("plane.obj").vertex_count(), 1));
    const ProcessResult result = run_tensors(scratch / "in", scratch / "s.h5", file_of(file));
    REQUIRE(result.exit_code == 3);
    const StoreReader store(scratch / "s.h5");
    check_unreadable(store, result, "tori/thin.ply", "open /tori/thin.ply");
    check_unreadable(store, result, "plane.obj", "not of the shape V x 6 or V x 3");
    for (const char* id : {"ball.off", "tori/fat.off"})
      CHECK(store.report(*store.find(id)).status == Status::ok);
  }
  SECTION("another number of rows, vectors") {
    add("plane.obj", 7);
    std::vector<double> vectors;
    for (std::size_t v = 0; v < all.at("tori/thin.ply").vertex_count(); ++v)
      vectors.insert(vectors.end(), {0, 0, 2});
    add_hdf5_dataset(file, "tori/thin.ply", {vectors.size() / 3, 3}, vectors);
    const ProcessResult result = run_tensors(scratch / "in", scratch / "s.h5", file_of(file));
    REQUIRE(result.exit_code == 3);
    const StoreReader store(scratch / "s.h5");
    check_unreadable(store, result, "plane.obj",
                     fmt::format("has 7 rows, but the mesh {} vertices", all.at("plane.obj").vertex_count()));
    CHECK(store.report(*store.find("tori/thin.ply")).status == Status::ok);
  }
  SECTION("no HDF5 at all") {
    write_file(scratch / "x.h5", "no such format");
    const ProcessResult result = run_tensors(scratch / "in", scratch / "s.h5", file_of(scratch / "x.h5"));
    REQUIRE(result.exit_code == 3);
    const StoreReader store(scratch / "s.h5");
    for (const auto& [id, mesh] : all) check_unreadable(store, result, id, "x.h5");
  }
}

TEST_CASE("run --tensor file: killed and restarted, it ends with the bytes of an undisturbed run",
          "[release]") {
  const ScratchFolder scratch;
  auto all = write_models(scratch / "in");
  for (std::uint32_t i = 0; i < 8; ++i) {
    const std::string id = fmt::format("more{}.off", i);
    all[id] = torus(10 + i, 6);
    write_mesh(scratch / ("in/" + id), all[id]);
  }
  // One without tensors: failed rows are kept too.
  const auto file = scratch / "t.h5";
  for (const auto& [id, mesh] : all)
    if (id != "more5.off")
      add_hdf5_dataset(file, id, {mesh.vertex_count(), 6}, rows_values(mesh.vertex_count()));
  REQUIRE(run_tensors(scratch / "in", scratch / "calm.h5", file_of(file), {"-j", "1"}).exit_code == 3);
  ProcessOptions options;
  options.environment = {{"MEANDER_TEST_FAULT", "slow:40"}};
  // More threads would be done before the first kill.
  const ProcessResult result =
      run_killed(tensors_command(scratch / "in", scratch / "s.h5", file_of(file), {"-j", "2"}), options,
                 {2, 6, std::chrono::milliseconds(60), std::chrono::milliseconds(210)}, 3,
                 [&] { std::filesystem::remove(scratch / "s.h5"); });
  INFO(result.err);
  REQUIRE(result.exit_code == 3);
  CHECK(read_file(scratch / "calm.h5") == read_file(scratch / "s.h5"));
  CHECK_FALSE(std::filesystem::exists(scratch / "s.h5.run"));
}

TEST_CASE("run --tensor file: refused with --reuse, without its method, without the file") {
  const ScratchFolder scratch;
  write_mesh(scratch / "ball.off", icosphere(1));
  write_file(scratch / "t.txt", rows_text(icosphere(1).vertex_count()));
  REQUIRE(run_tensors(scratch / "ball.off", scratch / "s.h5", file_of(scratch / "t.txt")).exit_code == 0);
  const auto says = [&](const ProcessResult& result, const std::string& text) {
    INFO(result.err);
    CHECK(result.exit_code == 2);
    CHECK(result.err.find(text) != std::string::npos);
    CHECK_FALSE(std::filesystem::exists(scratch / "x.h5"));
  };
  says(run_tensors(scratch / "ball.off", scratch / "x.h5", file_of(scratch / "t.txt"),
                   {"--reuse", (scratch / "s.h5").string()}),
       "--reuse identifies rows by their mesh alone");
  says(run_tensors(scratch / "ball.off", scratch / "x.h5", file_of(scratch / "no.txt")),
       "no such file or folder");
  says(run_tensors(scratch / "ball.off", scratch / "x.h5", "file:"), "no such file or folder");
  says(run_process({fault_program, "run", scratch / "ball.off", "-o", scratch / "x.h5", "--tensor",
                    file_of(scratch / "t.txt")}),
       "--tensor applies to --method anisotropic only");
  // Another file of tensors is another store.
  write_file(scratch / "u.txt", rows_text(icosphere(1).vertex_count(), "3 0 0 1 0 1"));
  const ProcessResult other = run_tensors(scratch / "ball.off", scratch / "s.h5", file_of(scratch / "u.txt"));
  CHECK(other.exit_code == 2);
  CHECK(other.err.find("other parameters") != std::string::npos);
}
