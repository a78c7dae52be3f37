// Formulas as a user gives them: densities of `run`, surfaces of `surface`.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "io/store/store_reader.h"
#include "support/catch.h"
#include "support/meander_program.h"
#include "support/mesh_files.h"
#include "support/run_process.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;
using Catch::Matchers::ContainsSubstring;

namespace {

ProcessResult sampled_by_formula(const std::filesystem::path& input, const std::string& store,
                                 const std::string& density, const std::vector<std::string>& more = {}) {
  std::vector<std::string> arguments = {program, "run",  input.string(), "-o",   store,
                                        "-n",    "2000", "--density",    density};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return run_process(arguments);
}

ProcessResult surface_by_formula(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), {program, "surface"});
  return run_process(arguments);
}

// [15, 25] x [25, 35] x [35, 45].
PolygonMesh raised_box() {
  PolygonMesh mesh = cube();
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    mesh.x[v] = 20 + 5 * mesh.x[v];
    mesh.y[v] = 30 + 5 * mesh.y[v];
    mesh.z[v] = 40 + 5 * mesh.z[v];
  }
  return mesh;
}

void input_folder(const ScratchFolder& scratch) { std::filesystem::create_directories(scratch / "in"); }

double mean_height(const Samples& samples) {
  double sum = 0;
  for (std::size_t i = 2; i < samples.points.size(); i += 3) sum += samples.points[i];
  return sum / static_cast<double>(samples.count());
}

}  // namespace

TEST_CASE("run --density formula: every model is sampled by it, and the store records it") {
  const ScratchFolder scratch;
  input_folder(scratch);
  write_mesh(scratch / "in/ball.ply", icosphere(3));
  write_mesh(scratch / "in/box.ply", raised_box());
  const std::string store = scratch / "s.h5", in_box = scratch / "t.h5";
  const ProcessResult result = sampled_by_formula(scratch / "in", store, "formula:1 + z^2");
  INFO(result.err);
  REQUIRE(result.exit_code == 0);
  const StoreReader reader(store);
  CHECK(reader.header().parameters_json.find("formula:1 + z^2") != std::string::npos);
  // Integral of z (1 + z^2) over that of 1 + z^2 on the box, z from 35 to 45, top and bottom of area 100,
  // four sides 100.
  const double ends = 45 * (1 + 45.0 * 45) + 35 * (1 + 35.0 * 35), ends_mass = 2 + 45.0 * 45 + 35 * 35;
  const auto integral = [](double power) {
    return (std::pow(45, power + 1) - std::pow(35, power + 1)) / (power + 1) / 10;
  };
  const double expected =
      (ends + 4 * (integral(1) + integral(3))) / (ends_mass + 4 * (integral(0) + integral(2)));
  CHECK(mean_height(reader.read_row(1).samples) == Approx(expected).margin(0.01));
  CHECK(reader.report(1).measure ==
        Approx(100 * (ends_mass + 4 * (integral(0) + integral(2)))).epsilon(1e-5));
  // Of the unit box the formula is another, and it does not see where the box lies.
  REQUIRE(sampled_by_formula(scratch / "in", in_box, "unit-formula:z").exit_code == 0);
  CHECK(mean_height(StoreReader(in_box).read_row(1).samples) ==
        Approx(35 + 10 * (1 + 4 / 3.0) / 3).margin(0.01));
}

TEST_CASE("run --density formula: texture coordinates are read for it, and a model without them is named") {
  const ScratchFolder scratch;
  input_folder(scratch);
  write_file(scratch / "in/with.obj",
             "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\n");
  write_file(scratch / "in/without.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n");
  const std::string store = scratch / "s.h5";
  CHECK(sampled_by_formula(scratch / "in", store, "formula:u*v").exit_code == 3);
  const StoreReader reader(store);
  CHECK(reader.report(0).status == Status::ok);
  CHECK(reader.report(0).measure == Approx(0.25).epsilon(1e-5));
  CHECK(reader.report(1).status == Status::missing_attribute);
  CHECK_THAT(reader.report(1).reason,
             ContainsSubstring("uses texture coordinates, u or v, but the file has none"));
}

TEST_CASE("run --density formula: mistakes in it are usage errors, and nothing is written") {
  const ScratchFolder scratch;
  input_folder(scratch);
  write_mesh(scratch / "in/ball.ply", icosphere(1));
  const auto says = [&](const std::string& density, const std::string& text,
                        const std::vector<std::string>& more = {}) {
    const ProcessResult result = sampled_by_formula(scratch / "in", scratch / "s.h5", density, more);
    CHECK(result.exit_code == 2);
    CHECK_THAT(result.err, ContainsSubstring(text));
    CHECK_FALSE(std::filesystem::exists(scratch / "s.h5"));
  };
  says("formula:1 +", "column 4");
  says("formula:zz", "unknown name \"zz\"");
  says("1 + z", "formula:TEXT");
  says("formula:z^2", "does not go with the method anisotropic", {"--method", "anisotropic"});
  says("formula:1 + z", "--density-floor applies", {"--density-floor", "0.5"});
}

