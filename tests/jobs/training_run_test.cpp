// `run --sharp` and `--queries` as a user sees them: its columns, and all that is done with such stores.
#include <fmt/format.h>

#include <cmath>
#include <csignal>
#include <filesystem>

#include "io/store/store_reader.h"
#include "support/catch.h"
#include "support/fault_program.h"
#include "support/meander_program.h"
#include "support/mesh_files.h"
#include "support/sanitized.h"
#include "support/store_rows.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;
using Catch::Matchers::ContainsSubstring;

namespace {

namespace fs = std::filesystem;
using Words = std::vector<std::string>;

Words joined(Words words, const Words& more) {
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

ProcessResult run_sets(const fs::path& input, const fs::path& store, const Words& more) {
  return meander_with(joined({"run", input.string(), "-o", store.string(), "--progress", "none"}, more));
}

void put_models(const fs::path& folder) {
  fs::create_directories(folder);
  write_mesh(folder / "a_cube.off", cube(), MeshFile::off);
  write_mesh(folder / "b_ball.off", icosphere(3), MeshFile::off);
  write_mesh(folder / "c_far.off", moved(cube(), 3, 1e4, 0, -1e4), MeshFile::off);
  write_file(folder / "d_broken.off", "OFF\nnothing\n");
  write_mesh(folder / "e_plate.off", two_sided_plate(4, 0.1), MeshFile::off);
}

void require_verified(const fs::path& store) {
  const ProcessResult result = meander_with({"verify", store.string()});
  INFO(result.out << result.err);
  REQUIRE(result.exit_code == 0);
}

}  // namespace

TEST_CASE("run --sharp: every model has its points, and those without a sharp edge are counted") {
  const ScratchFolder scratch;
  put_models(scratch / "in");
  const ProcessResult result = run_sets(scratch / "in", scratch / "s.h5", {"-n", "64", "--sharp", "240"});
  INFO(result.out << result.err);
  REQUIRE(result.exit_code == 3);  // the broken file
  CHECK_THAT(result.out, ContainsSubstring("no sharp edge"));
  require_verified(scratch / "s.h5");
  const Row square = row_of(scratch / "s.h5", "a_cube.off");
  CHECK(square.report.sharp_edges == 12);
  CHECK(square.report.sharp_length == Approx(24));
  REQUIRE(square.samples.sharp_points.size() == 720);
  CHECK(square.samples.points.size() == 192);
  for (std::size_t i = 0; i < 240; ++i) {
    int at_side = 0;
    for (std::size_t k = 0; k < 3; ++k)
      at_side += std::abs(square.samples.sharp_points[3 * i + k]) > 0.99999f;
    CHECK(at_side >= 2);
  }
  const Row far = row_of(scratch / "s.h5", "c_far.off");
  CHECK(far.report.sharp_length == Approx(72));
  const Row ball = row_of(scratch / "s.h5", "b_ball.off");
  CHECK(ball.report.sharp_edges == 0);
  CHECK(ball.samples.sharp_edge == std::vector<std::uint32_t>(240, no_sharp_edge));
  CHECK(
      std::equal(ball.samples.points.begin(), ball.samples.points.end(), ball.samples.sharp_points.begin()));
  const ProcessResult info = meander_with({"info", "--json", (scratch / "s.h5").string()});
  CHECK_THAT(info.out, ContainsSubstring("\"items_without_sharp_edge\":1"));
  CHECK_THAT(info.out, ContainsSubstring("sharp/points"));
  const ProcessResult item = meander_with({"info", "--json", (scratch / "s.h5").string(), "a_cube.off"});
  CHECK_THAT(item.out, ContainsSubstring("\"sharp_edges\":12"));

  REQUIRE(run_sets(scratch / "in", scratch / "n.h5",
                   {"-n", "64", "--sharp", "240", "--sharp-fill", "nan", "--sharp-angle", "91"})
              .exit_code == 3);
  require_verified(scratch / "n.h5");
  CHECK(std::isnan(row_of(scratch / "n.h5", "a_cube.off").samples.sharp_points.front()));
  // The samples are those of a store without the option.
  REQUIRE(run_sets(scratch / "in", scratch / "p.h5", {"-n", "64"}).exit_code == 3);
  CHECK(row_of(scratch / "p.h5", "c_far.off").samples.points == far.samples.points);
}

TEST_CASE("run --sharp: threads, kills, shards and merges give the same bytes, whatever fits into a chunk") {
  const ScratchFolder scratch;
  put_models(scratch / "in");
  // Several rows in a chunk; one row; sharp points alone, and samples alone, in several chunks of a row.
  const Words sizes[] = {{"-n", "100", "--sharp", "40"},
                         {"-n", "100", "--sharp", "3000"},
                         {"-n", "64", "--sharp", "100000"},
                         {"-n", "100000", "--sharp", "64"},
                         {"-n", "100", "--queries", "near=40@.01 volume=30@1"},
                         {"-n", "100", "--queries", "near=1000@.01,.05 near-sharp=500@.01 volume=800@1.1",
                          "--sharp", "3000", "--queries-type", "float16", "--queries-nearest"},
                         {"-n", "64", "--queries", "volume=100000@1.05", "--queries-type", "float16"}};
  int number = 0;
  for (const Words& size : sizes) {
    if (sanitized && number > 0 && size.size() < 8) continue;  // release builds try all
    CAPTURE(size);
    const Words words = joined(size, {"--normalize", "unit-sphere"});
    const fs::path folder = scratch / fmt::format("set{}", number++);
    fs::create_directories(folder);
    REQUIRE(run_sets(scratch / "in", folder / "one.h5", joined(words, {"-j", "1"})).exit_code == 3);
    require_verified(folder / "one.h5");
    const std::string expected = read_file(folder / "one.h5");
    REQUIRE(run_sets(scratch / "in", folder / "two.h5", joined(words, {"-j", "4"})).exit_code == 3);
    CHECK(read_file(folder / "two.h5") == expected);

    const Words plan = {"plan", (scratch / "in").string(), "-o", (folder / "array.h5").string(), "--shards",
                        "2"};
    REQUIRE(meander_with(joined(plan, words)).exit_code == 0);
    for (const char* shard : {"0/2", "1/2"})
      meander_with({"run", (folder / "array.h5.run").string(), "--shard", shard, "--progress", "none"});
    REQUIRE(meander_with({"merge", (folder / "array.h5.run").string()}).exit_code == 3);
    CHECK(read_file(folder / "array.h5") == expected);

    ProcessOptions killed;
    killed.environment = {{"MEANDER_TEST_FAULT", "kill:c_far"}};
    const Words command = {fault_program,
                           "run",
                           (scratch / "in").string(),
                           "-o",
                           (folder / "k.h5").string(),
                           "--progress",
                           "none",
                           "-j",
                           "1"};
    REQUIRE(run_process(joined(command, words), killed).signal == SIGKILL);
    REQUIRE(run_process(joined(command, words)).exit_code == 3);
    CHECK(read_file(folder / "k.h5") == expected);

    REQUIRE(run_sets(scratch / "in", folder / "reused.h5", joined(words, {"--reuse", folder / "one.h5"}))
                .exit_code == 3);
    CHECK(read_file(folder / "reused.h5") == expected);
  }
}

TEST_CASE("run --sharp: a store is continued only with the same edges, and exports have them") {
  const ScratchFolder scratch;
  put_models(scratch / "in");
  const Words words = {"-n", "50", "--sharp", "60", "--normalize", "unit-box"};
  REQUIRE(run_sets(scratch / "in", scratch / "s.h5", words).exit_code == 3);
  const ProcessResult other =
      run_sets(scratch / "in", scratch / "s.h5", joined(words, {"--sharp-angle", "40"}));
  CHECK(other.exit_code == 2);
  CHECK_THAT(other.err, ContainsSubstring("sharp_angle"));
  const ProcessResult alone = run_sets(scratch / "in", scratch / "x.h5", {"--sharp-fill", "nan"});
  CHECK(alone.exit_code == 2);
  CHECK_THAT(alone.err, ContainsSubstring("--sharp"));
  const ProcessResult npz =
      meander_with({"export", (scratch / "s.h5").string(), "-o", (scratch / "out").string(), "--format",
                    "npz", "--arrays", "points,sharp_points,sharp_normals,sharp_edge", "--frame", "file"});
  INFO(npz.out << npz.err);
  REQUIRE(npz.exit_code == 0);
  const std::string file = read_file(scratch / "out/a_cube.off.npz");
  CHECK(contains(file, "sharp_points.npy"));
  CHECK(contains(file, "'descr': '<f8', 'fortran_order': False, 'shape': (60, 3)"));
  REQUIRE(run_sets(scratch / "in", scratch / "plain.h5", {"-n", "50"}).exit_code == 3);
  const ProcessResult without =
      meander_with({"export", (scratch / "plain.h5").string(), "-o", (scratch / "no").string(), "--format",
                    "npz", "--arrays", "sharp_points"});
  CHECK(without.exit_code == 2);
  CHECK_THAT(without.err, ContainsSubstring("--sharp"));
  const ProcessResult merged =
      meander_with({"merge", (scratch / "s.h5").string(), (scratch / "plain.h5").string(), "-o",
                    (scratch / "m.h5").string()});
  CHECK(merged.exit_code == 2);
}

TEST_CASE("run --sharp-corners and --sharp-attribute: corners come first, borders of materials are edges") {
  const ScratchFolder scratch;
  fs::create_directories(scratch / "in");
  write_file(scratch / "in/sheet.obj",
             "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 0 1 0\nv 1 1 0\nv 2 1 0\n"
             "usemtl red\nf 1 2 5 4\nusemtl blue\nf 2 3 6 5\n");
  const Words words = {"-n", "16", "--attribute", "material", "--sharp", "10"};
  const Words borders = joined(words, {"--sharp-attribute", "material"});
  REQUIRE(run_sets(scratch / "in", scratch / "plain.h5", words).exit_code == 0);
  CHECK(row_of(scratch / "plain.h5", "sheet.obj").report.sharp_edges == 0);
  REQUIRE(run_sets(scratch / "in", scratch / "s.h5", borders).exit_code == 0);
  require_verified(scratch / "s.h5");
  const Row row = row_of(scratch / "s.h5", "sheet.obj");
  CHECK(row.report.sharp_edges == 1);
  for (std::size_t i = 0; i < 10; ++i) CHECK(row.samples.sharp_points[3 * i] == 1);
  REQUIRE(run_sets(scratch / "in", scratch / "c.h5", joined(borders, {"--sharp-corners"})).exit_code == 0);
  require_verified(scratch / "c.h5");
  const Row corners = row_of(scratch / "c.h5", "sheet.obj");
  CHECK(corners.samples.sharp_points[1] + corners.samples.sharp_points[4] == 1);
  CHECK(std::abs(corners.samples.sharp_points[1] - corners.samples.sharp_points[4]) == 1);
  const ProcessResult other = run_sets(scratch / "in", scratch / "s.h5", words);
  CHECK(other.exit_code == 2);
  CHECK_THAT(other.err, ContainsSubstring("sharp_attribute"));
  const ProcessResult unnamed =
      run_sets(scratch / "in", scratch / "x.h5", {"-n", "16", "--sharp", "10", "--sharp-attribute", "part"});
  CHECK(unnamed.exit_code == 2);
  CHECK_THAT(unnamed.err, ContainsSubstring("`part`"));
}

TEST_CASE("run --queries: signed distances of every model, their rules counted, and read back") {
  const ScratchFolder scratch;
  put_models(scratch / "in");
  write_mesh(scratch / "in/f_sheet.off", grid_plane(4, 4), MeshFile::off);
  const Words words = {"-n", "64", "--normalize", "unit-box", "--queries", "near=400@.01,.05 volume=300@0.6"};
  const ProcessResult result = run_sets(scratch / "in", scratch / "s.h5", words);
  INFO(result.out << result.err);
  REQUIRE(result.exit_code == 3);  // the broken file
  CHECK_THAT(result.out, ContainsSubstring("sign: closed"));
  CHECK_THAT(result.out, ContainsSubstring("sign: shell"));
  require_verified(scratch / "s.h5");
  const StoreReader store(scratch / "s.h5");
  CHECK(store.columns().query_groups == std::vector<std::string>{"near@0.01", "near@0.05", "volume@0.6"});
  const Row square = row_of(scratch / "s.h5", "a_cube.off");
  CHECK(square.report.sign_rule == SignRule::closed);
  REQUIRE(square.samples.query_points.size() == 2100);
  for (std::size_t i = 0; i < 700; ++i) {  // the cube is [-1/2, 1/2]^3 in this frame
    double over = -1;
    for (std::size_t k = 0; k < 3; ++k)
      over = std::max(over, std::abs(double{square.samples.query_points[3 * i + k]}) - 0.5);
    CHECK((square.samples.query_inside[i] != 0) == (over < 0));
    if (over < 0) CHECK(double{square.samples.query_distance[i]} == Approx(over).margin(1e-6));
  }
  // The same model elsewhere and larger has the same points in a frame, but for the content that keys them.
  CHECK(row_of(scratch / "s.h5", "c_far.off").report.sign_rule == SignRule::closed);
  const Row sheet = row_of(scratch / "s.h5", "f_sheet.off");
  CHECK(sheet.report.sign_rule == SignRule::shell);
  CHECK(sheet.report.uncertain ==
        std::count(sheet.samples.query_certain.begin(), sheet.samples.query_certain.end(), 0));
  const ProcessResult info = meander_with({"info", "--json", (scratch / "s.h5").string()});
  CHECK_THAT(info.out, ContainsSubstring("\"sign_rule\":{\"shell\":1,\"closed\":4}"));

  REQUIRE(run_sets(scratch / "in", scratch / "n.h5", joined(words, {"--sign", "none", "--queries-nearest"}))
              .exit_code == 3);
  require_verified(scratch / "n.h5");
  const Row bare = row_of(scratch / "n.h5", "a_cube.off");
  CHECK(bare.samples.query_points == square.samples.query_points);
  CHECK(bare.samples.query_inside.empty());
  CHECK(bare.samples.query_face.size() == 700);
  const ProcessResult without =
      meander_with({"export", (scratch / "n.h5").string(), "-o", (scratch / "no").string(), "--format", "npz",
                    "--arrays", "queries_inside"});
  CHECK(without.exit_code == 2);
  CHECK_THAT(without.err, ContainsSubstring("--sign none"));

  REQUIRE(
      run_sets(scratch / "in", scratch / "h.h5", joined(words, {"--queries-type", "float16"})).exit_code ==
      3);
  require_verified(scratch / "h.h5");
  CHECK(fs::file_size(scratch / "h.h5") < fs::file_size(scratch / "s.h5"));
}

TEST_CASE(
    "run --queries-move: moves are recorded where they are others, and a store is continued with them") {
  const ScratchFolder scratch;
  put_models(scratch / "in");
  const Words words = {"-n", "64", "--queries", "near=400@.05 volume=100@1"};
  REQUIRE(run_sets(scratch / "in", scratch / "g.h5", words).exit_code == 3);
  REQUIRE(run_sets(scratch / "in", scratch / "same.h5",
                   joined(words, {"--queries-move", "gaussian", "--queries-cut", "0"}))
              .exit_code == 3);
  CHECK(read_file(scratch / "g.h5") == read_file(scratch / "same.h5"));
  CHECK_THAT(StoreReader(scratch / "g.h5").parameters_json(), !ContainsSubstring("queries_move"));
  const Words cut = {"--queries-move", "along-normal", "--queries-cut", "0.06"};
  REQUIRE(run_sets(scratch / "in", scratch / "n.h5", joined(words, cut)).exit_code == 3);
  require_verified(scratch / "n.h5");
  CHECK_THAT(StoreReader(scratch / "n.h5").parameters_json(),
             ContainsSubstring("\"queries_cut\":0.06,\"queries_move\":\"along-normal\""));
  const Row row = row_of(scratch / "n.h5", "e_plate.off");
  const double half =
      std::max(row.report.bbox[3] - row.report.bbox[0], row.report.bbox[5] - row.report.bbox[2]) / 2;
  for (std::size_t i = 0; i < 500; ++i)
    if (row.samples.query_kind[i] == 0)
      CHECK(std::abs(double{row.samples.query_distance[i]}) <= 0.06 * half * (1 + 1e-5));
  const ProcessResult other =
      run_sets(scratch / "in", scratch / "n.h5", joined(words, {"--queries-move", "along-normal"}));
  CHECK(other.exit_code == 2);
  CHECK_THAT(other.err, ContainsSubstring("queries_cut"));
  for (const auto& [more, why] : std::vector<std::pair<Words, std::string>>{
           {{"--queries", "volume=10@1", "--queries-move", "uniform"}, "near"},
           {{"--queries", "near=10@1", "--queries-move", "normal"}, "along-normal"},
           {{"--queries", "near=10@1", "--queries-cut", "-1"}, "--queries-cut"},
           {{"--queries", "near=10@1", "--queries-move", "uniform", "--queries-cut", "1"}, "Gaussian"}}) {
    const ProcessResult result = run_sets(scratch / "in", scratch / "x.h5", more);
    CHECK(result.exit_code == 2);
    CHECK_THAT(result.err, ContainsSubstring(why));
  }
}

TEST_CASE("run --queries: what cannot be is refused, and soups are queried without their topology") {
  const ScratchFolder scratch;
  put_models(scratch / "in");
  for (const auto& [words, why] : std::vector<std::pair<Words, std::string>>{
           {{"--queries", "near=10"}, "size"},
           {{"--queries", "nowhere=10@1"}, "near-sharp"},
           {{"--sign", "closed"}, "--queries"},
           {{"--queries", "volume=10@1", "--queries-type", "float16"}, "float16"}}) {
    const ProcessResult result = run_sets(scratch / "in", scratch / "x.h5", words);
    CHECK(result.exit_code == 2);
    CHECK_THAT(result.err, ContainsSubstring(why));
  }
  const Words words = {"-n", "50", "--queries", "near=100@.05 volume=100@1"};
  REQUIRE(run_sets(scratch / "in", scratch / "s.h5", joined(words, {"--topology", "none"})).exit_code == 3);
  require_verified(scratch / "s.h5");
  const Row soup = row_of(scratch / "s.h5", "a_cube.off");
  CHECK(soup.report.sign_rule == SignRule::closed);
  REQUIRE(run_sets(scratch / "in", scratch / "t.h5", words).exit_code == 3);
  CHECK(row_of(scratch / "t.h5", "a_cube.off").samples.query_inside == soup.samples.query_inside);
  // Methods with charts, and anisotropic ones.
  for (const char* method : {"conformal", "anisotropic"}) {
    REQUIRE(run_sets(scratch / "in", scratch / (std::string(method) + ".h5"),
                     joined(words, {"--method", method, "--sharp", "60"}))
                .exit_code == 3);
    require_verified(scratch / (std::string(method) + ".h5"));
    const Row row = row_of(scratch / (std::string(method) + ".h5"), "a_cube.off");
    CHECK(row.report.sign_rule == SignRule::closed);
    CHECK(row.report.sharp_edges == 12);
  }
}
