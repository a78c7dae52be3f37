#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "support/catch.h"
#include "support/chromium.h"
#include "support/meander_program.h"
#include "support/mesh_files.h"
#include "support/run_process.h"
#include "support/sanitized.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;

namespace {

using CsvRow = std::map<std::string, std::string>;

// The rows of a CSV file without quotes, by the names of its columns.
std::vector<CsvRow> csv_rows(const std::filesystem::path& path) {
  std::istringstream text(read_file(path));
  const auto fields_of = [](const std::string& line) {
    std::vector<std::string> fields;
    std::istringstream rest(line + ",");
    for (std::string field; std::getline(rest, field, ',');) fields.push_back(field);
    return fields;
  };
  std::vector<CsvRow> rows;
  std::vector<std::string> names;
  for (std::string line; std::getline(text, line);) {
    const std::vector<std::string> fields = fields_of(line);
    if (names.empty()) {
      names = fields;
      continue;
    }
    REQUIRE(fields.size() <= names.size());
    rows.emplace_back();
    for (std::size_t k = 0; k < fields.size(); ++k) rows.back()[names[k]] = fields[k];
  }
  return rows;
}

// Figures are drawn by the Python package, whose library sanitized builds do without.
#define MEANDER_NEEDS_FIGURES()                                   \
  if (sanitized) {                                                \
    WARN("skipped: a sanitized build has no library for Python"); \
    return;                                                       \
  }

// The quick figures of these numbers or names, and of a ball.
void draw(const ScratchFolder& scratch, const char* only) {
  write_mesh(scratch / "ball.off", icosphere(3));
  const ProcessResult result = run_process({program, "figures", "-o", scratch / "out", "--quick", "--only",
                                            only, "--models", scratch / "ball.off"});
  INFO(result.err);
  REQUIRE(result.exit_code == 0);
}

}  // namespace

TEST_CASE("figures: selected quick figures are drawn with their data and shown on the page") {
  MEANDER_NEEDS_FIGURES();
  const ScratchFolder scratch;
  draw(scratch, "1,2,3,6,8,21,point-sets");
  const std::string page = read_file(scratch / "out/index.html");
  for (const char* name : {"figure01_shapes.svg", "point_sets.svg", "figure02_stretched_plane.svg",
                           "figure03_curves.svg", "figure06_eight.png", "figure08_ball.png",
                           "figure21_mesh_distance.svg", "figure21_mesh_distance.csv"}) {
    INFO(name);
    CHECK(page.find(name) != std::string::npos);
    CHECK(read_file(scratch / (std::string("out/") + name)).size() > 100);
  }

  // Entries of the list of contents stand apart, each as a whole in one column.
  MEANDER_NEEDS_CHROMIUM();
  write_file(scratch / "out/index.html", page + R"(<script>
    const boxes = [...document.querySelectorAll('nav li')].map((entry) => [...entry.getClientRects()]);
    const apart = (a, b) => a.right <= b.left || b.right <= a.left || a.bottom <= b.top || b.bottom <= a.top;
    const inside = (a, b) => a.left >= b.left && a.right <= b.right && a.top >= b.top - 4 && a.bottom <= b.bottom + 4;
    let wrong = boxes.filter((parts) => parts.length !== 1).length;
    boxes.forEach((a, i) => boxes.slice(0, i).forEach((b) => wrong += !apart(a[0], b[0])));
    document.querySelectorAll('nav a').forEach((link, i) => {
      for (const line of link.getClientRects()) wrong += !inside(line, boxes[i][0]);
    });
    document.title = `${boxes.length} entries, ${wrong} wrong`;
  </script>)");
  for (const char* size : {"1280,900", "700,900", "400,900"})
    CHECK(contains(open_page("file://" + (scratch / "out/index.html").string(), "--dump-dom", size,
                             (scratch / "profile").string())
                       .out,
                   "<title>7 entries, 0 wrong</title>"));
}

