// Attributes and texture coordinates that readers take up only when they are asked to.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>

#include "gltf_reading.h"
#include "io/mesh/format_readers.h"
#include "support/gltf_files.h"
#include "support/gltf_streams.h"
#include "support/mesh_files.h"

using namespace meander;
using namespace meander::test;

namespace {

MeshSurroundings asking(bool coordinates, std::span<const AttributeColumn> names = {}) {
  MeshSurroundings around;
  around.extras = {coordinates, names};
  return around;
}

PolygonMesh read_obj_text(std::string_view text, const BlockRule& rule = BlockRule{},
                          bool coordinates = true) {
  return read_mesh_in_blocks(std::as_bytes(std::span(text.data(), text.size())), MeshFormat::obj, {}, rule,
                             asking(coordinates));
}

using Indices = std::vector<std::uint32_t>;
using Numbers = std::vector<double>;

// NaN equals NaN.
bool same_numbers(const Numbers& a, const Numbers& b) {
  if (a.size() != b.size()) return false;
  for (std::size_t i = 0; i < a.size(); ++i)
    if (!(std::isnan(a[i]) && std::isnan(b[i])) && a[i] != b[i]) return false;
  return true;
}

constexpr double hole = std::numeric_limits<double>::quiet_NaN();

// Two triangles with the attributes of their own that `attributes` names, each of three vertices.
std::string two_primitives(const GltfFile& file, const std::string& first, const std::string& second) {
  return file.glb(fmt::format(R"(,"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0{}}}}},)"
                              R"({{"attributes":{{"POSITION":1{}}}}}]}}],"nodes":[{{"mesh":0}}])",
                              first, second));
}

GltfFile two_triangles() {
  GltfFile file;
  file.add_points({0, 0, 0, 1, 0, 0, 0, 1, 0});
  file.add_points({0, 0, 1, 1, 0, 1, 0, 1, 1});
  return file;
}

const Numbers& asked(const PolygonMesh& mesh, const std::string& name) {
  for (const ScalarAttribute& attribute : mesh.asked_attributes)
    if (attribute.name == name) return attribute.values;
  static const Numbers none;
  return none;
}

}  // namespace

