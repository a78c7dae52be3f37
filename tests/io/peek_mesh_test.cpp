#include <algorithm>

#include "io/reading.h"
#include "support/mesh_files.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;

namespace {

struct Truth {
  double vertices = 0, triangles = 0;
};

Truth truth_of(const PolygonMesh& mesh) {
  Truth truth{static_cast<double>(mesh.vertex_count()), 0};
  for (std::size_t p = 0; p < mesh.polygon_count(); ++p)
    truth.triangles +=
        std::max(2.0, static_cast<double>(mesh.polygon_begin[p + 1] - mesh.polygon_begin[p])) - 2;
  return truth;
}

MeshEstimate peek_file(const std::filesystem::path& path) {
  MeshFormat format{};
  REQUIRE(mesh_format_of(path, format));
  return peek_mesh(path, format);
}

// The estimate is at least the truth and at most `most` times it.
void check_estimate(const MeshEstimate& estimate, const Truth& truth, double most) {
  CAPTURE(estimate.vertices, truth.vertices, estimate.triangles, truth.triangles);
  REQUIRE(static_cast<double>(estimate.vertices) >= truth.vertices);
  REQUIRE(static_cast<double>(estimate.triangles) >= truth.triangles);
  REQUIRE(static_cast<double>(estimate.vertices) <= most * truth.vertices + 2);
  REQUIRE(static_cast<double>(estimate.triangles) <= most * truth.triangles + 2);
}

struct NamedFile {
  const char* name;
  MeshFile file;
};
constexpr NamedFile named_files[] = {{"a.off", MeshFile::off},
                                     {"b.off", MeshFile::off_binary},
                                     {"a.obj", MeshFile::obj},
                                     {"a.ply", MeshFile::ply_ascii},
                                     {"b.ply", MeshFile::ply_little_endian},
                                     {"c.ply", MeshFile::ply_big_endian},
                                     {"a.stl", MeshFile::stl_ascii},
                                     {"b.stl", MeshFile::stl_binary}};

}  // namespace

TEST_CASE("peek_mesh: small files of every format are counted exactly") {
  const ScratchFolder folder;
  const PolygonMesh shapes[] = {tetrahedron(), cube(), icosphere(2), merged(cube(), icosphere(1))};
  for (const PolygonMesh& shape : shapes)
    for (const auto& [name, file] : named_files) {
      CAPTURE(name, shape.polygon_count());
      write_mesh(folder / name, shape, file);
      MeshFormat format{};
      REQUIRE(mesh_format_of(name, format));
      const PolygonMesh back = read(read_file(folder / name), format);
      check_estimate(peek_file(folder / name), truth_of(back), 1);
      REQUIRE(peek_file(folder / name).file_bytes == std::filesystem::file_size(folder / name));
    }
}

TEST_CASE("peek_mesh: large files of every format are estimated closely") {
  const ScratchFolder folder;
  PolygonMesh quads = polygon_mesh({}, {});
  for (int k = 0; k < 9000; ++k) quads = k == 0 ? cube() : quads;
  const PolygonMesh sphere = icosphere(6);
  PolygonMesh mixed;
  {
    std::vector<double> xyz;
    std::vector<std::vector<std::uint32_t>> faces;
    for (std::uint32_t v = 0; v < 60000; ++v) xyz.insert(xyz.end(), {v * 0.001, v * 0.37, -1.0 * v});
    for (std::uint32_t f = 0; f + 5 < 60000; ++f)
      faces.push_back(f % 3 == 0   ? std::vector<std::uint32_t>{f, f + 1, f + 2, f + 3}
                      : f % 3 == 1 ? std::vector<std::uint32_t>{f, f + 1, f + 2}
                                   : std::vector<std::uint32_t>{f, f + 1, f + 2, f + 3, f + 4});
    mixed = polygon_mesh(xyz, faces);
  }
  for (const PolygonMesh* const shape : {&sphere, &static_cast<const PolygonMesh&>(mixed)})
    for (const auto& [name, file] : named_files) {
      CAPTURE(name, shape->polygon_count());
      write_mesh(folder / name, *shape, file);
      MeshFormat format{};
      REQUIRE(mesh_format_of(name, format));
      const PolygonMesh back = read(read_file(folder / name), format);
      REQUIRE(std::filesystem::file_size(folder / name) > 500000);
      check_estimate(peek_file(folder / name), truth_of(back), 1.5);
    }
}