TEST_CASE("figures: meshes of samples are shown next to simplified ones with as many vertices") {
  MEANDER_NEEDS_FIGURES();
  const ScratchFolder scratch;
  write_mesh(scratch / "ring.off", torus(64, 32));
  const ProcessResult result = run_process({program, "figures", "-o", scratch / "out", "--quick", "--only",
                                            "metro", "--models", scratch / "ring.off"});
  INFO(result.err);
  REQUIRE(result.exit_code == 0);
  const auto rows = csv_rows(scratch / "out/metro_ring.csv");
  REQUIRE(rows.size() == 20);
  for (std::size_t i = 0; i < rows.size(); i += 4) {
    INFO(rows[i].at("size"));
    const auto value = [&](std::size_t k, const char* name) { return std::stod(rows[i + k].at(name)); };
    CHECK(value(3, "vertices") == value(0, "vertices"));
    CHECK(value(0, "mean") < 4 * value(3, "mean"));
    CHECK(value(1, "mean") < 1.6 * value(3, "mean"));
    CHECK(value(0, "median angle") > 34);
  }
}

TEST_CASE(
    "figures: splats, views and remeshed models are drawn, and ellipses leave less white than discs of the "
    "same area") {
  MEANDER_NEEDS_FIGURES();
  const ScratchFolder scratch;
  write_mesh(scratch / "ring.off", torus(48, 24));
  const ProcessResult result = run_process({program, "figures", "-o", scratch / "out", "--quick", "--only",
                                            "7,9,10,11,17", "--models", scratch / "ring.off"});
  INFO(result.err);
  REQUIRE(result.exit_code == 0);
  for (const char* name : {"figure07_ring.png", "figure09_ring.png", "figure10_ring.png", "figure11_ring.png",
                           "figure11_sphere.png", "figure17_ring.png"}) {
    INFO(name);
    CHECK(read_file(scratch / (std::string("out/") + name)).size() > 10000);
  }
  const auto white = csv_rows(scratch / "out/figure17_white_space.csv");
  REQUIRE(white.size() == 2);
  for (const CsvRow& row : white) {
    INFO(row.at("order"));
    CHECK(std::stod(row.at("anisotropic %")) > 0);
    CHECK(std::stod(row.at("anisotropic %")) < std::stod(row.at("isotropic %")));
    CHECK(std::stod(row.at("anisotropic %")) < std::stod(row.at("discs at anisotropic samples %")));
  }
  const auto turning = csv_rows(scratch / "out/figure11_turning.csv");
  REQUIRE(turning.size() == 2);
  for (const CsvRow& row : turning) CHECK(std::stod(row.at("stay %")) >= 90);
  // Fitted remeshes are nearer to the model than plain ones of as many vertices.
  const auto remeshed = csv_rows(scratch / "out/figure10_distances.csv");
  REQUIRE(remeshed.size() == 4);
  for (std::size_t i = 0; i < 4; i += 2)
    CHECK(std::stod(remeshed[i + 1].at("mean %")) < 0.6 * std::stod(remeshed[i].at("mean %")));
}

TEST_CASE("figures: the same seed gives the same files, for one thread and two") {
  MEANDER_NEEDS_FIGURES();
  const ScratchFolder scratch;
  const std::string only = sanitized ? "5" : "5,21";
  for (const char* threads : {"1", "2"}) {
    if (sanitized && *threads == '1') continue;  // release builds compare
    REQUIRE(
        run_process({program, "figures", "-o", scratch / threads, "--quick", "--only", only, "-j", threads})
            .exit_code == 0);
  }
  if (sanitized) return;
  for (const auto& entry : std::filesystem::directory_iterator(scratch / "1")) {
    const std::string name = entry.path().filename().string();
    INFO(name);
    CHECK(read_file(scratch / ("1/" + name)) == read_file(scratch / ("2/" + name)));
  }
}

TEST_CASE(
    "figures: a mesh that cannot be sampled is named on the page, the others are drawn, far from the origin "
    "too") {
  MEANDER_NEEDS_FIGURES();
  const ScratchFolder scratch;
  write_file(scratch / "line.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n2 0 0\n3 0 1 2\n");
  write_mesh(scratch / "far.off", moved(icosphere(3), 1, 1e4, 0, 0));
  const ProcessResult result = run_process({program, "figures", "-o", scratch / "out", "--quick", "--only",
                                            "4-mesh", "--models", scratch / "line.off", scratch / "far.off"});
  INFO(result.err);
  REQUIRE(result.exit_code == 0);
  const std::string page = read_file(scratch / "out/index.html");
  CHECK(page.find("Not drawn") != std::string::npos);
  CHECK(page.find("zero_area") != std::string::npos);
  // The slope of samples along the curve.
  const std::string slopes = read_file(scratch / "out/figure04_mesh_far_boxes_slopes.csv");
  const std::size_t at = slopes.find("conformal,");
  REQUIRE(at != std::string::npos);
  CHECK(std::stod(slopes.substr(at + 10)) < -0.6);
}