TEST_CASE("texture coordinates: OBJ, by corner, absolute and relative, in blocks of any size") {
  const std::string text =
      "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0.5\nvt 0.25\nf 1/1 2/2 3/3\nv 1 1 0\nvt 7 8 9\n"
      "f -1/-1 3/2 2\nf 1//1 2/99 3/x\nf 2 3 4\nvn 0 0 1\n";
  const PolygonMesh mesh = read_obj_text(text);
  CHECK(mesh.coordinates.values == std::vector<float>{0, 0, 1, .5f, .25f, 0, 7, 8});
  const Indices corners(mesh.coordinates.corner.begin(), mesh.coordinates.corner.begin() + 6);
  CHECK(corners == Indices{0, 1, 2, 3, 1, no_index});
  CHECK(mesh.coordinates.corner.size() == mesh.corners.size());
  for (std::size_t k = 6; k < mesh.coordinates.corner.size(); ++k)
    CHECK(mesh.coordinates.corner[k] == no_index);
  for (const std::size_t block : {1, 16, 40}) {
    const PolygonMesh parts = read_obj_text(text, BlockRule{1, block});
    CHECK(parts.coordinates.values == mesh.coordinates.values);
    CHECK(parts.coordinates.corner == mesh.coordinates.corner);
  }
  const PolygonMesh plain = read_obj_text(text, BlockRule{}, false);
  CHECK(plain.coordinates.corner.empty());
  CHECK(plain.corners == mesh.corners);
  CHECK(read_obj_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").coordinates.corner.empty());
}

TEST_CASE("texture coordinates: glTF, the first set of every primitive, also without a material") {
  GltfFile file = two_triangles();
  file.add_accessor(file.add_view(std::vector<float>{0, 0, 1, 0, 0, 1}), 5126, 3, "VEC2");
  file.add_accessor(file.add_view(std::vector<float>{9, 9, 8, 8, 7, 7}), 5126, 3, "VEC2");
  const PolygonMesh mesh = read_gltf_file(
      two_primitives(file, R"(,"TEXCOORD_0":2,"TEXCOORD_1":3)", R"(,"TEXCOORD_1":3)"), asking(true));
  CHECK(mesh.coordinates.values == std::vector<float>{0, 0, 1, 0, 0, 1});
  CHECK(mesh.coordinates.corner == Indices{0, 1, 2, no_index, no_index, no_index});
  CHECK(read_gltf_file(two_primitives(file, "", ""), asking(true)).coordinates.corner.empty());
  // Of another number of vertices, or another width: none.
  CHECK(read_gltf_file(two_primitives(file, R"(,"TEXCOORD_0":0)", ""), asking(true))
            .coordinates.corner.empty());
  CHECK(read_gltf_file(two_primitives(file, R"(,"TEXCOORD_0":77)", ""), asking(true))
            .coordinates.corner.empty());
}

TEST_CASE("attributes: glTF, those that are asked for, scalars and vectors") {
  GltfFile file = two_triangles();
  file.add_accessor(file.add_view(std::vector<float>{1, 2, 3}), 5126, 3, "SCALAR");
  file.add_accessor(file.add_view(std::vector<float>{1, 2, 3, 4, 5, 6}), 5126, 3, "VEC2");
  file.add_accessor(
      file.add_view(std::vector<std::uint8_t>{0, 0, 0, 0, 51, 0, 0, 0, 255, 0, 0, 0}, ",\"byteStride\":4"),
      5121, 3, "SCALAR", ",\"normalized\":true");
  file.add_accessor(file.add_view(std::vector<float>{1, 2}), 5126, 2, "SCALAR");
  const std::vector<AttributeColumn> names = {{"_HEAT", 1},   {"_FLOW", 2},    {"_SHORT", 1},
                                              {"_ABSENT", 1}, {"POSITION", 3}, {"_OTHER", 2}};
  const std::string text =
      two_primitives(file, R"(,"_HEAT":2,"_FLOW":3,"_OTHER":2,"_SHORT":5)", R"(,"_HEAT":4)");
  const PolygonMesh mesh = read_gltf_file(text, asking(false, names));
  CHECK(mesh.asked_attributes.size() == 3);
  CHECK(same_numbers(asked(mesh, "_HEAT"), {1, 2, 3, 0, .2, 1}));
  CHECK(same_numbers(asked(mesh, "_FLOW_0"), {1, 3, 5, hole, hole, hole}));
  CHECK(same_numbers(asked(mesh, "_FLOW_1"), {2, 4, 6, hole, hole, hole}));
  CHECK(mesh.vertex_attributes.empty());
  CHECK(read_gltf_file(text).asked_attributes.empty());
}

TEST_CASE("attributes and texture coordinates: glTF, of Draco streams") {
  const BentGrid grid(4);
  draco::TriangleSoupMeshBuilder builder;
  const auto faces = static_cast<int>(grid.indices.size() / 3);
  builder.Start(faces);
  using Kind = draco::GeometryAttribute;
  const int position = builder.AddAttribute(Kind::POSITION, 3, draco::DT_FLOAT32),
            coordinate = builder.AddAttribute(Kind::TEX_COORD, 2, draco::DT_FLOAT32),
            height = builder.AddAttribute(Kind::GENERIC, 1, draco::DT_FLOAT32);
  for (int f = 0; f < faces; ++f) {
    const auto at = [&](std::size_t k) {
      return grid.points.data() + 3 * grid.indices[3 * static_cast<std::size_t>(f) + k];
    };
    const draco::FaceIndex face(static_cast<std::uint32_t>(f));
    builder.SetAttributeValuesForFace(position, face, at(0), at(1), at(2));
    builder.SetAttributeValuesForFace(coordinate, face, at(0), at(1), at(2));
    builder.SetAttributeValuesForFace(height, face, at(0) + 2, at(1) + 2, at(2) + 2);
  }
  const std::unique_ptr<draco::Mesh> mesh = builder.Finalize();
  draco::ExpertEncoder encoder(*mesh);
  draco::EncoderBuffer buffer;
  REQUIRE(encoder.EncodeToBuffer(&buffer).ok());
  GltfFile file;
  file.add_view(std::string_view(buffer.data(), buffer.size()));
  const std::size_t vertices = grid.points.size() / 3;
  file.add_accessor(-1, 5126, vertices, "VEC3");
  file.add_accessor(-1, 5125, grid.indices.size(), "SCALAR");
  file.add_accessor(-1, 5126, vertices, "VEC2");
  file.add_accessor(-1, 5126, vertices, "SCALAR");
  const auto id = [&](int attribute) { return mesh->attribute(attribute)->unique_id(); };
  const std::string text = file.glb(fmt::format(
      R"(,"extensionsUsed":["KHR_draco_mesh_compression"],"meshes":[{{"primitives":[{{"attributes":)"
      R"({{"POSITION":0,"TEXCOORD_0":2,"_HEIGHT":3,"_LOST":3}},"indices":1,"extensions":)"
      R"({{"KHR_draco_mesh_compression":{{"bufferView":0,"attributes":)"
      R"({{"POSITION":{},"TEXCOORD_0":{},"_HEIGHT":{},"_LOST":77}}}}}}}}]}}],"nodes":[{{"mesh":0}}])",
      id(position), id(coordinate), id(height)));
  const std::vector<AttributeColumn> names = {{"_HEIGHT", 1}, {"_LOST", 1}};
  const PolygonMesh read = read_gltf_file(text, asking(true, names));
  REQUIRE(read.vertex_count() == vertices);
  CHECK(same_numbers(asked(read, "_HEIGHT"), read.z));
  CHECK(asked(read, "_LOST").empty());
  REQUIRE(read.coordinates.corner.size() == read.corners.size());
  for (std::size_t k = 0; k < read.corners.size(); ++k) {
    const std::size_t c = 2 * read.coordinates.corner[k];
    CHECK(read.coordinates.values[c] == static_cast<float>(read.x[read.corners[k]]));
    CHECK(read.coordinates.values[c + 1] == static_cast<float>(read.y[read.corners[k]]));
  }
  CHECK(read_gltf_file(text).asked_attributes.empty());
}

TEST_CASE("attributes: glTF, primitives that share positions keep values of their own") {
  GltfFile file;
  file.add_points({0, 0, 0, 1, 0, 0, 0, 1, 0});
  file.add_accessor(file.add_view(std::vector<float>{1, 2, 3}), 5126, 3, "SCALAR");
  file.add_accessor(file.add_view(std::vector<float>{4, 5, 6}), 5126, 3, "SCALAR");
  const std::string text = file.glb(
      R"(,"meshes":[{"primitives":[{"attributes":{"POSITION":0,"_A":1}},{"attributes":{"POSITION":0,"_A":2}},)"
      R"({"attributes":{"POSITION":0,"_A":1}}]}],"nodes":[{"mesh":0}])");
  const std::vector<AttributeColumn> names = {{"_A", 1}};
  const PolygonMesh mesh = read_gltf_file(text, asking(false, names));
  CHECK(same_numbers(asked(mesh, "_A"), {1, 2, 3, 4, 5, 6}));
  CHECK(mesh.corners == Indices{0, 1, 2, 3, 4, 5, 0, 1, 2});
  // What is asked for is reserved for before it is read.
  std::uint64_t stated = 0;
  MeshSurroundings around = asking(false, names);
  around.admit = [&](const MeshEstimate& needs) { stated = needs.vertices; };
  read_gltf_file(text, around);
  CHECK(stated == 6);
  around.extras = {};
  read_gltf_file(text, around);
  CHECK(stated == 3);
}
