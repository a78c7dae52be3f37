// retrieve query: meshes and several items as queries, hints for ids.
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