TEST_CASE("run --tensor formula: spacings by formula, with texture coordinates, resume to identical bytes") {
  const ScratchFolder scratch;
  input_folder(scratch);
  write_file(scratch / "in/sheet.obj",
             "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\n");
  const auto anisotropic = [&](const std::string& store) {
    return run_process({program, "run", scratch / "in", "-o", scratch / store, "-n", "200", "--method",
                        "anisotropic", "--tensor", "formula:2 + u, 0, 0"});
  };
  const ProcessResult result = anisotropic("a.h5");
  INFO(result.err);
  REQUIRE(result.exit_code == 0);
  const StoreReader reader(scratch / "a.h5");
  CHECK(reader.header().parameters_json.find("formula:2 + u, 0, 0") != std::string::npos);
  const Row row = reader.read_row(0);
  double worst = 0;
  for (std::size_t i = 0; i < 200; ++i) {
    const double ratio = static_cast<double>(row.samples.tensor_spacing[2 * i]) /
                         static_cast<double>(row.samples.tensor_spacing[2 * i + 1]);
    worst = std::max(worst, std::abs(ratio - 2 * std::pow(1.5, row.samples.points[3 * i])));
  }
  CHECK(worst < 1e-5);  // between the corners, where it is 2 or 3, the logarithm is linear
  REQUIRE(anisotropic("b.h5").exit_code == 0);
  CHECK(read_file(scratch / "a.h5") == read_file(scratch / "b.h5"));
}

TEST_CASE("run and remesh --density formula: the stored parameters serve queries and meshes") {
  const ScratchFolder scratch;
  input_folder(scratch);
  write_mesh(scratch / "in/ball.ply", icosphere(2));
  write_mesh(scratch / "in/ring.ply", torus(20, 10));
  const std::string store = scratch / "s.h5";
  REQUIRE(sampled_by_formula(scratch / "in", store, "formula:1.5 + z^3", {"--describe", "d2"}).exit_code ==
          0);
  const ProcessResult query = run_process({program, "retrieve", "query", store, "--mesh",
                                           scratch / "in/ring.ply", "--descriptor", "d2", "-k", "1"});
  INFO(query.err);
  CHECK(query.exit_code == 0);
  CHECK_THAT(query.out, ContainsSubstring("ring.ply"));
  const ProcessResult mesh = run_process({program, "remesh", scratch / "in/ring.ply", "-o", scratch / "m",
                                          "-n", "300", "--density", "formula:1.5 + z^3"});
  INFO(mesh.err);
  CHECK(mesh.exit_code == 0);
}

TEST_CASE("surface: three formulas define a surface with exact derivatives") {
  const ScratchFolder scratch;
  const std::string torus =
      "(1 + 0.5*cos(2*pi*v))*cos(2*pi*u), (1 + 0.5*cos(2*pi*v))*sin(2*pi*u), 0.5*sin(2*pi*v)";
  const std::string store = scratch / "s.h5";
  const ProcessResult result =
      surface_by_formula({"u, v, sin(6*u)/4", torus, "-n", "500", "--density", "mean", "-o", store});
  INFO(result.err);
  REQUIRE(result.exit_code == 0);
  const StoreReader reader(store);
  REQUIRE(reader.rows() == 2);
  CHECK(reader.id(1) == "u,v,sin(6*u)%2F4");
  const Row waves = reader.read_row(1);
  for (std::size_t i = 0; i < 500; ++i) {
    const double u = waves.samples.uv[2 * i];
    REQUIRE(waves.samples.points[3 * i + 2] == Approx(std::sin(6 * u) / 4).margin(2e-6));
  }
  CHECK(reader.id(1).find('/') == std::string::npos);
  REQUIRE(run_process({program, "export", store, "-o", scratch / "out", "--format", "ply"}).exit_code == 0);
  CHECK(std::filesystem::is_regular_file(scratch / "out" / (reader.id(1) + ".ply")));
  // The same numbers as the surface of that name.
  REQUIRE(surface_by_formula({"torus", "-n", "500", "--density", "mean", "-o", scratch / "t.h5"}).exit_code ==
          0);
  CHECK(reader.report(0).area == Approx(StoreReader(scratch / "t.h5").report(0).area).epsilon(1e-9));
  CHECK(reader.report(0).measure == Approx(StoreReader(scratch / "t.h5").report(0).measure).epsilon(1e-6));
}

TEST_CASE("surface: an invalid or non-finite formula is reported with its position") {
  const ScratchFolder scratch;
  const auto says = [&](const std::string& formula, int exit_code, const std::string& text) {
    CAPTURE(formula);
    const ProcessResult result =
        surface_by_formula({formula, "-n", "100", "-o", scratch / "s.h5", "--fresh"});
    CHECK(result.exit_code == exit_code);
    CHECK_THAT(result.err + result.out, ContainsSubstring(text));
  };
  says("u, v", 2, "has 2 formulas: it needs three");
  says("u, v, w", 2, "unknown name \"w\"");
  says("u, v, sin(6*", 2, "expected a number");
  says("-u, v, u*v", 2, "as 0 - x instead of -x");
  says("u, v, log(u)", 3, "has no position at u = 0");
}