TEST_CASE("figures: an unknown figure and a quadrilateral mesh are usage errors") {
  MEANDER_NEEDS_FIGURES();
  const ScratchFolder scratch;
  const ProcessResult unknown = run_process({program, "figures", "-o", scratch / "out", "--only", "4-plain"});
  CHECK(unknown.exit_code == 2);
  CHECK(unknown.err.find("4-plane") != std::string::npos);
  write_file(scratch / "quad.off", "OFF\n4 1 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n");
  const ProcessResult quads =
      run_process({program, "figures", "-o", scratch / "out", "--models", scratch / "quad.off"});
  CHECK(quads.exit_code == 2);
  CHECK(quads.err.find("not triangles") != std::string::npos);
}

TEST_CASE("figures: distance histograms are drawn, tabulated and compared, the same for one thread and two") {
  MEANDER_NEEDS_FIGURES();
  const ScratchFolder scratch;
  write_mesh(scratch / "ball.off", icosphere(2));
  for (const char* threads : {"1", "2"}) {
    if (sanitized && *threads == '2') continue;  // release builds compare
    const ProcessResult result =
        run_process({program, "figures", "-o", scratch / threads, "--quick", "--only", "22,26,table-1", "-j",
                     threads, "--models", scratch / "ball.off"});
    INFO(result.err);
    REQUIRE(result.exit_code == 0);
  }
  std::size_t files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(scratch / "1")) {
    const std::string name = entry.path().filename().string();
    INFO(name);
    if (!sanitized) CHECK(read_file(scratch / ("1/" + name)) == read_file(scratch / ("2/" + name)));
    ++files;
  }
  CHECK(files > 15);
  const std::string page = read_file(scratch / "1/index.html");
  for (const char* name : {"figure22_ball.svg", "figure22_ball_truths.svg", "figure22_ball_errors.csv",
                           "figure26_ball.svg", "table1_histograms.csv", "table1_cells.csv"}) {
    INFO(name);
    CHECK(page.find(name) != std::string::npos);
  }
  // 2 numbers of points x 3 ground truths x 3 kinds of charts; no row of the survey for a model that it does
  // not have.
  const std::vector<CsvRow> errors = csv_rows(scratch / "1/table1_histograms.csv");
  CHECK(errors.size() == 18);
  for (const CsvRow& row : errors) {
    INFO(row.at("ground truth") << ", " << row.at("points") << ", " << row.at("charts"));
    const double relative = std::stod(row.at("relative %"));
    CHECK(relative > 0);
    // At 100 points five runs do not decide.
    if (row.at("points") == "500") CHECK(relative < std::stod(row.at("random relative %")));
    // The largest of the errors, which sum to 0, is at most half of their absolute sum; the root of the sum
    // of their squares is at most that sum.
    CHECK(std::stod(row.at("largest")) <= relative / 200 * (1 + 1e-5));
    CHECK(std::stod(row.at("root of squares %")) <= relative * (1 + 1e-5));
  }
  // Three errors of every row: smaller error and deviation, and equals conformal of two charts.
  std::map<std::string, std::size_t> claims;
  for (const CsvRow& row : csv_rows(scratch / "1/table1_claims.csv")) {
    ++claims[row.at("claim")];
    if (row.at("claim") != "equals conformal") continue;
    INFO(row.at("ground truth") << ", " << row.at("points") << ", " << row.at("charts"));
    CHECK(row.at("charts").starts_with("isotropic tensor"));
    const double gap = std::stod(row.at("gap"));
    CHECK((std::abs(gap) <= 2) == (row.at("holds") == "yes"));
    CHECK((gap < 0) == (std::stod(row.at("low discrepancy")) < std::stod(row.at("other"))));
    CHECK(std::abs(gap) < 6);  // five runs each: errors of errors are large
  }
  CHECK(claims == std::map<std::string, std::size_t>{
                      {"smaller error", 54}, {"smaller deviation over runs", 54}, {"equals conformal", 36}});
  CHECK(csv_rows(scratch / "1/table1_cells.csv").size() == 18);
  // In the metric the tensor needs no more segments than components; along its directions many.
  const std::vector<CsvRow> charts = csv_rows(scratch / "1/table1_charts.csv");
  REQUIRE(charts.size() == 2);
  CHECK(charts[0].at("segments") == "1");
  CHECK(std::stod(charts[0].at("accepted share")) == 1);
  CHECK(std::stod(charts[1].at("segments")) > 1);
  // The curves are in the plots and their data.
  const std::string curves = read_file(scratch / "1/figure22_ball_errors.csv");
  for (const char* const method : {"low discrepancy", "random", "stratified", "isotropic tensor",
                                   "isotropic tensor by gradient", "spaced"})
    for (const char* const points : {"100", "2000"}) {
      INFO(method << ", " << points);
      CHECK(curves.find(fmt::format("curved surface,{},{},5,", method, points)) != std::string::npos);
    }
  const std::string plot = read_file(scratch / "1/figure22_ball_truths.svg");
  for (const char* curve : {">isotropic tensor<", ">spaced<", ">isotropic tensor by gradient<"}) {
    INFO(curve);
    CHECK(plot.find(curve) != std::string::npos);
  }
}

