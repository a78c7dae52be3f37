#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "io/file/file_bytes.h"
#include "io/mesh/mesh_reader.h"
#include "io/mesh/point_reader.h"
#include "support/catch.h"
#include "support/meander_program.h"
#include "support/mesh_files.h"
#include "support/run_process.h"
#include "support/sanitized.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;

namespace {

// Rows of a CSV file without quoted cells, by cell; the header is row 0.
std::vector<std::vector<std::string>> csv_cells(const std::string& path) {
  std::vector<std::vector<std::string>> rows;
  std::istringstream text(read_file(path));
  for (std::string line; std::getline(text, line);) {
    rows.emplace_back();
    std::istringstream cells(line);
    for (std::string cell; std::getline(cells, cell, ',');) rows.back().push_back(cell);
  }
  return rows;
}

std::set<std::array<double, 3>> face_colors(const PolygonMesh& mesh) {
  std::set<std::array<double, 3>> colors;
  std::array<const ScalarAttribute*, 3> parts{};
  for (const ScalarAttribute& a : mesh.face_attributes)
    for (std::size_t k = 0; k < 3; ++k)
      if (a.name == std::array{"red", "green", "blue"}[k]) parts[k] = &a;
  for (const ScalarAttribute* part : parts) REQUIRE(part != nullptr);
  for (std::size_t f = 0; f < mesh.polygon_count(); ++f)
    colors.insert({parts[0]->values[f], parts[1]->values[f], parts[2]->values[f]});
  return colors;
}

}  // namespace

TEST_CASE(
    "figures: fields, segments and anisotropic samples are drawn, with PLY files that read_mesh reads") {
  if (sanitized) {
    WARN("skipped: a sanitized build has no library for Python");
    return;
  }
  const ScratchFolder scratch;
  write_mesh(scratch / "ring.off", torus(48, 24));
  const ProcessResult result = run_process({program, "figures", "-o", scratch / "out", "--quick", "--only",
                                            "12,13,14", "--models", scratch / "ring.off"});
  INFO(result.err);
  REQUIRE(result.exit_code == 0);
  const std::string page = read_file(scratch / "out/index.html");
  CHECK(page.find("Not drawn") == std::string::npos);
  for (const char* name : {"figure12_ellipsoid_field.png", "figure12_ring.png", "figure12_ring_field.png",
                           "figure13_ring_metric.png", "figure13_ring_gradient.png", "figure14_ring.png"}) {
    INFO(name);
    CHECK(page.find(name) != std::string::npos);
    CHECK(read_file(scratch / (std::string("out/") + name)).size() > 1000);
  }
  // The umbilics of an ellipsoid with half-axes a > b > c lie at x^2 = a^2 (a^2 - b^2) / (a^2 - c^2), y = 0.
  const auto wedges = csv_cells(scratch / "out/figure12_ellipsoid_singularities.csv");
  REQUIRE(wedges.size() == 5);
  for (std::size_t i = 1; i < wedges.size(); ++i) {
    CHECK(wedges[i][0] == "wedge");
    CHECK(std::abs(std::stod(wedges[i][2])) == Approx(1.222).margin(0.1));
    CHECK(std::stod(wedges[i][3]) == Approx(0).margin(0.1));
    CHECK(std::abs(std::stod(wedges[i][4])) == Approx(0.516).margin(0.1));
  }
  CHECK(read_points(scratch / "out/figure12_ellipsoid_singularities.ply").count() == 4);
  // The curve goes along the field where it is aligned to it; by chance it is 22.5 degrees away.
  const auto curves = csv_cells(scratch / "out/figure12_curves.csv");
  REQUIRE(curves.size() == 3);
  CHECK(std::stod(curves[1].back()) > 8);
  CHECK(std::stod(curves[2].back()) < 5);
  for (const char* form : {"metric", "gradient"}) {
    const std::string stem = scratch / (std::string("out/figure13_ring_") + form);
    const FileBytes file(stem + "_segments.ply");
    const PolygonMesh mesh = read_mesh(file.bytes(), MeshFormat::ply);
    CHECK(mesh.polygon_count() == 48 * 24 * 2);
    CHECK(face_colors(mesh).size() >= 4);
    // Segments cover the surface, and some of their curves come in several chains.
    const auto segments = csv_cells(stem + "_segments.csv");
    double share = 0;
    int chains = 0;
    for (std::size_t i = 1; i < segments.size(); ++i) {
      share += std::stod(segments[i][1]);
      chains = std::max(chains, std::stoi(segments[i][4]));
    }
    CHECK(share == Approx(1));
    CHECK(chains >= 2);
  }
  const PointCloud samples = read_points(scratch / "out/figure14_ring_samples.ply");
  CHECK(samples.count() == 800);
  CHECK(samples.normals.size() == 2400);
}

TEST_CASE("figures: discrepancy and differences of anisotropic samples are drawn", "[statistics]") {
  if (sanitized) {
    WARN("skipped: a sanitized build has no library for Python");
    return;
  }
  const ScratchFolder scratch;
  write_mesh(scratch / "ring.off", torus(48, 24));
  const ProcessResult result = run_process({program, "figures", "-o", scratch / "out", "--quick", "--only",
                                            "15,16-tensor", "--models", scratch / "ring.off"});
  INFO(result.err);
  REQUIRE(result.exit_code == 0);
  const std::string page = read_file(scratch / "out/index.html");
  CHECK(page.find("Not drawn") == std::string::npos);
  for (const char* name :
       {"figure15_discrepancy.svg", "figure16_tensor_plane_32768.svg", "figure16_tensor_plane_2048.svg",
        "figure16_tensor_swirl.svg", "figure16_tensor_ring.svg"})
    CHECK(page.find(name) != std::string::npos);
  // Slopes of all ratios and shapes: low discrepancy below -0.6 and a third of the random error at 1,000.
  const auto slopes = csv_cells(scratch / "out/figure15_slopes.csv");
  REQUIRE(slopes.size() == 25);
  double low = 0, random = 0;
  for (std::size_t i = 1; i < slopes.size(); ++i) {
    INFO(slopes[i][0] << " " << slopes[i][1] << " " << slopes[i][2]);
    const bool is_random = slopes[i][2] == "random";
    const double slope = std::stod(slopes[i][3]);
    CHECK((is_random ? std::abs(slope + 0.5) < 0.13 : slope < -0.6));
    (is_random ? random : low) += std::stod(slopes[i][7]);
  }
  CHECK(low < 0.5 * random);
  // In units of spacings the dip is nearly round on the fine mesh, also where the wanted ratio is 8.
  const auto dips = csv_cells(scratch / "out/figure16_tensor_plane.csv");
  REQUIRE(dips.size() == 9);
  for (std::size_t i = 1; i <= 4; ++i) {
    INFO(dips[i][2]);
    CHECK(std::stod(dips[i][5]) < 1.35);
    CHECK(std::stod(dips[i][6]) > 0.6);
  }
  // In units of area it is as long as the field says.
  CHECK(std::stod(dips[2][3]) == Approx(2).epsilon(0.25));
  CHECK(std::stod(dips[3][3]) == Approx(4).epsilon(0.25));
}
