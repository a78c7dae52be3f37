// meander describe: descriptors for a finished store; basics; export of descriptors.
#include <sys/resource.h>
#include <sys/stat.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <sstream>

#include "io/store/run_directory.h"
#include "io/store/store_reader.h"
#include "io/store/store_verify.h"
#include "support/catch.h"
#include "support/meander_program.h"
#include "support/mesh_files.h"
#include "support/sanitized.h"
#include "support/store_rows.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;

namespace {

namespace fs = std::filesystem;

std::vector<std::string> operator+(std::vector<std::string> a, const std::vector<std::string>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

// Five models and an invalid file.
struct Collection {
  ScratchFolder scratch;
  std::string in = scratch / "in";

  Collection() {
    fs::create_directories(in);
    write_mesh(scratch / "in/ball.off", icosphere(3));
    write_mesh(scratch / "in/ring.off", torus(24, 12));
    write_mesh(scratch / "in/cube.off", cube());
    write_mesh(scratch / "in/sheet.off", moved(grid_plane(9, 5), 3, 1, 2, 3));
    write_mesh(scratch / "in/two.off", merged(icosphere(2), moved(icosphere(2), 1, 5, 0, 0)));
    write_file(scratch / "in/broken.off", "OFF\n3 1 0\n0 0\n");
  }
  std::string path(const char* name) const { return scratch / name; }
  // Exit code 3: the broken file.
  void sample(const char* name, const std::vector<std::string>& more = {}) const {
    const ProcessResult result = meander_with(
        std::vector<std::string>{"run", in, "-o", path(name), "-n", "300", "--progress", "none"} + more);
    INFO(result.err);
    REQUIRE(result.exit_code == 3);
  }
  ProcessResult describe(const char* name, const std::vector<std::string>& more) const {
    return meander_with(std::vector<std::string>{"describe", path(name)} + more);
  }
};

// Not compared by the macros, which would print the files.
bool same_bytes(const std::string& a, const std::string& b) { return read_file(a) == read_file(b); }

std::vector<float> values_of(const std::string& store, const char* id, const char* descriptor) {
  const StoreReader reader(store);
  for (const DescriptorRow& row : reader.read_row(*reader.find(id)).descriptors)
    if (row.name == descriptor) return row.values;
  return {};
}

}  // namespace

TEST_CASE("describe: the same bytes as run --describe, at once and in steps, for any threads", "[release]") {
  const Collection c;
  const std::vector<std::string> sampling = {"--normalize", "unit-sphere", "--seed", "7", "--certify"},
                                 shape = {"--bins", "16", "--descriptor-scale", "largest"};
  c.sample("all.h5", sampling + shape +
                         std::vector<std::string>{"--describe", "d2,a3,d1,d3,d4,geodesic,basics",
                                                  "--geodesic-sources", "9"});
  c.sample("plain.h5", sampling);
  const std::string plain = read_file(c.path("plain.h5"));

  const ProcessResult once = c.describe(
      "plain.h5", std::vector<std::string>{c.in, "--descriptors", "d2,a3,d1,d3,d4,geodesic,basics", "-o",
                                           c.path("once.h5"), "--geodesic-sources", "9", "-j", "1"} +
                      shape);
  INFO(once.err << once.out);
  REQUIRE(once.exit_code == 0);
  CHECK(contains(once.out, "5 rows described with d2,a3,d1,d3,d4,geodesic,basics"));
  CHECK(contains(once.out, "1 without samples"));
  CHECK(same_bytes(c.path("once.h5"), c.path("all.h5")));
  CHECK((read_file(c.path("plain.h5")) == plain));
  CHECK_FALSE(fs::exists(c.path("once.h5.run")));

  REQUIRE(
      c.describe("plain.h5", std::vector<std::string>{"--descriptors", "d2,a3,d1,d3,d4", "-j", "2"} + shape)
          .exit_code == 0);
  REQUIRE(c.describe("plain.h5", std::vector<std::string>{c.in, "--descriptors", "geodesic,basics",
                                                          "--geodesic-sources", "9"} +
                                     shape)
              .exit_code == 0);
  CHECK(same_bytes(c.path("plain.h5"), c.path("all.h5")));
  CHECK(verify_store(c.path("plain.h5")).problems.empty());

  // And again over what is there.
  REQUIRE(c.describe("plain.h5", std::vector<std::string>{c.in, "--descriptors", "geodesic", "--replace",
                                                          "--geodesic-sources", "9"} +
                                     shape)
              .exit_code == 0);
  CHECK(same_bytes(c.path("plain.h5"), c.path("all.h5")));
}

TEST_CASE("describe: row ranges, merged, equal the result of one process") {
  const Collection models;
  models.sample("s.h5");
  REQUIRE(models.describe("s.h5", {"-o", models.path("whole.h5"), "--descriptors", "d2,a3"}).exit_code == 0);
  for (const int shards : thinned<int>(2, {9, 2, 1, 5})) {
    std::vector<std::string> parts;
    for (int i = shards - 1; i >= 0; --i) {
      const std::string part = models.path(("part" + std::to_string(i) + ".h5").c_str());
      const ProcessResult result =
          models.describe("s.h5", {"-o", part, "--descriptors", "d2,a3", "--fresh", "--shard",
                                   std::to_string(i) + "/" + std::to_string(shards)});
      INFO(result.err);
      REQUIRE(result.exit_code == 0);
      if (fs::exists(part))
        parts.push_back(part);
      else
        CHECK(contains(result.out, "has no rows"));
    }
    CHECK(parts.size() == std::min<std::size_t>(shards, 6));
    REQUIRE(meander_with(std::vector<std::string>{"merge"} + parts +
                         std::vector<std::string>{"-o", models.path("merged.h5"), "--fresh"})
                .exit_code == 3);  // the broken file
    CHECK(same_bytes(models.path("merged.h5"), models.path("whole.h5")));
    for (const std::string& part : parts) fs::remove(part);
  }
  const auto fails = [&](const std::vector<std::string>& more, const char* why) {
    const ProcessResult result =
        models.describe("s.h5", std::vector<std::string>{"--descriptors", "d2"} + more);
    INFO(result.err);
    CHECK(result.exit_code == 2);
    CHECK(contains(result.err, why));
  };
  fails({"--shard", "0/2"}, "name another store for it with -o");
  fails({"--shard", "0/2", "-o", models.path("s.h5")}, "cannot replace the whole");
  fails({"--shard", "2/2", "-o", models.path("t.h5")}, "numbered from 0 to 1");
  fails({"--shard", "two", "-o", models.path("t.h5")}, "is not of the form i/n");
}

TEST_CASE("describe: a missing or changed mesh fails its row alone") {
  const Collection c;
  c.sample("s.h5");
  c.sample("whole.h5", {"--describe", "d2,geodesic"});
  fs::remove(c.path("in/ring.off"));
  write_mesh(c.path("in/cube.off"), icosphere(1));
  const ProcessResult result =
      c.describe("s.h5", {c.in, "--descriptors", "d2,geodesic", "--progress", "plain"});
  INFO(result.err << result.out);
  CHECK(result.exit_code == 3);
  CHECK(contains(result.err, "ring.off: unreadable: no file of this id is in the input"));
  CHECK(contains(result.err, "cube.off: unreadable: `" + c.path("in/cube.off") + "` is not the file"));
  CHECK(contains(result.out, "2 rows could not be described completely"));
  CHECK(verify_store(c.path("s.h5")).problems.empty());
  for (const char* id : {"ring.off", "cube.off"})
    for (const char* lacking : {"geodesic", "geodesic_disconnected"}) {
      const std::vector<float> values = values_of(c.path("s.h5"), id, lacking);
      CHECK(values.size() == (std::string(lacking) == "geodesic" ? 32 : 1));
      CHECK(std::all_of(values.begin(), values.end(), [](float v) { return std::isnan(v); }));
    }
  for (const char* id : {"ball.off", "sheet.off", "two.off"})
    CHECK(values_of(c.path("s.h5"), id, "geodesic") == values_of(c.path("whole.h5"), id, "geodesic"));
  for (const char* id : {"ball.off", "ring.off", "cube.off", "sheet.off", "two.off"})
    CHECK(values_of(c.path("s.h5"), id, "d2") == values_of(c.path("whole.h5"), id, "d2"));
  // Nothing is similar to a row that has no descriptor.
  const ProcessResult query = meander_with(
      {"retrieve", "query", c.path("s.h5"), "ball.off", "--descriptor", "geodesic", "-k", "10", "--json"});
  CHECK(query.exit_code == 0);
  CHECK_FALSE(contains(query.out, "ring.off"));
  CHECK(contains(query.out, "\"not_finite\":2"));
}

TEST_CASE("describe: rows that time out are NaN and named, and the store is finished") {
  const Collection c;
  for (const char* descriptors : {"d1,a3", "d2,geodesic"}) {
    c.sample("s.h5", {"--fresh"});
    // One nanosecond: less than lies between any two readings of the clock.
    std::vector<std::string> arguments = {"--descriptors", descriptors, "--timeout", "0.000000001s"};
    if (contains(descriptors, "geodesic")) arguments.insert(arguments.begin(), c.in);
    const ProcessResult result = c.describe("s.h5", arguments);
    INFO(result.err << result.out);
    CHECK(result.exit_code == 3);
    CHECK(contains(result.out, "5 rows could not be described completely"));
    CHECK(contains(result.out, "ball.off: timeout: "));
    CHECK(verify_store(c.path("s.h5")).problems.empty());
    const std::string first = std::string(descriptors).substr(0, 2);
    const std::vector<float> values = values_of(c.path("s.h5"), "ball.off", first.c_str());
    CHECK(values.size() == 32);
    CHECK(std::all_of(values.begin(), values.end(), [](float v) { return std::isnan(v); }));
  }
}

TEST_CASE("describe: when killed, the old store is intact and the same command resumes") {
  const Collection c;
  c.sample("s.h5", {"--describe", "a3"});
  c.sample("all.h5", {"--describe", "a3,d2,geodesic", "--geodesic-sources", "0"});
  const std::string before = read_file(c.path("s.h5"));
  const std::vector<std::string> more = {c.in, "--descriptors", "d2,geodesic", "--geodesic-sources", "0"};
  int killed = 0;
  for (int tries = 0; killed < 6 && tries < 60; ++tries) {
    ProcessOptions options;
    options.signal_after = std::chrono::milliseconds(5 + 17 * tries % 90);
    const ProcessResult result =
        meander_with(std::vector<std::string>{"describe", c.path("s.h5")} + more, options);
    if (result.signal == 0) {  // the kill came too late: from the old store again
      REQUIRE(result.exit_code == 0);
      REQUIRE(same_bytes(c.path("s.h5"), c.path("all.h5")));
      write_file(c.path("s.h5"), before);
      continue;
    }
    ++killed;
    // A signal may come between the renaming of the whole new store and the end of the process.
    if (read_file(c.path("s.h5")) == before) continue;
    REQUIRE(same_bytes(c.path("s.h5"), c.path("all.h5")));
    break;
  }
  CHECK(killed > 0);
  const bool unfinished = read_file(c.path("s.h5")) == before;
  if (unfinished) REQUIRE(c.describe("s.h5", more).exit_code == 0);
  // a3 was made without --geodesic-sources, which concern it no more than they would in a run.
  CHECK(same_bytes(c.path("s.h5"), c.path("all.h5")));
  // Killed after the renaming, a process leaves its folder behind.
  if (unfinished) CHECK_FALSE(fs::exists(c.path("s.h5.run")));
}

TEST_CASE("describe: rows that failed before a kill are still listed at the end") {
  const Collection c;
  c.sample("s.h5");
  fs::remove(c.path("in/ring.off"));
  const std::vector<std::string> more = {c.in, "--descriptors", "d2,basics"};
  const auto begun = [&](const StoreHeader& header, std::uint64_t row, Row content) {
    RunDirectory run(c.path("s.h5"), RunPlan{header, RunPurpose::describe});
    run.begin_item(row);
    run.end_item(encode_row(header, row, content));
    run.sync();
  };
  // What a process leaves behind that dies after its second pass has written that row: made by hand.
  REQUIRE(c.describe("s.h5", more + std::vector<std::string>{"-o", c.path("made.h5")}).exit_code == 3);
  {
    const StoreReader made(c.path("made.h5"));
    const StoreHeader header = made.header();
    const std::uint64_t row = *made.find("ring.off");
    begun(header, row, made.read_row(row));
  }
  const ProcessResult result = c.describe("s.h5", more);
  INFO(result.err << result.out);
  CHECK(result.exit_code == 3);
  CHECK(contains(result.out, "4 rows described"));
  CHECK(contains(result.out,
                 "ring.off: incomplete: `basics` could not be made before the job was interrupted"));
  CHECK(same_bytes(c.path("s.h5"), c.path("made.h5")));
}

TEST_CASE("describe: a descriptor that a model lacks is named by run, info and describe") {
  const ScratchFolder scratch;
  fs::create_directories(scratch / "in");
  write_mesh(scratch / "in/ball.off", icosphere(3));
  write_mesh(scratch / "in/plate.off", plate_with_holes(60));  // its spectrum would need too many vertices
  const std::string in = scratch / "in", both = scratch / "both.h5", later = scratch / "later.h5";
  const char* const lacks = "1 model lacks the descriptor `shapedna`";
  const ProcessResult run =
      meander_with({"run", in, "-o", both, "-n", "64", "--describe", "d2,shapedna", "--progress", "none"});
  CHECK(run.exit_code == 0);
  CHECK(contains(run.out, lacks));
  CHECK(contains(meander_with({"info", both}).out, lacks));
  CHECK(contains(meander_with({"info", both, "--json"}).out,
                 "\"items_without_descriptor\":{\"d2\":0,\"shapedna\":1}"));
  REQUIRE(meander_with({"run", in, "-o", later, "-n", "64", "--progress", "none"}).exit_code == 0);
  const ProcessResult described = meander_with({"describe", later, in, "--descriptors", "d2,shapedna"});
  CHECK(described.exit_code == 3);
  CHECK(contains(described.out, "1 rows described"));
  CHECK(contains(described.out, "plate.off: incomplete: `shapedna` could not be made of this model"));
  CHECK(same_bytes(later, both));
}

TEST_CASE("describe: the parameters of every descriptor are recorded") {
  const Collection c;
  c.sample("s.h5", {"--describe", "d2"});
  REQUIRE(c.describe("s.h5", {"--descriptors", "a3,d1", "--bins", "64"}).exit_code == 0);
  const auto parameters = [&] { return StoreReader(c.path("s.h5")).parameters_json(); };
  CHECK(contains(parameters(),
                 "\"describe\":\"d2,a3,d1\",\"descriptor_bins\":{\"a3\":64,\"d1\":64,\"d2\":32}"));
  REQUIRE(c.describe("s.h5", {"--descriptors", "d2", "--bins", "64", "--replace"}).exit_code == 0);
  CHECK(contains(parameters(), "\"describe\":\"d2,a3,d1\",\"descriptor_bins\":64,"));
  CHECK(verify_store(c.path("s.h5")).problems.empty());
  c.sample("run.h5", {"--describe", "d2,a3,d1", "--bins", "64"});
  CHECK(same_bytes(c.path("run.h5"), c.path("s.h5")));
}

TEST_CASE("describe: mistakes are usage errors, and nothing is written") {
  const Collection c;
  c.sample("s.h5", {"--describe", "d2"});
  const std::string before = read_file(c.path("s.h5"));
  const auto error_of = [&](const std::vector<std::string>& more) {
    const ProcessResult result = c.describe("s.h5", more);
    CHECK(result.exit_code == 2);
    CHECK((read_file(c.path("s.h5")) == before));
    return result.err;
  };
  CHECK(contains(error_of({"--descriptors", "a3,geodsic"}), "did you mean `geodesic`?"));
  CHECK(contains(error_of({"--descriptor", "a3"}), "did you mean `--descriptors`?"));
  CHECK(contains(error_of({}), "--descriptors is required: one or more of d2, a3"));
  CHECK(contains(error_of({"--descriptors", "d2,a3"}), "already has the descriptor d2 (--replace"));
  CHECK(contains(error_of({"--descriptors", "geodesic"}), "give the inputs of the run"));
  CHECK(contains(error_of({c.in, "--descriptors", "a3"}), "a3 needs no meshes"));
  CHECK(contains(error_of({"--descriptors", "a3", "--geodesic-sources", "3"}), "geodesic only"));
  CHECK(contains(error_of({"--descriptors", "a3", "--descriptor-scale", "largest"}), "d2 and geodesic only"));
  CHECK(contains(error_of({c.in, "--descriptors", "basics", "--bins", "64"}),
                 "--bins applies to d2, a3, d1, d3, d4 and geodesic only"));
  CHECK(contains(error_of({"--descriptors", "a3", "--bins", "4"}),
                 "--bins takes a whole number from 8 to 1024, not `4`"));
  CHECK(contains(error_of({"--descriptors", "a3", "--memory", "1M"}), "give at least"));
  fs::create_directories(c.path("other"));
  write_mesh(c.path("other/else.off"), icosphere(1));
  CHECK(contains(error_of({c.path("other"), "--descriptors", "basics"}), "no item of"));
  write_file(c.path("there.h5"), "mine");
  for (const bool fresh : {false, true}) {
    std::vector<std::string> more = {"--descriptors", "a3", "-o", c.path("there.h5")};
    if (fresh) more.emplace_back("--fresh");
    CHECK(contains(error_of(more), "is a text file: this command replaces only a Meander store"));
    CHECK(read_file(c.path("there.h5")) == "mine");
  }
  fs::create_directories(c.path("half.h5.run"));
  const ProcessResult half = c.describe("half.h5", {"--descriptors", "a3"});
  CHECK(half.exit_code == 2);
  CHECK(contains(half.err, "is not finished"));
}

TEST_CASE("describe: a store of parametric surfaces has points but no meshes") {
  const ScratchFolder scratch;
  const std::string store = scratch / "t.h5";
  REQUIRE(meander_with({"surface", "torus", "-n", "256", "-o", store}).exit_code == 0);
  const ProcessResult refused =
      meander_with({"describe", store, scratch.path(), "--descriptors", "geodesic"});
  CHECK(refused.exit_code == 2);
  CHECK(contains(refused.err, "parametric surfaces"));
  const ProcessResult result = meander_with({"describe", store, "--descriptors", "d2,d4", "--bins", "16"});
  INFO(result.err);
  CHECK(result.exit_code == 0);
  CHECK(verify_store(store).problems.empty());
  const StoreReader reader(store);
  CHECK(reader.columns() == StoreColumns{.rows = RowKind::surfaces});
  REQUIRE(reader.descriptors().size() == 2);
  CHECK(contains(reader.parameters_json(), "\"describe\":\"d2,d4\""));
}

TEST_CASE("basics: closed forms, and flags instead of NaN") {
  const Collection c;
  c.sample("s.h5", {"--describe", "basics"});
  CHECK(verify_store(c.path("s.h5")).problems.empty());
  const std::string s = c.path("s.h5");
  const std::vector<float> box = values_of(s, "cube.off", "basics"),
                           sheet = values_of(s, "sheet.off", "basics"),
                           two = values_of(s, "two.off", "basics");
  REQUIRE(box.size() == 17);
  CHECK(box[0] == Approx(2));                        // 24 / 12
  CHECK(box[1] == Approx(8 / std::pow(12.0, 1.5)));  // volume
  CHECK(box[16] == 1);
  for (const std::size_t side : {3u, 4u, 5u}) CHECK(box[side] == Approx(1 / std::sqrt(3.0)));
  CHECK(sheet[16] == 0);
  for (const std::size_t solid : {1u, 2u, 9u, 10u, 11u}) CHECK(sheet[solid] == 0);
  CHECK(sheet[0] > 0);
  CHECK(two[16] == 1);
  CHECK(two[1] > 0);

  const auto query = [&](const char* distance) {
    return meander_with(
        {"retrieve", "query", s, "ball.off", "--descriptor", "basics", "--distance", distance});
  };
  for (const char* fits : {"l1", "l2", "cosine"}) CHECK(query(fits).exit_code == 0);
  for (const char* other : {"emd", "chi2"}) {
    const ProcessResult refused = query(other);
    CHECK(refused.exit_code == 2);
    CHECK(contains(refused.err, "use l1, l2 or cosine"));
  }
}

TEST_CASE("basics: retrieve scales every value, whatever its range") {
  // Two values; the second is a thousand times larger and meaningless but for one outlier.
  const ScratchFolder scratch;
  StoreHeader header;
  header.samples = 1;
  header.parameters_json = "{}";
  header.descriptors = {{"basics", 2, {{"columns", "small,large"}}}};
  header.ids = {"a", "b", "c", "d"};
  header.labels = {-1, -1, -1, -1};
  const float values[4][2] = {{0, 1000}, {1, 1001}, {0.1f, 2000}, {1, 2100}};
  {
    RunDirectory run(scratch / "s.h5", header);
    for (std::uint64_t i = 0; i < 4; ++i) {
      Row row = row_of_one_sample();
      row.descriptors = {{"basics", {values[i][0], values[i][1]}}};
      run.end_item(encode_row(header, i, row));
    }
    run.finish();
  }
  // Unscaled, c and d (100 apart) would be nearest; scaled, a and c differ by 2 deviations, c and d by 2 too.
  const ProcessResult result =
      meander_with({"retrieve", "query", scratch / "s.h5", "a", "--distance", "l1", "-k", "3", "--json"});
  INFO(result.out);
  REQUIRE(result.exit_code == 0);
  CHECK(contains(result.out, "\"distance\":2."));  // in deviations, not in thousands
}

TEST_CASE("export of descriptors: CSV and fbin are written") {
  const Collection c;
  c.sample("s.h5", {"--describe", "d2,basics", "--bins", "8", "--label-from-folder"});
  const auto run_export = [&](const std::vector<std::string>& more) {
    return meander_with(std::vector<std::string>{"export", c.path("s.h5")} + more);
  };
  const ProcessResult csv =
      run_export({"--descriptors", "d2+basics", "--format", "csv", "-o", c.path("d.csv")});
  INFO(csv.err);
  REQUIRE(csv.exit_code == 0);
  CHECK(contains(csv.out, "5 rows of 25 values"));
  CHECK(contains(csv.out, "1 rows without these descriptors left out"));
  std::istringstream lines(read_file(c.path("d.csv")));
  std::string line;
  std::getline(lines, line);
  CHECK(line.starts_with("id,label,d2_b0,d2_b1,"));
  CHECK(line.ends_with(",basics_closed"));
  std::getline(lines, line);
  CHECK(line.starts_with("ball.off,in,"));
  std::istringstream cells(line.substr(std::string("ball.off,in,").size()));
  const std::vector<float> expected = values_of(c.path("s.h5"), "ball.off", "d2");
  for (const float value : expected) {
    std::string cell;
    std::getline(cells, cell, ',');
    CHECK(std::stof(cell) == value);
  }

  REQUIRE(
      run_export({"ring.off", "ball.off", "--descriptors", "d2", "--format", "fbin", "-o", c.path("d.fbin")})
          .exit_code == 0);
  const std::string bytes = read_file(c.path("d.fbin"));
  REQUIRE(bytes.size() == 8 + 2 * 8 * 4);
  std::uint32_t header[2];
  std::memcpy(header, bytes.data(), 8);
  CHECK(header[0] == 2);
  CHECK(header[1] == 8);
  std::vector<float> first(8);
  std::memcpy(first.data(), bytes.data() + 8, 32);
  CHECK(first == expected);
  CHECK(read_file(c.path("d.fbin.ids.csv")) == "position,row,id,label\n0,0,ball.off,in\n1,3,ring.off,in\n");
}

TEST_CASE("export of descriptors: neither the store nor anything but a regular file is replaced") {
  const Collection c;
  c.sample("s.h5", {"--describe", "d2"});
  const std::string before = read_file(c.path("s.h5"));
  fs::create_symlink("s.h5", c.path("link.h5"));
  fs::create_directories(c.path("folder"));
  REQUIRE(mkfifo(c.path("pipe").c_str(), 0600) == 0);
  for (const char* format : {"csv", "fbin", "npy", "ann-hdf5"})
    for (const std::string& output : {c.path("s.h5"), c.path("link.h5"), c.path("folder"), c.path("pipe")}) {
      const ProcessResult result =
          meander_with({"export", c.path("s.h5"), "--descriptors", "d2", "--format", format, "-o", output});
      INFO(format << " " << output << ": " << result.err);
      CHECK(result.exit_code == 2);
      CHECK((read_file(c.path("s.h5")) == before));
      CHECK_FALSE(fs::exists(output + ".ids.csv"));
    }
  CHECK(fs::is_fifo(c.path("pipe")));  // a device would be removed in the same way
  const ProcessResult fresh = c.describe("s.h5", {"--descriptors", "a3", "--fresh", "-o", c.path("pipe")});
  CHECK(fresh.exit_code == 2);
  CHECK(contains(fresh.err, "cannot be replaced"));
  CHECK(fs::is_fifo(c.path("pipe")));
  // A link to a file stays a link.
  write_file(c.path("far.csv"), "id,label\nold,1\n");
  fs::create_symlink("far.csv", c.path("near.csv"));
  REQUIRE(meander_with({"export", c.path("s.h5"), "--descriptors", "d2", "--format", "csv", "-o",
                        c.path("near.csv"), "--fresh"})
              .exit_code == 0);
  CHECK(fs::is_symlink(c.path("near.csv")));
  CHECK(contains(read_file(c.path("far.csv")), "ball.off"));
}

TEST_CASE("describe and export: a file size limit is reported, and describe resumes") {
  const Collection c;
  c.sample("s.h5", {"--describe", "d2", "--bins", "1024"});
  const std::string before = read_file(c.path("s.h5"));
  ProcessOptions small;
  small.in_child = [] {
    const rlimit limit{4096, 4096};
    setrlimit(RLIMIT_FSIZE, &limit);
  };
  const std::vector<std::string> describe = {"describe", c.path("s.h5"), "--descriptors", "a3"};
  const ProcessResult stopped = meander_with(describe, small);
  INFO(stopped.err);
  CHECK(stopped.signal == 0);
  CHECK(stopped.exit_code == 75);
  CHECK(contains(stopped.err, "File too large"));
  CHECK((read_file(c.path("s.h5")) == before));
  for (const char* format : {"csv", "fbin", "npy", "ann-hdf5"}) {
    const ProcessResult result = meander_with(
        {"export", c.path("s.h5"), "--descriptors", "d2", "--format", format, "-o", c.path("x")}, small);
    INFO(format << ": " << result.err);
    CHECK(result.exit_code == 2);
    CHECK(contains(result.err, "File too large"));
    CHECK(std::count(result.err.begin(), result.err.end(), '\n') == 1);
  }
  for (const auto& entry : fs::directory_iterator(c.scratch.path()))
    CHECK(entry.path().filename().string()[0] != 'x');  // x, x.ids.csv, x.tmp123
  CHECK(meander_with(describe).exit_code == 0);
}

TEST_CASE("export of descriptors: mistakes are usage errors") {
  const Collection c;
  c.sample("s.h5", {"--describe", "d2"});
  const std::string out = c.path("x");
  const auto error_of = [&](const std::vector<std::string>& more) {
    const ProcessResult result = meander_with(std::vector<std::string>{"export", c.path("s.h5")} + more);
    CHECK(result.exit_code == 2);
    CHECK_FALSE(fs::exists(out));
    return result.err;
  };
  CHECK(contains(error_of({"--format", "cvs", "-o", out}), "did you mean `csv`?"));
  CHECK(contains(error_of({"--format", "csv", "-o", out}), "name them with --descriptors"));
  CHECK(contains(error_of({"--format", "csv", "--descriptors", "d2"}), "-o FILE"));
  CHECK(contains(error_of({"--format", "fbin", "--descriptors", "d", "-o", out}), "did you mean `d2`?"));
  CHECK(contains(error_of({"--descriptors", "d2", "-o", out}), "csv, fbin, npy or ann-hdf5"));
  CHECK(contains(error_of({"--format", "csv", "--descriptors", "d2", "-o", out, "--queries", "1"}),
                 "ann-hdf5 only"));
  CHECK(contains(error_of({"--format", "ann-hdf5", "--descriptors", "d2", "-o", out, "--queries", "5"}),
                 "leave none to search"));
  CHECK(contains(error_of({"--format", "ann-hdf5", "--descriptors", "d2", "-o", out, "--neighbours", "9"}),
                 "there are 4 rows to search"));
}

TEST_CASE("describe: a store of format version 1 becomes one of the current version") {
  const ScratchFolder scratch;
  const fs::path old = fs::path(MEANDER_SOURCE_DIR) / "tests/support/version1_store.h5";
  const std::string store = scratch / "s.h5";
  const ProcessResult result = meander_with(
      {"describe", old.string(), "-o", store, "--descriptors", "a3", "--bins", "8", "--progress", "none"});
  INFO(result.err);
  REQUIRE(result.exit_code == 0);
  CHECK(verify_store(store).problems == std::vector<std::string>{});
  const StoreReader before(old), after(store);
  CHECK(after.format_version() == store_format_version);
  REQUIRE(after.descriptors().size() == 2);
  for (std::uint64_t row = 0; row < before.rows(); ++row) {
    CHECK(after.read_row(row).samples.points == before.read_row(row).samples.points);
    CHECK(after.report(row).status == before.report(row).status);
    CHECK(after.split(row) == Split::none);
  }
}