TEST_CASE("figures: spaced sample sets are drawn") {
  MEANDER_NEEDS_FIGURES();
  const ScratchFolder scratch;
  draw(scratch, "spaced-sets");
  CHECK(read_file(scratch / "out/index.html").find("spaced_sets_ball.png") != std::string::npos);
  const std::string picture = read_file(scratch / "out/spaced_sets_ball.png");
  CHECK(picture.substr(1, 3) == "PNG");
  CHECK(picture.size() > 10000);
}

// Measures of many sets: a minute and a half with sanitizers.
TEST_CASE("figures: spaced samples are judged by every measure, the same for one thread and two",
          "[statistics]") {
  MEANDER_NEEDS_FIGURES();
  const ScratchFolder scratch;
  write_mesh(scratch / "ball.off", icosphere(3));
  for (const char* threads : {"1", "2"}) {
    const ProcessResult result =
        run_process({program, "figures", "-o", scratch / threads, "--quick", "--only", "spaced,spaced-sets",
                     "-j", threads, "--models", scratch / "ball.off"});
    INFO(result.err);
    REQUIRE(result.exit_code == 0);
  }
  for (const auto& entry : std::filesystem::directory_iterator(scratch / "1")) {
    const std::string name = entry.path().filename().string();
    INFO(name);
    if (name.find("_time.") != std::string::npos) continue;
    CHECK(read_file(scratch / ("1/" + name)) == read_file(scratch / ("2/" + name)));
  }
  const std::string page = read_file(scratch / "1/index.html");
  for (const char* name :
       {"spaced_unit-square.svg", "spaced_unit-sphere.svg", "spaced_ball.svg", "spaced_ball_sets.csv",
        "spaced_ball_differences.png", "spaced_ball_differences_radial.svg", "spaced_ball_time.svg",
        "spaced_spectrum.svg", "spaced_spectrum_maps.png", "spaced_bias.csv", "spaced_sets_ball.png"}) {
    INFO(name);
    CHECK(page.find(name) != std::string::npos);
    CHECK(read_file(scratch / (std::string("1/") + name)).size() > 100);
  }
  for (const char* const surface : {"unit-square", "unit-sphere", "ball"}) {
    std::map<std::string, CsvRow> of;
    for (const CsvRow& row : csv_rows(scratch / fmt::format("1/spaced_{}_sets.csv", surface)))
      if (row.at("points") == "1024") of[row.at("samples")] = row;
    INFO(surface);
    REQUIRE(of.size() == 8);
    const auto value = [&](const char* samples, const char* column) {
      return std::stod(of.at(samples).at(column));
    };
    CHECK(value("random", "rho") < 0.1);
    CHECK(value("sample elimination", "rho") > 0.62);
    CHECK(value("spaced", "rho") > 0.62);
    CHECK(value("spaced best", "rho") > value("spaced", "rho"));
    CHECK(value("spaced", "rho") > value("spaced fast", "rho"));
    CHECK(value("spaced", "error") < value("stratified", "error"));
    // On the square the shifted samples are a digital net, which has about the error of spaced ones.
    if (std::string(surface) == "unit-sphere") CHECK(value("spaced", "error") < value("shifted", "error"));
    CHECK(value("shifted", "error") < value("sample elimination", "error"));
    CHECK(value("sample elimination", "error") < 0.7 * value("random", "error"));
    CHECK(value("shifted", "mean distance / hexagonal") < value("spaced", "mean distance / hexagonal"));
  }
  // Sample elimination crowds at borders, spaced samples do not.
  for (const CsvRow& row : csv_rows(scratch / "1/spaced_bias.csv")) {
    INFO(row.at("samples"));
    const double border = std::stod(row.at("density at the border of the square"));
    CHECK((row.at("samples") == "sample elimination" ? border > 1.5 : border == Approx(1).margin(0.45)));
  }
}

