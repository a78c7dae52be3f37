#include <catch2/catch.hpp>

#include "support/mesh_files.h"
#include "support/run_process.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;

namespace {

const std::string program = MEANDER_PROGRAM;

}  // namespace

TEST_CASE("figures: the quick ones chosen are drawn with their data, and the page shows them") {
  const ScratchFolder scratch;
  write_mesh(scratch / "ball.off", icosphere(3));
  const ProcessResult result = run_process({program, "figures", "-o", scratch / "out", "--quick", "--only",
                                            "1,2,3,6,8,21", "--models", scratch / "ball.off"});
  INFO(result.err);
  REQUIRE(result.exit_code == 0);
  const std::string page = read_file(scratch / "out/index.html");
  for (const char* name : {"figure01_point_sets.svg", "figure02_stretched_plane.svg", "figure03_curves.svg",
                           "figure06_surfaces.png", "figure08_adaptive_curve.svg",
                           "figure21_mesh_distance.svg", "figure21_mesh_distance.csv"}) {
    INFO(name);
    CHECK(page.find(name) != std::string::npos);
    CHECK(read_file(scratch / (std::string("out/") + name)).size() > 100);
  }
}

TEST_CASE("figures: the same seed gives the same files, for one thread and two") {
  const ScratchFolder scratch;
  for (const char* threads : {"1", "2"})
    REQUIRE(
        run_process({program, "figures", "-o", scratch / threads, "--quick", "--only", "5,21", "-j", threads})
            .exit_code == 0);
  for (const auto& entry : std::filesystem::directory_iterator(scratch / "1")) {
    const std::string name = entry.path().filename().string();
    INFO(name);
    CHECK(read_file(scratch / ("1/" + name)) == read_file(scratch / ("2/" + name)));
  }
}

TEST_CASE(
    "figures: a mesh that cannot be sampled is said on the page, the others are drawn; far from the origin "
    "too") {
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

TEST_CASE("figures: an unknown figure and a mesh of quadrilaterals are usage errors") {
  const ScratchFolder scratch;
  const ProcessResult unknown = run_process({program, "figures", "-o", scratch / "out", "--only", "4-plain"});
  CHECK(unknown.exit_code == 2);
  CHECK(unknown.err.find("4-plane") != std::string::npos);
  write_file(scratch / "quad.off", "OFF\n4 1 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n");
  const ProcessResult quads =
      run_process({program, "figures", "-o", scratch / "out", "--models", scratch / "quad.off"});
  CHECK(quads.exit_code == 2);
  CHECK(quads.err.find("no triangles") != std::string::npos);
}
