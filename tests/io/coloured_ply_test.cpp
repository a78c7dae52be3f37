#include "io/plot/coloured_ply.h"

#include <stdexcept>

#include "io/mesh/point_reader.h"
#include "io/reading.h"
#include "support/mesh_files.h"

using namespace meander;
using namespace meander::test;

namespace {

const std::vector<double> corners = {0, 0, 0, 1, 0, 0.1, 0, 1e-17, 0, 1.0 / 3, 1, 1};

std::vector<double> attribute(const std::vector<ScalarAttribute>& attributes, const std::string& name) {
  for (const ScalarAttribute& a : attributes)
    if (a.name == name) return a.values;
  return {};
}

PolygonMesh read_back(const std::string& ply) {
  return read_mesh(std::as_bytes(std::span(ply)), MeshFormat::ply);
}

}  // namespace

TEST_CASE("coloured_mesh_ply: the reader finds positions, faces and the colours of the faces") {
  const std::vector<std::uint32_t> faces = {0, 1, 2, 2, 1, 3};
  const std::vector<PlyColour> colours = {{255, 0, 7}, {1, 2, 3}};
  const std::string ply = coloured_mesh_ply(corners, faces, colours);
  // What MeshLab and others look for.
  CHECK(ply.starts_with("ply\nformat binary_little_endian 1.0\nelement vertex 4\n"));
  CHECK(ply.find("property list uchar int vertex_indices\nproperty uchar red\n") != std::string::npos);
  const PolygonMesh mesh = read_back(ply);
  CHECK(mesh.corners == faces);
  REQUIRE(mesh.vertex_count() == 4);
  for (std::size_t v = 0; v < 4; ++v) {
    CHECK(mesh.x[v] == corners[3 * v]);
    CHECK(mesh.y[v] == corners[3 * v + 1]);
    CHECK(mesh.z[v] == corners[3 * v + 2]);
  }
  CHECK(attribute(mesh.face_attributes, "red") == std::vector<double>{255, 1});
  CHECK(attribute(mesh.face_attributes, "green") == std::vector<double>{0, 2});
  CHECK(attribute(mesh.face_attributes, "blue") == std::vector<double>{7, 3});
}

TEST_CASE(
    "coloured_points_ply: the reader finds points and normals; every row has the bytes that the header "
    "states") {
  const ScratchFolder scratch;
  const std::vector<float> normals = {0, 0, 1, 0, 1, 0, 1, 0, 0, 0.6f, 0.8f, 0},
                           axes = {1, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1}, values = {1, 2, 3, 4, 5, 6, 7, 8};
  const std::vector<PlyColour> colours = {{1, 2, 3}, {4, 5, 6}, {7, 8, 9}, {10, 11, 12}};
  const std::vector<std::string> names = {"spacing_1", "spacing_2"};
  const std::string ply = coloured_points_ply({corners, normals, colours, axes, names, values});
  CHECK(ply.size() == ply.find("end_header\n") + 11 + 4 * (24 + 12 + 3 + 12 + 8));
  write_file(scratch / "points.ply", ply);
  const PointCloud cloud = read_points(scratch / "points.ply");
  REQUIRE(cloud.count() == 4);
  CHECK(cloud.x == std::vector<double>{0, 1, 0, 1.0 / 3});
  CHECK(cloud.normals == normals);
  const std::string bare = coloured_points_ply({corners});
  CHECK(bare.size() == bare.find("end_header\n") + 11 + 4 * 24);
}

TEST_CASE("coloured PLY: arrays that do not fit together are refused") {
  const std::vector<std::uint32_t> faces = {0, 1, 2};
  CHECK_THROWS_AS(coloured_mesh_ply(corners, faces, {}), std::invalid_argument);
  const std::vector<float> normals(9, 0.f);
  CHECK_THROWS_AS(coloured_points_ply({corners, normals}), std::invalid_argument);
  const std::vector<std::string> names = {"index"};
  CHECK_THROWS_AS(coloured_points_ply({corners, {}, {}, {}, names}), std::invalid_argument);
}