TEST_CASE(
    "figures: sequences and the user's point sets stand against the limit, the same for one thread and two",
    "[statistics]") {
  MEANDER_NEEDS_FIGURES();
  const ScratchFolder scratch;
  const std::string ball = scratch / "ball.off", store = scratch / "s.h5", csv = scratch / "b.csv";
  write_mesh(ball, icosphere(3));
  std::vector<std::string> sets;  // two of 1,000 points, and one of 4,000
  for (const char* n : {"1000", "1000", "4000"}) {
    const std::string seed = std::to_string(sets.size() + 1), folder = scratch / ("set" + seed);
    REQUIRE(run_process({program, "run", ball, "-o", store, "-n", n, "--seed", seed, "--sequence", "random",
                         "--fresh"})
                .exit_code == 0);
    REQUIRE(run_process({program, "export", store, "-o", folder, "--format", "xyz"}).exit_code == 0);
    sets.push_back(folder + "/ball.off.xyz");
  }
  for (const char* threads : {"1", "2"}) {
    const ProcessResult result = run_process({program, "figures", "-o", scratch / threads, "--quick",
                                              "--only", "limit", "-j", threads, "--models", ball, "--points",
                                              "theirs=" + sets[0], "theirs=" + sets[1], "theirs=" + sets[2]});
    INFO(result.err);
    REQUIRE(result.exit_code == 0);
  }
  for (const char* name : {"limit_ball.csv", "limit_ball.svg", "limit_ball.png", "index.html"}) {
    INFO(name);
    CHECK(read_file(scratch / (std::string("1/") + name)) == read_file(scratch / (std::string("2/") + name)));
  }
  std::map<std::string, std::map<std::string, CsvRow>> rows;  // by samples and points
  for (const CsvRow& row : csv_rows(scratch / "1/limit_ball.csv"))
    rows[row.at("samples")][row.at("points")] = row;
  CHECK(rows.size() == 9);
  const auto value = [&](const char* samples, const char* points, const char* column) {
    return std::stod(rows.at(samples).at(points).at(column));
  };
  CHECK(value("spaced", "256", "limit") == Approx(2 * value("spaced", "4096", "limit")));
  for (const auto& [samples, of] : rows)
    for (const auto& [points, row] : of) {
      INFO(samples << ", " << points);
      const double over = std::stod(row.at("over_limit"));
      CHECK(over == Approx(std::stod(row.at("error")) / std::stod(row.at("limit"))).epsilon(1e-4));
      CHECK(over > 1);
      if (samples != "random" && samples != "theirs" && samples != "sample elimination") CHECK(over < 1.9);
    }
  CHECK(value("random", "4096", "over_limit") > 5);
  CHECK(value("sample elimination", "4096", "over_limit") >
        1.3 * value("sample elimination", "256", "over_limit"));
  CHECK(value("spaced best", "1024", "over_limit") < value("stratified", "1024", "over_limit"));
  // The user's sets as `measure boxes` has them.
  REQUIRE(run_process({program, "measure", "boxes", sets[0], sets[1], sets[2], "--surface", ball, "--shapes",
                       "200", "--csv", csv})
              .exit_code == 0);
  const std::vector<CsvRow> measured = csv_rows(csv);
  REQUIRE(measured.size() == 3);
  const auto error = [&](std::size_t set) { return std::stod(measured[set].at("error / random")); };
  CHECK(value("theirs", "1000", "error") ==
        Approx(std::hypot(error(0), error(1)) / std::sqrt(2.0)).epsilon(1e-5));
  CHECK(value("theirs", "4000", "error") == Approx(error(2)).epsilon(1e-5));
  CHECK(value("theirs", "1000", "sets") == 2);

  for (const std::vector<std::string>& words :
       {std::vector<std::string>{"--only", "limit", "--points", "theirs=" + sets[0]},  // of which model?
        {"--only", "5", "--models", ball, "--points", "theirs=" + sets[0]},
        {"--only", "limit", "--models", ball, "--points", "theirs=" + sets[0], "theirs=/absent.xyz"},
        {"--only", "limit", "--models", ball, "--points", sets[0]}}) {
    std::vector<std::string> command = {program, "figures", "-o", scratch / "none", "--quick"};
    command.insert(command.end(), words.begin(), words.end());
    const ProcessResult refused = run_process(command);
    INFO(refused.err);
    CHECK(refused.exit_code == 2);
    CHECK(contains(refused.err, "--points"));
  }
}

