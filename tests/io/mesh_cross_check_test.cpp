// Our readers against OpenMesh's, on generated files and real ones.
#include <OpenMesh/Core/IO/MeshIO.hh>
#include <OpenMesh/Core/Mesh/PolyMesh_ArrayKernelT.hh>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "io/reading.h"
#include "support/mesh_files.h"
#include "support/sanitized.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;

namespace {

struct DoubleTraits : OpenMesh::DefaultTraits {
  using Point = OpenMesh::Vec3d;
  using Normal = OpenMesh::Vec3d;
};
using Oracle = OpenMesh::PolyMesh_ArrayKernelT<DoubleTraits>;

// The file as OpenMesh reads it; false when it cannot, or leaves faces out (complex edges).
bool read_with_openmesh(const std::filesystem::path& path, Oracle& oracle) {
  omerr().disable();
  omlog().disable();
  OpenMesh::IO::Options options;
  return OpenMesh::IO::read_mesh(oracle, path.string(), options);
}

bool close(double a, double b) {
  return std::abs(a - b) <= 1e-6 * std::max(std::abs(a), std::abs(b)) + 1e-30;
}

// The corners of each face as positions, each face beginning at its smallest corner: what does not depend on
// how vertices are numbered.
using Corner = std::array<double, 3>;
std::vector<std::vector<Corner>> rotated(std::vector<std::vector<Corner>> faces) {
  for (std::vector<Corner>& face : faces)
    if (!face.empty()) std::rotate(face.begin(), std::min_element(face.begin(), face.end()), face.end());
  return faces;
}

Corner as_float(double x, double y, double z) {
  return {static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)};
}

std::vector<std::vector<Corner>> face_positions(const PolygonMesh& mesh) {
  std::vector<std::vector<Corner>> faces;
  for (const std::vector<std::uint32_t>& face : test::faces_of(mesh)) {
    faces.emplace_back();
    for (const std::uint32_t v : face) faces.back().push_back(as_float(mesh.x[v], mesh.y[v], mesh.z[v]));
  }
  return rotated(faces);
}

std::vector<std::vector<Corner>> face_positions(const Oracle& oracle) {
  std::vector<std::vector<Corner>> faces;
  for (const auto face : oracle.faces()) {
    faces.emplace_back();
    for (const auto vertex : face.vertices()) {
      const auto& p = oracle.point(vertex);
      faces.back().push_back(as_float(p[0], p[1], p[2]));
    }
  }
  return rotated(faces);
}

// OpenMesh welds STL vertices and turns faces to begin elsewhere, so faces are compared by their positions.
bool same_as_openmesh(const PolygonMesh& mesh, const Oracle& oracle, MeshFormat format) {
  if (mesh.polygon_count() != oracle.n_faces()) return false;
  if (format != MeshFormat::stl) {
    if (mesh.vertex_count() != oracle.n_vertices()) return false;
    for (const auto vertex : oracle.vertices()) {
      const auto v = static_cast<std::size_t>(vertex.idx());
      const auto& p = oracle.point(vertex);
      if (!close(p[0], mesh.x[v]) || !close(p[1], mesh.y[v]) || !close(p[2], mesh.z[v])) return false;
    }
  }
  return face_positions(mesh) == face_positions(oracle);
}

}  // namespace

TEST_CASE("read_mesh agrees with OpenMesh on generated files") {
  const ScratchFolder folder;
  const std::pair<const char*, MeshFile> files[] = {{"a.off", MeshFile::off},
                                                    {"a.obj", MeshFile::obj},
                                                    {"a.ply", MeshFile::ply_ascii},
                                                    {"b.ply", MeshFile::ply_little_endian},
                                                    {"c.ply", MeshFile::ply_big_endian},
                                                    {"a.stl", MeshFile::stl_ascii},
                                                    {"b.stl", MeshFile::stl_binary}};
  const PolygonMesh shapes[] = {cube(), icosphere(3), torus(24, 12),
                                moved(merged(cube(), icosphere(1)), 0.01, 5, -7, 3)};
  for (const PolygonMesh& shape : shapes)
    for (const auto& [name, file] : files) {
      CAPTURE(name, shape.polygon_count());
      write_mesh(folder / name, shape, file);
      MeshFormat format{};
      REQUIRE(mesh_format_of(name, format));
      Oracle oracle;
      REQUIRE(read_with_openmesh(folder / name, oracle));
      REQUIRE(same_as_openmesh(read(read_file(folder / name), format), oracle, format));
    }
}