TEST_CASE("peek_mesh: an OBJ file with alternating objects, vertices and faces is estimated closely") {
  const ScratchFolder folder;
  std::string text;
  for (int object = 0; object < 3000; ++object) {
    for (int v = 0; v < 20; ++v)
      text += "v " + std::to_string(object * 0.1) + " " + std::to_string(v) + ".25 0\n";
    for (int f = 0; f < 30; ++f) text += "f -1 -2 -" + std::to_string(3 + f % 17) + "\n";
  }
  write_file(folder / "a.obj", text);
  check_estimate(peek_file(folder / "a.obj"), {60000, 90000}, 1.5);
}

TEST_CASE("peek_mesh: header counts are bounded by the file size") {
  const ScratchFolder folder;
  write_file(folder / "a.off", "OFF\n353535235358 6 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
  REQUIRE(peek_file(folder / "a.off").vertices < 20);
  REQUIRE(peek_file(folder / "a.off").triangles < 20);
  write_file(folder / "b.off", "OFF\n3 353535235358 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
  REQUIRE(peek_file(folder / "b.off").triangles == 1);
  std::string stl = mesh_bytes(cube(), MeshFile::stl_binary);
  stl[83] = '\x7F';
  write_file(folder / "a.stl", stl);
  REQUIRE(peek_file(folder / "a.stl").triangles == 12);
  std::string ply = mesh_bytes(icosphere(3), MeshFile::ply_little_endian);
  ply.replace(ply.find("element face 1280"), 17, "element face 9999999999");
  write_file(folder / "a.ply", ply);
  check_estimate(peek_file(folder / "a.ply"), {642, 1280}, 1.01);
  // A large file cut in its faces.
  std::string off = mesh_bytes(icosphere(6), MeshFile::off);
  off.resize(off.size() * 8 / 10);
  write_file(folder / "c.off", off);
  check_estimate(peek_file(folder / "c.off"), truth_of(read(off, MeshFormat::off)), 1.5);
}

TEST_CASE("peek_mesh: the values of all PLY properties are counted") {
  // As read: doubles of both scalars of each vertex, and of that of each face.
  for (const bool ascii : {true, false}) {
    std::string text = std::string("ply\nformat ") + (ascii ? "ascii" : "binary_little_endian") +
                       " 1.0\nelement vertex 300\nproperty float x\nproperty float y\nproperty float z\n"
                       "property uchar a\nproperty uchar b\nelement face 100\n"
                       "property list uchar uchar vertex_indices\nproperty uchar kind\nend_header\n";
    for (int v = 0; v < 300; ++v) text += ascii ? "0 1 2 3 4\n" : std::string(14, '\0');
    for (int f = 0; f < 100; ++f) text += ascii ? "3 0 1 2 9\n" : std::string("\3\0\1\2\7", 5);
    const ScratchFolder folder;
    write_file(folder / "a.ply", text);
    const PolygonMesh mesh = read_mesh(std::as_bytes(std::span(text)), MeshFormat::ply);
    CHECK(mesh.attribute_bytes() == 8 * (2 * 300 + 100));
    CHECK(peek_file(folder / "a.ply").decoding_bytes == mesh.attribute_bytes());
    CHECK(row_of(MeshFormat::ply).most(text.size()).decoding_bytes >= mesh.attribute_bytes());
  }
}

TEST_CASE("peek_mesh: malformed and unusual files have an estimate too") {
  const ScratchFolder folder;
  const PolygonMesh mesh = merged(cube(), icosphere(1));
  for (const auto& [name, file] : named_files) {
    const std::string content = mesh_bytes(mesh, file);
    for (std::size_t length = 0; length < content.size(); length += 1 + length / 10) {
      CAPTURE(name, length);
      write_file(folder / name, content.substr(0, length));
      const MeshEstimate estimate = peek_file(folder / name);
      REQUIRE(estimate.file_bytes == length);
      REQUIRE(estimate.vertices <= length / 3 + 2);
      REQUIRE(estimate.triangles <= length / 3 + 2);
      MeshFormat format{};
      REQUIRE(mesh_format_of(name, format));
      const std::string cut = content.substr(0, length);
      if (failure(cut, format)) continue;
      // How many of the announced polygons a cut binary file holds depends on their sizes: there it is a
      // guess.
      const bool guess = file == MeshFile::off_binary || file == MeshFile::ply_little_endian ||
                         file == MeshFile::ply_big_endian;
      Truth truth = truth_of(read(cut, format));
      if (guess) truth.triangles /= 2;
      check_estimate(estimate, truth, guess ? 8 : 4);
    }
  }
  write_file(folder / "cr.off", "OFF\r3 1 0\r0 0 0\r1 0 0\r0 1 0\r3 0 1 2\r");
  check_estimate(peek_file(folder / "cr.off"), {3, 1}, 1);
  write_file(folder / "lines.off", "OFF\n3 1 0\n0 0 0 1 0 0\n0 1\n0\n3 0\n1\n2\n");
  check_estimate(peek_file(folder / "lines.off"), {3, 1}, 1);
  write_file(folder / "continued.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 \\\n3\n");
  check_estimate(peek_file(folder / "continued.obj"), {3, 1}, 1);
  write_file(folder / "long_header.off", "OFF BINARY " + std::string(300000, 'x'));
  REQUIRE(peek_file(folder / "long_header.off").file_bytes == 300011);
  REQUIRE_THROWS_AS(peek_mesh(folder / "absent.off", MeshFormat::off), ItemError);
}

TEST_CASE("most_in_file: no file of its size holds more") {
  const auto check = [](const std::string& content, MeshFormat format, double used) {
    const std::optional most = row_of(format).most(content.size());
    REQUIRE(most);
    CHECK(most->file_bytes == content.size());
    const Truth truth = truth_of(read(content, format));
    CAPTURE(content.size(), truth.vertices, truth.triangles);
    CHECK(truth.vertices <= static_cast<double>(most->vertices));
    CHECK(truth.triangles <= static_cast<double>(most->triangles));
    CHECK(truth.triangles >= used * static_cast<double>(most->triangles));
  };
  const ScratchFolder folder;
  for (const PolygonMesh& shape : {tetrahedron(), cube(), icosphere(2)})
    for (const auto& [name, file] : named_files) {
      CAPTURE(name, shape.polygon_count());
      write_mesh(folder / name, shape, file);
      MeshFormat format{};
      REQUIRE(mesh_format_of(name, format));
      check(read_file(folder / name), format, 0);
    }
  // One polygon that is nearly all of the file.
  std::string vertices, corners;
  for (int k = 0; k < 9; ++k) vertices += std::to_string(k) + " " + std::to_string(k * k) + " 0\n";
  for (int k = 0; k < 6000; ++k) corners += " " + std::to_string(k % 9);
  check("OFF\n9 1 0\n" + vertices + "6000" + corners + "\n", MeshFormat::off, 0.9);
  std::string lines = "v " + vertices;
  for (std::size_t at = lines.find('\n'); at + 1 < lines.size(); at = lines.find('\n', at + 1))
    lines.insert(at + 1, "v ");
  std::string face = "f";
  for (int k = 0; k < 6000; ++k) face += " " + std::to_string(k % 9 + 1);
  check(lines + face + "\n", MeshFormat::obj, 0.9);
  std::string ply =
      "ply\nformat binary_little_endian 1.0\nelement vertex 9\nproperty uchar x\nproperty uchar y\n"
      "property uchar z\nelement face 1\nproperty list ushort uchar vertex_indices\nend_header\n";
  for (int k = 0; k < 9; ++k) ply += {static_cast<char>(k), static_cast<char>(k * k), '\0'};
  ply += {'\x70', '\x17'};  // 6000 corners
  for (int k = 0; k < 6000; ++k) ply += static_cast<char>(k % 9);
  check(ply, MeshFormat::ply, 0.9);
  CHECK(row_of(MeshFormat::gltf).most == nullptr);
}

TEST_CASE("peek_mesh: real files are estimated at 1 to 1.5 times the true size") {
  MEANDER_NEEDS_SHARED_DATA();
  std::size_t files = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(shared_data(""))) {
    MeshFormat format{};
    if (!entry.is_regular_file() || !mesh_format_of(entry.path(), format)) continue;
    const FileBytes file(entry.path());
    PolygonMesh mesh;
    try {
      mesh = read_mesh(file.bytes(), format);
    } catch (const ItemError&) {
      continue;
    }
    CAPTURE(entry.path().string());
    check_estimate(peek_mesh(entry.path(), format), truth_of(mesh), 1.5);
    ++files;
  }
  REQUIRE(files > 100);
}