TEST_CASE("figures: sampling by lifted areas removes the tessellation error", "[statistics]") {
  MEANDER_NEEDS_FIGURES();
  const ScratchFolder scratch;
  const ProcessResult result =
      run_process({program, "figures", "-o", scratch / "out", "--quick", "--only", "histogram-floors"});
  INFO(result.err);
  REQUIRE(result.exit_code == 0);
  const std::vector<CsvRow> floors = csv_rows(scratch / "out/histogram_floors_shapes.csv");
  REQUIRE(floors.size() == 4);
  for (const CsvRow& row : floors)
    if (row.at("samples") == "low discrepancy") {
      INFO(row.at("shape"));
      CHECK(std::stod(row.at("flat %")) > 1);
      CHECK(std::stod(row.at("flat / by area")) > 15);  // 83 and 26 at 10,000 points
    }
}

TEST_CASE(
    "figures: on the survey's models low discrepancy beats random, and curved samples have no error floor",
    "[slow]") {
  MEANDER_NEEDS_FIGURES();
  MEANDER_NEEDS_SHARED_DATA();
  const ScratchFolder scratch;
  const ProcessResult result = run_process(
      {program, "figures", "-o", scratch / "out", "--only", "22,23,24,25,table-1,histogram-floors",
       "--models", shared_data("paper/bunny_closed.off"), shared_data("paper/maxplanck_25k.off"),
       shared_data("paper/fandisk.off"), shared_data("paper/hand_closed.obj")});
  INFO(result.err);
  REQUIRE(result.exit_code == 0);
  std::size_t compared = 0, equal = 0, tested = 0;
  for (const CsvRow& row : csv_rows(scratch / "out/table1_claims.csv")) {
    if (row.at("claim") == "equals conformal") {
      equal += row.at("holds") == "yes";
      ++tested;
      continue;
    }
    if (row.at("claim") != "smaller error" || row.at("ground truth") == "all vertices") continue;
    INFO(row.at("model") << ", " << row.at("points") << " points, " << row.at("ground truth") << ", "
                         << row.at("error"));
    CHECK(std::stod(row.at("gap")) > 2);
    CHECK(row.at("holds") == "yes");
    ++compared;
  }
  CHECK(compared == 4 * 2 * 2 * 3 * 3);  // models, numbers of points, corrected ground truths, errors, charts
  CHECK(tested == 4 * 2 * 3 * 3 * 2);    // all ground truths, two charts
  CHECK(equal >= tested * 8 / 10);  // equal methods differ in one comparison of twenty; they come in groups
  for (const CsvRow& row : csv_rows(scratch / "out/histogram_floors_shapes.csv"))
    if (row.at("samples") == "low discrepancy") {
      INFO(row.at("shape"));
      CHECK(row.at("points") == "100000");
      CHECK(std::stod(row.at("flat / by area")) > 40);
    }
}