TEST_CASE("read_mesh agrees with OpenMesh on real files", "[release]") {
  MEANDER_NEEDS_SHARED_DATA();
  std::size_t compared = 0, files = 0;
  for (const char* const folder : {"paper", "retrieval"})
    for (const auto& entry : std::filesystem::recursive_directory_iterator(shared_data(folder))) {
      MeshFormat format{};
      if (!entry.is_regular_file() || !mesh_format_of(entry.path(), format)) continue;
      if (sanitized && ++files % 4 != 0) continue;  // release builds compare all
      CAPTURE(entry.path().string());
      const FileBytes file(entry.path());
      const PolygonMesh mesh = read_mesh(file.bytes(), format);
      check_consistent(mesh);
      Oracle oracle;
      REQUIRE(read_with_openmesh(entry.path(), oracle));
      // OpenMesh leaves out faces on complex edges and copies vertices: nothing to compare then.
      if (oracle.n_faces() != mesh.polygon_count()) continue;
      if (format != MeshFormat::stl && oracle.n_vertices() != mesh.vertex_count()) continue;
      REQUIRE(same_as_openmesh(mesh, oracle, format));
      ++compared;
    }
  REQUIRE(compared > (sanitized ? 25 : 100));
}

TEST_CASE("read_mesh: every dirty file is read or fails with a named status") {
  MEANDER_NEEDS_SHARED_DATA();
  const std::map<std::string, std::string> failures = {
      {"assimp_OutOfMemory.off", "unreadable"},
      {"assimp_crash-30d6d0f7c529b3b66b4131700b7a4580cd7082df.ply", "unreadable"},
      {"assimp_empty.off", "empty"},
      {"assimp_issue623.ply", "empty"},
      {"trimesh_empty.stl", "empty"},
      {"trimesh_obj_wireframe.obj", "empty"},
      {"trimesh_ply_points_bin.ply", "empty"}};
  std::size_t files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(shared_data("dirty"))) {
    MeshFormat format{};
    REQUIRE(mesh_format_of(entry.path(), format));
    CAPTURE(entry.path().string());
    const auto expected = failures.find(entry.path().filename().string());
    const std::string result = outcome(read_file(entry.path()), format);
    REQUIRE(result.substr(0, result.find(':')) == (expected == failures.end() ? "ok" : expected->second));
    if (expected == failures.end()) check_consistent(read(read_file(entry.path()), format));
    ++files;
  }
  REQUIRE(files == 81);
}

TEST_CASE("read_mesh: repairs and counts of selected dirty files are as expected") {
  MEANDER_NEEDS_SHARED_DATA();
  const auto dirty = [](const std::string& name) {
    MeshFormat format{};
    REQUIRE(mesh_format_of(name, format));
    return read(read_file(shared_data("dirty/" + name)), format);
  };
  REQUIRE(dirty("derived_torus_overcount.off").repairs[Repair::missing_faces] == 100);
  REQUIRE(dirty("derived_eight_truncated.off").repairs[Repair::missing_faces] == 1229);
  REQUIRE(dirty("derived_torus_stlsolid.stl").polygon_count() == 2400);
  REQUIRE(dirty("assimp_box_UTF16BE.obj").polygon_count() == 6);
  REQUIRE(dirty("assimp_box_longline.obj").corners.size() > 900);
  REQUIRE(dirty("trimesh_comments.off").polygon_count() == 6);
  REQUIRE(dirty("trimesh_negative_indices.obj").corner_normals.size() == 24);
  REQUIRE(dirty("trimesh_fuze_ascii.ply").face_attributes.size() == 4);
  REQUIRE(faces_of(dirty("assimp_malformed.obj"))[0] == std::vector<std::uint32_t>{3, no_index, 1, 0});
  REQUIRE(faces_of(dirty("trimesh_notenoughindices.obj")) == Faces{{0, 1}, {0, 1, 2}});
}
