// retrieve query: meshes and several items as queries, hints for ids; words of local pairs; foreign vectors;
// what is compared without options.
#include <cstring>
#include <filesystem>
#include <sstream>

#include "support/catch.h"
#include "support/meander_program.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;

namespace {

namespace fs = std::filesystem;
using Arguments = std::vector<std::string>;

struct Models {
  ScratchFolder scratch;
  std::string path(const char* name) const { return scratch / name; }

  Models() {
    fs::create_directories(scratch / "in/ring");
    fs::create_directories(scratch / "in/round");
    write_mesh(scratch / "in/ring/a.off", torus(24, 12));
    write_mesh(scratch / "in/ring/b.off", moved(torus(20, 10, 1, 0.3), 2, 1, 2, 3));
    write_mesh(scratch / "in/round/ball.off", icosphere(3));
    write_mesh(scratch / "in/round/cube.off", cube());
    write_mesh(scratch / "other.off", torus(16, 10, 3, 1.1));
  }
  void sample(const Arguments& more) const {
    Arguments arguments = {"run",        path("in"), "-o",      path("s.h5"),
                           "-n",         "150",      "--fresh", "--label-from-folder",
                           "--progress", "none"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const ProcessResult result = meander_with(arguments);
    INFO(result.err);
    REQUIRE(result.exit_code == 0);
  }
  ProcessResult query(const Arguments& more) const {
    Arguments arguments = {"retrieve", "query", path("s.h5")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return meander_with(arguments);
  }
};

// Cells of a CSV file without its heading.
std::vector<Arguments> rows_of(const std::string& path) {
  std::vector<Arguments> rows;
  std::istringstream lines(read_file(path));
  for (std::string line; std::getline(lines, line);) {
    Arguments& row = rows.emplace_back();
    std::istringstream cells(line);
    for (std::string cell; std::getline(cells, cell, ',');) row.push_back(cell);
  }
  rows.erase(rows.begin());
  return rows;
}

// Every file of the store, asked for as a mesh, has distance 0 from its own row.
void check_all_found(const Models& models, const std::string& descriptor) {
  const ProcessResult result = models.query(
      {"--mesh", models.path("in"), "--descriptor", descriptor, "-k", "1", "--csv", models.path("q.csv")});
  INFO(descriptor << "\n" << result.out << result.err);
  REQUIRE(result.exit_code == 0);
  const std::vector<Arguments> rows = rows_of(models.path("q.csv"));
  REQUIRE(rows.size() == 4);
  for (const Arguments& row : rows) {
    CHECK(row[3] == row[0]);
    CHECK(std::stod(row[5]) == 0);
  }
}

}  // namespace

TEST_CASE("retrieve query --mesh: meshes are sampled and described as the store was") {
  const Models models;
  const char* const all = "pairs+d2+geodesic+basics";
  const std::vector<Arguments> runs = {
      {"--seed", "7", "--sequence", "spaced", "--spacing", "best"},
      {"--method", "direct", "--curve", "balanced", "--density", "mean", "--density-floor", "0.1"},
      {"--method", "conformal", "--curved", "--order", "curve", "--normalize", "unit-box"},
      {"--method", "conformal", "--locate", "first-hit"},
      {"--method", "anisotropic", "--tensor", "constant:1,0,0,1,0,2", "--tensor-form", "metric"}};
  for (Arguments run : runs) {
    INFO(run[1]);
    run.insert(run.end(), {"--describe", "pairs,d2,geodesic,basics", "--bins", "16", "--descriptor-scale",
                           "largest", "--geodesic-sources", "20"});
    models.sample(run);
    check_all_found(models, all);
  }
  // Descriptors of different bins.
  models.sample({"--describe", "d2", "--bins", "16"});
  REQUIRE(
      meander_with({"describe", models.path("s.h5"), "--descriptors", "d1,a3", "--bins", "40"}).exit_code ==
      0);
  check_all_found(models, "d2+d1+a3");
}

TEST_CASE("retrieve query: a mesh outside the store, next to items, as a table and as JSON") {
  const Models models;
  models.sample({"--describe", "pairs,d2"});
  const ProcessResult one = models.query({"--mesh", models.path("other.off"), "-k", "2"});
  INFO(one.err);
  REQUIRE(one.exit_code == 0);
  CHECK(contains(one.out, "ring/a.off"));
  CHECK(contains(one.out, "ring/b.off"));
  CHECK_FALSE(contains(one.out, "query"));  // the column
  const ProcessResult both = models.query({"round/ball.off", "1", "--mesh", models.path("other.off"), "-k",
                                           "1", "--csv", models.path("q.csv"), "--json"});
  INFO(both.err);
  REQUIRE(both.exit_code == 0);
  const std::vector<Arguments> rows = rows_of(models.path("q.csv"));
  REQUIRE(rows.size() == 3);
  CHECK(rows[0][0] == "round/ball.off");
  CHECK(rows[1][0] == "ring/b.off");
  CHECK(rows[1][3] == "ring/a.off");
  CHECK(rows[2][0] == "other.off");
  CHECK(contains(both.out, R"("queries":[{"query":"round/ball.off","status":"ok","reason":"","results":[)"));
  for (const char* const rank : {"scaled", "diffusion"}) {  // a mesh joins the ranking for its query
    const ProcessResult ranked =
        models.query({"--mesh", models.path("other.off"), "-k", "2", "--rank", rank, "--json"});
    INFO(ranked.err);
    REQUIRE(ranked.exit_code == 0);
    CHECK(contains(ranked.out, R"("rank":"scaled")"));  // four rows have no graph
    CHECK(contains(ranked.out, R"("ring/a.off")"));
    CHECK(contains(ranked.out, R"("ring/b.off")"));
  }
}

TEST_CASE("retrieve query: invalid queries, and meshes that cannot be described, are refused") {
  const Models models;
  models.sample({"--describe", "pairs"});
  const ProcessResult nothing = models.query({});
  CHECK(nothing.exit_code == 2);
  CHECK(contains(nothing.err, "a query is missing: name items of the store, or meshes with --mesh"));
  const ProcessResult name = models.query({"cube.off"});
  CHECK(name.exit_code == 2);
  CHECK(contains(name.err, "did you mean `round/cube.off`?"));
  CHECK(contains(models.query({"rong/a.off"}).err, "did you mean `ring/a.off`?"));

  write_file(models.path("broken.off"), "OFF\n3 1 0\n0 0\n");
  const ProcessResult broken =
      models.query({"--mesh", models.path("broken.off"), models.path("other.off"), "-k", "1", "--json"});
  CHECK(broken.exit_code == 3);
  CHECK(contains(broken.err, "broken.off: unreadable: "));
  CHECK(contains(broken.out, R"("query":"broken.off","status":"unreadable")"));
  CHECK(contains(broken.out, R"("query":"other.off","status":"ok")"));

  REQUIRE(meander_with({"surface", "torus", "-n", "100", "-o", models.path("t.h5")}).exit_code == 0);
  REQUIRE(meander_with({"describe", models.path("t.h5"), "--descriptors", "d2"}).exit_code == 0);
  const ProcessResult surface =
      meander_with({"retrieve", "query", models.path("t.h5"), "--mesh", models.path("other.off")});
  CHECK(surface.exit_code == 2);
  CHECK(contains(surface.err, "is a store of parametric surfaces: no mesh is sampled as they were"));
}

namespace {

ProcessResult with_store(const Models& models, const Arguments& before, const Arguments& after = {}) {
  Arguments arguments = {"retrieve"};
  arguments.insert(arguments.end(), before.begin(), before.end());
  arguments.push_back(models.path("s.h5"));
  arguments.insert(arguments.end(), after.begin(), after.end());
  return meander_with(arguments);
}

// An array of numpy, rows x width.
template <class Number>
std::string npy_file(const char* type, const std::vector<std::vector<Number>>& rows) {
  std::string header = "{'descr': '" + std::string(type) + "', 'fortran_order': False, 'shape': (" +
                       std::to_string(rows.size()) + ", " + std::to_string(rows.front().size()) + "), }";
  header.resize(117, ' ');
  header += '\n';
  std::string bytes = std::string("\x93NUMPY\x01\x00", 8) + std::string("\x76\x00", 2) + header;
  for (const std::vector<Number>& row : rows)
    bytes.append(reinterpret_cast<const char*>(row.data()), row.size() * sizeof(Number));
  return bytes;
}

}  // namespace

TEST_CASE("retrieve words: codes of local pairs are a descriptor of the store and of meshes") {
  const Models models;
  models.sample({"--describe", "pairs"});
  const ProcessResult none = models.query({"0", "--descriptor", "pairs+local-pairs"});
  CHECK(none.exit_code == 2);
  CHECK(contains(none.err, "s.h5.words`: `meander retrieve words "));
  const ProcessResult made = with_store(models, {"words"});
  INFO(made.err);
  REQUIRE(made.exit_code == 0);
  CHECK(contains(made.out, "learned 1 words from 4 models"));
  const std::string bytes = read_file(models.path("s.h5.words"));
  check_all_found(models, "local-pairs");
  check_all_found(models, "pairs+local-pairs");
  // The same shape elsewhere, of another size: other samples, and the nearest all the same.
  write_mesh(models.path("again.off"), moved(torus(24, 12), 3, 4, 5, 6));
  const ProcessResult again =
      models.query({"--mesh", models.path("again.off"), "-k", "1", "--descriptor", "local-pairs"});
  CHECK(contains(again.out, "ring/a.off"));
  CHECK(contains(with_store(models, {"evaluate"}, {"--descriptor", "local-pairs", "--distance", "emd"}).err,
                 "not bins along one line"));
  // Again and with other threads: the same bytes.
  REQUIRE(with_store(models, {"words"}, {"--replace"}).exit_code == 0);
  CHECK(read_file(models.path("s.h5.words")) == bytes);

  // A store that grows keeps its words; models without a code are named.
  write_mesh(models.path("in/round/more.off"), icosphere(2));
  models.sample({"--describe", "pairs"});
  const ProcessResult lacks = models.query({"0", "--descriptor", "local-pairs"});
  CHECK(lacks.exit_code == 2);
  CHECK(contains(lacks.err, "s.h5.words` lacks 1 models of the store: `meander retrieve words` adds them"));
  const ProcessResult grown = with_store(models, {"words"}, {"--json"});
  REQUIRE(grown.exit_code == 0);
  CHECK(contains(grown.out, R"("learned_from":4,"words_of_this_store":false,"models":5,"coded":1)"));
  CHECK(models.query({"0", "--descriptor", "local-pairs"}).exit_code == 0);

  // Damaged and foreign files are refused by name, and never replaced unless they are words.
  const std::string whole = read_file(models.path("s.h5.words"));
  for (const std::size_t at : {std::size_t{3}, whole.size() / 2, whole.size() - 1}) {
    std::string damaged = whole;
    damaged[at] = static_cast<char>(damaged[at] ^ 4);
    write_file(models.path("s.h5.words"), damaged);
    const ProcessResult refused = models.query({"0", "--descriptor", "local-pairs"});
    CHECK(refused.exit_code == 2);
    CHECK(contains(refused.err, "s.h5.words` is not a file of words"));
  }
  write_file(models.path("s.h5.words"), "my own words\n");
  CHECK(with_store(models, {"words"}, {"--replace"}).exit_code == 2);
}

TEST_CASE("retrieve --vectors: vectors of another program are searched, evaluated and combined") {
  const Models models;
  models.sample({"--describe", "pairs"});
  const std::vector<std::vector<float>> vectors = {{0, 0}, {5, 0}, {0.5f, 0}, {9, 9}};  // of the ids below
  write_file(models.path("net.npy"), npy_file("<f4", vectors));
  write_file(models.path("ids.txt"), "round/cube.off\nring/b.off\nring/a.off\nround/ball.off\n");
  const Arguments given = {"--vectors", models.path("net.npy"), "--ids", models.path("ids.txt")};
  const auto query = [&](Arguments more) {
    more.insert(more.end(), given.begin(), given.end());
    return models.query(more);
  };
  const ProcessResult found = query({"round/cube.off", "-k", "2", "--csv", models.path("q.csv")});
  INFO(found.err);
  REQUIRE(found.exit_code == 0);
  CHECK(contains(found.out, "descriptor net, distance l1, rank plain"));
  const std::vector<Arguments> rows = rows_of(models.path("q.csv"));
  CHECK(rows[0][2] == "ring/a.off");
  CHECK(std::stod(rows[0][4]) == 0.5);
  CHECK(rows[1][2] == "ring/b.off");
  CHECK(query({"0", "--descriptor", "pairs+net=2", "--rank", "scaled"}).exit_code == 0);
  const ProcessResult scores =
      with_store(models, {"evaluate"}, {given[0], given[1], given[2], given[3], "--distance", "l2"});
  CHECK(contains(scores.out, "4 models, 4 queries of 2 classes; descriptor net, distance l2"));
  CHECK(contains(query({"--mesh", models.path("other.off")}).err, "net.npy` has no vectors of other meshes"));
  // In a CSV table, as float64, and without ids in the order of the store.
  write_file(models.path("ids.csv"),
             "position,id\n0,round/cube.off\n1,ring/b.off\n2,ring/a.off\n3,round/ball.off\n");
  write_file(models.path("wide.npy"), npy_file<double>("<f8", {{0, 0}, {5, 0}, {0.5, 0}, {9, 9}}));
  CHECK(contains(models
                     .query({"round/cube.off", "-k", "1", "--vectors", models.path("wide.npy"), "--ids",
                             models.path("ids.csv")})
                     .out,
                 "ring/a.off"));
  CHECK(contains(models.query({"0", "-k", "1", "--vectors", models.path("net.npy")}).out, "round/ball.off"));

  const auto refused = [&](const Arguments& more, const char* why) {
    Arguments arguments = {"0"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const ProcessResult result = models.query(arguments);
    INFO(result.err);
    CHECK(result.exit_code == 2);
    CHECK(contains(result.err, why));
  };
  refused({"--ids", models.path("ids.txt")}, "give both, or neither");
  write_file(models.path("unknown.txt"), "round/cube.off\nring/b.off\nring/c.off\nround/ball.off\n");
  refused({"--vectors", models.path("net.npy"), "--ids", models.path("unknown.txt")},
          "the store has no model `ring/c.off`");
  write_file(models.path("twice.txt"), "round/cube.off\nring/b.off\nring/b.off\nround/ball.off\n");
  refused({"--vectors", models.path("net.npy"), "--ids", models.path("twice.txt")}, "`ring/b.off` twice");
  write_file(models.path("few.npy"), npy_file<float>("<f4", {{1, 2}, {3, 4}}));
  refused({"--vectors", models.path("few.npy")}, "has 2 rows and the store 4");
  refused({"--vectors", models.path("few.npy"), "--ids", models.path("ids.txt")}, "4 ids and");
  write_file(models.path("pairs.npy"), npy_file("<f4", vectors));
  refused({"--vectors", models.path("pairs.npy")}, "the store has a descriptor `pairs`");
  write_file(models.path("cut.npy"), npy_file("<f4", vectors).substr(0, 150));
  refused({"--vectors", models.path("cut.npy")}, "which is not what follows");
  write_file(models.path("text.npy"), "0 0\n");
  refused({"--vectors", models.path("text.npy")}, "is no array of numpy");
  refused({"--vectors", models.path("missing.npy")}, "missing.npy");
}

TEST_CASE("retrieve: without options, the descriptors that find most of what the store has are compared") {
  const Models models;
  models.sample({"--describe", "d2,views,pairs"});
  CHECK(contains(models.query({"0"}).out, "descriptor pairs+views, distance l1, rank scaled\n"));
  REQUIRE(with_store(models, {"words"}).exit_code == 0);
  const char* const best = "descriptor pairs+views+local-pairs, distance l1, rank scaled\n";
  CHECK(contains(models.query({"0"}).out, best));
  CHECK(contains(with_store(models, {"evaluate"}).out, best));
  CHECK(contains(models.query({"0", "--rank", "plain"}).out,
                 "descriptor pairs+views+local-pairs, distance l1, rank plain\n"));
  CHECK(contains(models.query({"0", "--descriptor", "pairs"}).out,
                 "descriptor pairs, distance l1, rank plain\n"));
  const ProcessResult mesh = models.query({"--mesh", models.path("other.off"), "-k", "2"});
  CHECK(mesh.exit_code == 0);
  CHECK(contains(mesh.out, "ring/a.off"));
  models.sample({"--describe", "d2"});
  fs::remove(models.path("s.h5.words"));
  CHECK(contains(models.query({"0"}).out, "descriptor d2, distance l1, rank plain\n"));
}
