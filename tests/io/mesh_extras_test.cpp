// Attributes and texture coordinates that readers take up only when they are asked to.
#include <fmt/format.h>

#include <cmath>

#include "gltf_reading.h"
#include "io/mesh/format_readers.h"
#include "io/mesh/peek_attributes.h"
#include "support/catch.h"
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

TEST_CASE("texture coordinates: OBJ per corner, absolute and relative, in blocks of any size") {
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

TEST_CASE("texture coordinates: glTF uses the first set of every primitive, with or without a material") {
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

TEST_CASE("attributes: glTF scalars and vectors that are requested are read") {
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

TEST_CASE("attributes and texture coordinates: glTF Draco streams are read") {
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

TEST_CASE("attributes: glTF primitives that share positions keep their own values") {
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

namespace {

PolygonMesh read_obj_numbers(std::string_view text, std::span<const AttributeColumn> names,
                             const BlockRule& rule = BlockRule{}, bool colors = false) {
  MeshSurroundings around = asking(false, names);
  around.colors = colors;
  return read_mesh_in_blocks(std::as_bytes(std::span(text.data(), text.size())), MeshFormat::obj, {}, rule,
                             around);
}

const std::vector<AttributeColumn> all_numbers = {{"group", 1}, {"material", 1}, {"object", 1}, {"part", 1}};

Numbers of_faces(const PolygonMesh& mesh, const std::string& name) {
  for (const ScalarAttribute& attribute : mesh.asked_face_attributes)
    if (attribute.name == name && attribute.integers) return attribute.values;
  return {};
}

}  // namespace

TEST_CASE("face numbers: OBJ objects, groups and materials in the order of their first face") {
  const std::string text =
      "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"
      "f 1 2 3\n"  // of no object, no material, the group `default`
      "o unused\no  seat \t\r\ng  left   top\t\nusemtl Red\nf 1 2 4\nf 1 3 4\n"
      "o leg\nusemtl \"a b\"\ng\nf 2 3 4\n"
      "g left top\nO seat\nf 1 2 3\nusemtl Red\no\nG top left\nf 1 2 3\nobject x\ngroup y\no end\n";
  const PolygonMesh mesh = read_obj_numbers(text, all_numbers);
  CHECK(mesh.asked_face_attributes.size() == 3);
  CHECK(same_numbers(of_faces(mesh, "object"), {hole, 0, 0, 1, 0, 2}));
  CHECK(same_numbers(of_faces(mesh, "group"), {0, 1, 1, 0, 1, 2}));
  CHECK(same_numbers(of_faces(mesh, "material"), {hole, 0, 0, 1, 1, 0}));
  CHECK(mesh.names == R"({"group":["default","left top","top left"],"material":["Red","\"a b\""],)"
                      R"("object":["seat","leg",""]})");
  CHECK_FALSE(mesh.notes.any());
  CHECK((mesh.face_attributes.empty() && mesh.asked_attributes.empty()));
  for (const std::size_t block : {1, 16, 40, 100}) {
    const PolygonMesh parts = read_obj_numbers(text, all_numbers, BlockRule{1, block});
    CHECK(parts.names == mesh.names);
    for (const char* name : {"group", "material", "object"})
      CHECK(same_numbers(of_faces(parts, name), of_faces(mesh, name)));
    CHECK(parts.corners == mesh.corners);
  }
  // What is not asked for is not there, and a vector is none of these.
  const PolygonMesh one = read_obj_numbers(text, std::vector<AttributeColumn>{{"group", 2}, {"object", 1}});
  CHECK(one.asked_face_attributes.size() == 1);
  CHECK(one.names == R"({"object":["seat","leg",""]})");
  const PolygonMesh none = read_obj_numbers(text, {});
  CHECK((none.asked_face_attributes.empty() && none.names.empty()));
  const PolygonMesh colored = read_obj_numbers(text, all_numbers, BlockRule{}, true);
  CHECK(colored.names == mesh.names);
}

TEST_CASE("face numbers: OBJ files without names, or without named faces, have none") {
  const std::string corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  for (const std::string& text : {corners + "f 1 2 3\n", corners + "f 1 2 3\no late\nusemtl late\n"}) {
    const PolygonMesh mesh = read_obj_numbers(text, all_numbers);
    CHECK((mesh.asked_face_attributes.empty() && mesh.names.empty()));
  }
  // A face that cannot be read keeps its number.
  const PolygonMesh bad = read_obj_numbers(corners + "o a\nf 1 2 x\no b\nf 1 2 3\n", all_numbers);
  CHECK(same_numbers(of_faces(bad, "object"), {0, 1}));
}

TEST_CASE("face numbers: names are bounded valid UTF-8, and omitted ones are noted") {
  std::string text = "v 0 0 0\nv 1 0 0\nv 0 1 0\no caf\xE9\x01\nf 1 2 3\no 100%\nf 1 2 3\n";
  CHECK(read_obj_numbers(text, all_numbers).names == R"({"object":["caf%E9%01","100%"]})");
  for (int i = 0; i < 3000; ++i) text += fmt::format("o {:0100}\ng {}\nf 1 2 3\n", i, i % 7);
  const PolygonMesh mesh = read_obj_numbers(text, all_numbers);
  CHECK(mesh.names.size() <= most_name_bytes);
  CHECK(mesh.names.size() > most_name_bytes - 200);
  CHECK(mesh.notes[Note::names_dropped] > 2000);
  CHECK(mesh.notes.examples[static_cast<std::size_t>(Note::names_dropped)].find("3002 names of `object`") !=
        std::string::npos);
  CHECK(of_faces(mesh, "object").back() == 3001);
  // One that alone is too long, in front: none of its attribute, all of the others.
  const PolygonMesh huge = read_obj_numbers(
      "v 0 0 0\nv 1 0 0\nv 0 1 0\ng " + std::string(70000, 'x') + "\no a\nf 1 2 3\n", all_numbers);
  CHECK(huge.names == R"({"object":["a"]})");
  CHECK(huge.notes[Note::names_dropped] == 1);
  CHECK(of_faces(huge, "group") == Numbers{0});
}

TEST_CASE("face numbers: glTF nodes, materials and parts with their names") {
  GltfFile file;
  file.add_points({0, 0, 0, 1, 0, 0, 0, 1, 0});
  const std::string text =
      file.glb(R"(,"materials":[{"name":"unused"},{"name":"wood"},{}],)"
               R"("meshes":[{"name":"board","primitives":[{"attributes":{"POSITION":0},"material":1},)"
               R"({"attributes":{"POSITION":0},"mode":0},{"attributes":{"POSITION":0}}]},)"
               R"({"primitives":[{"attributes":{"POSITION":0},"material":2}]}],)"
               R"("nodes":[{"name":"leg","mesh":1},{"mesh":0},{"name":"seat","mesh":0,"children":[0]}],)"
               R"("scenes":[{"nodes":[2,1]}],"scene":0)");
  const PolygonMesh mesh = read_gltf_file(text, asking(false, all_numbers));
  REQUIRE(mesh.polygon_count() == 5);
  REQUIRE(mesh.face_attributes.size() == 1);
  CHECK(mesh.face_attributes[0].values == Numbers{0, 2, 3, 4, 6});
  CHECK(mesh.face_attributes[0].integers);
  CHECK(mesh.asked_face_attributes.size() == 2);
  CHECK(same_numbers(of_faces(mesh, "object"), {0, 0, 1, 2, 2}));
  CHECK(same_numbers(of_faces(mesh, "material"), {0, hole, 1, 0, hole}));
  CHECK(mesh.names == R"({"material":["wood",""],"object":["seat","leg","board"],)"
                      R"("part":["seat","seat","seat","leg","board","board","board"]})");
  const PolygonMesh plain = read_gltf_file(text);
  CHECK((plain.asked_face_attributes.empty() && plain.names.empty()));
  CHECK(plain.corners == mesh.corners);
  const PolygonMesh part = read_gltf_file(text, asking(false, std::vector<AttributeColumn>{{"part", 1}}));
  CHECK((part.asked_face_attributes.empty() && part.names.starts_with(R"({"part":["seat",)")));
  // Without nodes a mesh stands for itself.
  const PolygonMesh bare =
      read_gltf_file(file.glb(R"(,"meshes":[{"name":"only","primitives":[{"attributes":{"POSITION":0}}]}])"),
                     asking(false, all_numbers));
  CHECK(bare.names == R"({"part":["only"]})");
  // A long name of many parts, which nodes without a name have from their mesh.
  const std::size_t copies = 1000;
  std::string nodes = R"({"mesh":0})";
  for (std::size_t i = 1; i < copies; ++i) nodes += R"(,{"mesh":0})";
  std::uint64_t stated = 0;
  MeshSurroundings around = asking(false, all_numbers);
  around.admit = [&](const MeshEstimate& needs) { stated = needs.decoding_bytes; };
  const std::string many =
      file.glb(fmt::format(R"(,"meshes":[{{"name":"{}","primitives":[{{"attributes":{{"POSITION":0}}}}]}}],)"
                           R"("nodes":[{}])",
                           std::string(1 << 20, 'x'), nodes));
  const PolygonMesh crowd = read_gltf_file(many, around);
  CHECK(crowd.names.empty());
  CHECK(crowd.notes[Note::names_dropped] == 2 * copies);
  CHECK(of_faces(crowd, "object").back() == copies - 1);
  // The list of parts is reserved for where it is needed.
  const std::uint64_t with_parts = stated;
  around.extras = {};
  read_gltf_file(many, around);
  CHECK(with_parts == stated + 12 * copies);
}

TEST_CASE("attributes: integer declarations are found, in headers too") {
  const std::string ply =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
      "property ushort label\nproperty double heat\nproperty float nx\nelement face 1\n"
      "property list uchar int vertex_indices\nproperty char kind\nproperty float label\nend_header\n"
      "0 0 0 1 2 3\n1 0 0 1 2 3\n0 1 0 1 2 3\n3 0 1 2 4 5\n";
  const PolygonMesh mesh = read_mesh(std::as_bytes(std::span(ply.data(), ply.size())), MeshFormat::ply);
  REQUIRE(mesh.vertex_attributes.size() == 3);
  REQUIRE(mesh.face_attributes.size() == 2);
  CHECK((mesh.vertex_attributes[0].integers && !mesh.vertex_attributes[1].integers));
  CHECK((mesh.face_attributes[0].integers && !mesh.face_attributes[1].integers));
  const std::vector<FileAttribute> peeked = peek_attributes(MemorySource(ply), MeshFormat::ply);
  REQUIRE(peeked.size() == 5);
  CHECK((peeked[2].name == "nx" && !peeked[2].of_faces && peeked[3].name == "kind" && peeked[3].of_faces));
  CHECK(takes_integers(peeked, {"label", 1}) == true);
  CHECK(takes_integers(peeked, {"heat", 1}) == false);
  CHECK(takes_integers(peeked, {"kind", 1}) == true);
  CHECK_FALSE(takes_integers(peeked, {"kind", 2}).has_value());
  CHECK_FALSE(takes_integers(peeked, {"x", 1}).has_value());
  CHECK(peek_attributes(MemorySource("\xEF\xBB\xBF" + ply), MeshFormat::ply).size() == 5);
  for (const char* text : {"", "ply\n", "OFF\n"})
    for (const MeshFormat format : {MeshFormat::ply, MeshFormat::gltf, MeshFormat::off, MeshFormat::stl})
      CHECK(peek_attributes(MemorySource(text), format).empty());
  CHECK(takes_integers(peek_attributes(MemorySource(""), MeshFormat::obj), {"object", 1}) == true);

  GltfFile file = two_triangles();
  file.add_accessor(file.add_view(std::vector<std::uint16_t>{1, 0, 2, 0, 3, 0}, ",\"byteStride\":4"), 5123, 3,
                    "SCALAR");
  file.add_accessor(file.add_view(std::vector<float>{1, 2, 3}), 5126, 3, "SCALAR");
  file.add_accessor(
      file.add_view(std::vector<std::uint8_t>{1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3, 0}, ",\"byteStride\":4"), 5121,
      3, "VEC3");
  file.add_accessor(
      file.add_view(std::vector<std::uint8_t>{1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, ",\"byteStride\":4"), 5121,
      3, "SCALAR", ",\"normalized\":true");
  const std::string text = two_primitives(file, R"(,"_A":2,"_B":2,"_V":4,"_N":5)", R"(,"_A":2,"_B":3)");
  const std::vector<AttributeColumn> names = {{"_A", 1}, {"_B", 1}, {"_N", 1}, {"_V", 3}};
  const PolygonMesh read = read_gltf_file(text, asking(false, names));
  const std::vector<FileAttribute> header = peek_attributes(MemorySource(text), MeshFormat::gltf);
  for (const auto& [name, integers] : std::vector<std::pair<std::string, bool>>{
           {"_A", true}, {"_B", false}, {"_N", false}, {"_V_0", true}, {"_V_2", true}}) {
    INFO(name);
    const auto at =
        std::find_if(read.asked_attributes.begin(), read.asked_attributes.end(),
                     [&wanted = name](const ScalarAttribute& attribute) { return attribute.name == wanted; });
    REQUIRE(at != read.asked_attributes.end());
    CHECK(at->integers == integers);
    if (name.size() == 2) CHECK(takes_integers(header, {name, 1}) == integers);
  }
  CHECK(takes_integers(header, {"_V", 3}) == true);
  CHECK(takes_integers(header, {"part", 1}) == true);
  CHECK_FALSE(takes_integers(header, {"POSITION", 3}).has_value());
}
