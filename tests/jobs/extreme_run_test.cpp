// Coordinates that float32 does not hold, from the file to the store and out of it again.
#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <set>

#include "io/mesh/point_reader.h"
#include "io/store/store_reader.h"
#include "io/store/store_verify.h"
#include "support/catch.h"
#include "support/meander_program.h"
#include "support/mesh_files.h"
#include "support/run_process.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;

namespace {

namespace fs = std::filesystem;

std::size_t distinct_points(const Samples& s) {
  std::set<std::array<float, 3>> distinct;
  for (std::size_t i = 0; i < s.count(); ++i)
    distinct.insert({s.points[3 * i], s.points[3 * i + 1], s.points[3 * i + 2]});
  return distinct.size();
}

std::string triangle_text(const std::string& side) {
  return "OFF\n3 1 0\n0 0 0\n" + side + " 0 0\n0 " + side + " 0\n3 0 1 2\n";
}

// A box of sides 2 a and 1 a, so flat that float32 sees no thickness, one vertex ten times as far out.
std::string box_text() {
  const std::string a = "340282346999999984391321947108527833088.0",
                    ten = "3402823469999999843913219471085278233088.0";
  return "v -" + a + " " + a + " -" + a + "\nv " + ten + " " + a + " -" + a + "\nv -" + a + " -" + a + " -" +
         a + "\nv " + a + " -" + a + " -" + a + "\nv " + a + " " + a + " -100.0\nv -" + a + " -" + a +
         " -100.0\nv -" + a + " " + a + " -100.0\nv " + a + " -" + a +
         " -100.0\nf 1 2 3\nf 1 3 6\nf 1 5 2\nf 1 6 7\nf 1 7 5\nf 2 4 3\nf 5 4 2\nf 5 8 4\nf 6 3 4\nf 6 4 "
         "8\nf 7 6 "
         "8\nf 7 8 5\n";
}

}  // namespace

TEST_CASE("run: coordinates beyond float32 make valid stores, and export writes the file coordinates") {
  const ScratchFolder scratch;
  const fs::path models = scratch / "models";
  fs::create_directories(models);
  write_file(models / "large.off", triangle_text("1e39"));
  write_file(models / "small.off", triangle_text("1e-60"));
  write_file(models / "least.off", triangle_text("5e-324"));
  write_file(models / "box.obj", box_text());
  write_mesh(models / "torus.ply", moved(torus(12, 8), 1e150, 0, 0, 0), MeshFile::ply_little_endian);
  write_file(models / "too_large.off", triangle_text("1e200"));
  for (const std::vector<std::string>& more :
       std::vector<std::vector<std::string>>{{"--certify"},
                                             {"--method", "conformal", "--certify"},
                                             {"--method", "direct", "--certify"},
                                             {"--method", "anisotropic"},
                                             {"--method", "anisotropic", "--parameterisation", "gradient"}}) {
    const std::string store = scratch / "s.h5";
    std::vector<std::string> arguments = {
        program,
        "run",
        models.string(),
        "-o",
        store,
        "-n",
        "64",
        "--fresh",
        "--describe",
        "d2,a3,d1,d3,d4,geodesic,basics,pairs,pairs-unsigned,harmonics,views,shapedna"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const ProcessResult result = run_process(arguments);
    INFO(more.back() << ": " << result.err);
    REQUIRE(result.exit_code == 3);
    CHECK(run_process({program, "verify", store}).exit_code == 0);
    const StoreReader reader(store);
    for (std::uint64_t row = 0; row < reader.rows(); ++row) {
      const Row content = reader.read_row(row);
      INFO(reader.id(row) << ": " << content.report.reason);
      if (reader.id(row) == "too_large.off") {
        CHECK(content.report.status == Status::non_finite);
        continue;
      }
      REQUIRE(content.report.status == Status::ok);
      CHECK(distinct_points(content.samples) == 64);
    }
    const fs::path out = scratch / "out";
    REQUIRE(run_process({program, "export", store, "large.off", "-o", out.string()}).exit_code == 0);
    const PointCloud points = read_points(out / "large.off.ply");
    REQUIRE(points.count() == 64);
    const double largest = std::max(*std::max_element(points.x.begin(), points.x.end()),
                                    *std::max_element(points.y.begin(), points.y.end()));
    CHECK(largest > 5e38);
    CHECK(largest <= 1e39);
    fs::remove_all(out);
  }
}

TEST_CASE("surface: coordinates beyond float32 make valid stores") {
  const ScratchFolder scratch;
  const auto patch = [&](const std::string& name, const std::string& a) {
    const fs::path path = scratch / name;
    write_file(path, "degree 1 1\nknots_u 0 0 1 1\nknots_v 0 0 1 1\npoint 0 0 0\npoint 0 " + a +
                         " 0\npoint " + a + " 0 0\npoint " + a + " " + a + " 0\n");
    return path.string();
  };
  const std::string store = scratch / "s.h5";
  const ProcessResult result =
      run_process({program, "surface", patch("large.nurbs", "1e39"), patch("small.nurbs", "1e-60"),
                   patch("unit.nurbs", "1"), "-n", "256", "-o", store});
  INFO(result.err << result.out);
  REQUIRE(result.exit_code == 0);
  CHECK(verify_store(store).problems.empty());
  const StoreReader reader(store);
  for (std::uint64_t row = 0; row < reader.rows(); ++row) {
    const Row content = reader.read_row(row);
    INFO(reader.id(row));
    CHECK(distinct_points(content.samples) == 256);
    CHECK((content.report.scale == 1) == (reader.id(row) == "unit.nurbs"));
  }
}
