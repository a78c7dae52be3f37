// Colors of vertices, faces and materials, as files of every format give them.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <functional>

#include "gltf_reading.h"
#include "io/archive/model_bytes.h"
#include "io/mesh/format_readers.h"
#include "io/mesh/mtl_reader.h"
#include "io/mesh/ply_header.h"
#include "kernels/mesh/surface_textures.h"
#include "support/catch.h"
#include "support/mesh_files.h"

using namespace meander;
using namespace meander::test;

namespace {

using Values = std::vector<float>;

PolygonMesh read_text(std::string_view text, MeshFormat format, bool colors = true,
                      const BlockRule& rule = BlockRule{}, std::span<const CompanionFile> companions = {}) {
  MeshSurroundings around;
  around.colors = colors;
  around.companions = companions;
  return read_mesh_in_blocks(std::as_bytes(std::span(text.data(), text.size())), format, {}, rule, around);
}

// NaN equals NaN.
bool same(const Values& a, const Values& b) {
  if (a.size() != b.size()) return false;
  for (std::size_t i = 0; i < a.size(); ++i)
    if (!(std::isnan(a[i]) && std::isnan(b[i])) && std::abs(a[i] - b[i]) > 1e-6f) return false;
  return true;
}

constexpr float none = std::numeric_limits<float>::quiet_NaN();

CompanionFile library(std::string_view text, std::string problem = {}) {
  const auto loss = problem.empty() ? CompanionFile::Loss::none : CompanionFile::Loss::missing;
  return {"m.mtl", std::as_bytes(std::span(text.data(), text.size())), std::move(problem), false, loss};
}

}  // namespace

TEST_CASE("colors: PLY bytes and fractions, per vertex and per face") {
  const auto ply = [](const char* type, const char* names, const char* rows) {
    return fmt::format(
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n{}"
        "element face 1\nproperty list uchar int vertex_indices\nproperty {} red\nproperty {} green\n"
        "property {} blue\nend_header\n{}",
        names, type, type, type, rows);
  };
  const std::string of_vertices = "property uchar red\nproperty uchar green\nproperty uchar blue\n";
  const std::string text =
      ply("float", of_vertices.c_str(), "0 0 0 255 0 51\n1 0 0 0 255 0\n0 1 0 1 0 0\n3 0 1 2 0.5 0.25 1\n");
  const PolygonMesh mesh = read_text(text, MeshFormat::ply);
  CHECK(same(mesh.colors.vertex, {1, 0, .2f, 0, 1, 0, 1 / 255.f, 0, 0}));
  CHECK(same(mesh.colors.face, {.5f, .25f, 1}));
  CHECK_FALSE(mesh.colors.linear);
  const PolygonMesh plain = read_text(text, MeshFormat::ply, false);
  CHECK(plain.colors.vertex.empty());
  CHECK(plain.colors.face.empty());
  // Floating-point values up to 255, and a vertex whose color cannot be read.
  const std::string of_floats = "property float red\nproperty float green\nproperty float blue\n";
  const PolygonMesh large = read_text(
      ply("float", of_floats.c_str(), "0 0 0 255 0 51\n1 0 0 x 255 0\n0 1 0 0 0 0\n3 0 1 2 0 0 1\n"),
      MeshFormat::ply);
  CHECK(same(large.colors.vertex, {1, 0, .2f, none, 1, 0, 0, 0, 0}));
  CHECK(same(large.colors.face, {0, 0, 1}));
}

TEST_CASE("colors: OFF per vertex, per face, and rows without colors") {
  const PolygonMesh mesh = read_text(
      "COFF\n4 3 0\n0 0 0 255 0 51 255\n1 0 0 0 255 0 255\n0 1 0 0 0 255 255\n1 1 0\n3 0 1 2 0.5 0.25 1\n"
      "3 0 1 2 7\n3 1 2 3\n",
      MeshFormat::off);
  CHECK(same(mesh.colors.vertex, {1, 0, .2f, 0, 1, 0, 0, 0, 1, none, none, none}));
  CHECK(same(mesh.colors.face, {.5f, .25f, 1, none, none, none, none, none, none}));
  CHECK(mesh.polygon_count() == 3);
  const PolygonMesh plain = read_text("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", MeshFormat::off);
  CHECK(plain.colors.vertex.empty());
  CHECK(plain.colors.face.empty());
}

TEST_CASE("colors: binary OFF per vertex and per face, in both byte orders") {
  for (const bool swapped : {false, true}) {
    std::string text = "CNOFF BINARY\n";
    const auto put = [&](auto value) {
      static_assert(sizeof value == 4);
      char bytes[4];
      std::memcpy(bytes, &value, 4);
      if (swapped) std::reverse(bytes, bytes + 4);
      text.append(bytes, 4);
    };
    for (const std::int32_t count : {3, 4, 0}) put(count);
    for (const std::array<float, 3>& color :
         {std::array{1.f, 0.f, .25f}, {0.f, .5f, 0.f}, {none, 1.f, 0.f}}) {
      for (const float value : {color[1], color[0], color[2], 0.f, 0.f, 1.f}) put(value);  // position, normal
      for (const float value : color) put(value);
      put(1.f);
    }
    const auto face = [&](std::initializer_list<float> color) {
      for (const std::int32_t word : {3, 0, 1, 2, static_cast<int>(color.size())}) put(word);
      for (const float value : color) put(value);
    };
    face({.5f, .25f, 1});
    face({});
    face({1, 0, .75f, .5f});
    face({7});  // an index into a map of colors
    const PolygonMesh mesh = read_text(text, MeshFormat::off);
    CHECK(same(mesh.colors.vertex, {1, 0, .25f, 0, .5f, 0, none, 1, 0}));
    CHECK(same(mesh.colors.face, {.5f, .25f, 1, none, none, none, 1, 0, .75f, none, none, none}));
    CHECK(mesh.polygon_count() == 4);
    CHECK(mesh.repairs[Repair::extra_data] == 0);
    CHECK(mesh.normals.size() == 9);
    const PolygonMesh plain = read_text(text, MeshFormat::off, false);
    CHECK(plain.colors.vertex.empty());
    CHECK(plain.x == mesh.x);
    CHECK(plain.corners == mesh.corners);
    // Cut in the last color, the faces before it stay as they are.
    const PolygonMesh cut = read_text(std::string_view(text).substr(0, text.size() - 4), MeshFormat::off);
    CHECK(cut.polygon_count() == 4);
    CHECK(cut.colors.face.size() == 12);
  }
}

TEST_CASE("colors: components are clamped to 0 to 1, and infinite ones are missing") {
  const PolygonMesh off =
      read_text("COFF\n3 1 0\n0 0 0 300 -5 51\n1 0 0 inf 255 0\n0 1 0 0 1e400 102\n3 0 1 2 -1 0.5 1\n",
                MeshFormat::off);
  CHECK(same(off.colors.vertex, {1, 0, .2f, none, 1, 0, 0, none, .4f}));
  CHECK(same(off.colors.face, {0, .5f, 1}));
  const std::vector<CompanionFile> libraries = {library("newmtl a\nKd 2 -1 nan\n")};
  const PolygonMesh obj =
      read_text("mtllib m.mtl\nv 0 0 0 inf 0.5 0\nv 1 0 0 0 0 0\nv 0 1 0 1 1 1\nusemtl a\nf 1 2 3\n",
                MeshFormat::obj, true, BlockRule{}, libraries);
  CHECK(same(obj.colors.vertex, {none, .5f, 0, 0, 0, 0, 1, 1, 1}));
  CHECK(same(obj.colors.face, {1, 0, none}));
}

TEST_CASE("colors: large OFF and OBJ files give the same colors in blocks and in order") {
  std::string off = "COFF\n2000 1000 0\n", obj = "mtllib m.mtl\n";
  for (int v = 0; v < 2000; ++v) {
    off += fmt::format("{} {} 0 {} {} 7 255\n", v, v % 7, v % 256, v % 200);
    obj += fmt::format("v {} {} 0 {} 0.5 0\n", v, v % 7, v % 2);
  }
  for (int f = 0; f < 1000; ++f) {
    off += fmt::format("3 {} {} {} {} 3 9\n", f, f + 1, f + 2, f % 256);
    if (f % 100 == 50) obj += fmt::format("usemtl {}\n", f % 200 == 50 ? "red" : "green");
    obj += fmt::format("f {} {} {}\n", f + 1, f + 2, f + 3);
  }
  const std::vector<CompanionFile> libraries = {library("newmtl red\nKd 1 0 0\nnewmtl green\nKd 0 1 0\n")};
  BlockRule small;
  small.parallel_from = 1;
  small.block_bytes = 500;
  for (const MeshFormat format : {MeshFormat::off, MeshFormat::obj}) {
    const std::string& text = format == MeshFormat::off ? off : obj;
    const PolygonMesh whole = read_text(text, format, true, BlockRule{}, libraries);
    const PolygonMesh blocks = read_text(text, format, true, small, libraries);
    REQUIRE(whole.colors.vertex.size() == 6000);
    REQUIRE(whole.colors.face.size() == 3000);
    CHECK(same(whole.colors.vertex, blocks.colors.vertex));
    CHECK(same(whole.colors.face, blocks.colors.face));
  }
  const PolygonMesh mesh = read_text(obj, MeshFormat::obj, true, small, libraries);
  CHECK(std::isnan(mesh.colors.face[3 * 49]));
  CHECK(mesh.colors.face[3 * 50] == 1);
  CHECK(mesh.colors.face[3 * 149] == 1);
  CHECK(mesh.colors.face[3 * 150] == 0);
  CHECK(mesh.colors.face[3 * 150 + 1] == 1);
}

TEST_CASE("colors: OBJ vertices with zero, one, three or four numbers after the position") {
  const PolygonMesh mesh = read_text(
      "v 0 0 0 1 0 0.5\nv 1 0 0 0 1 0 1\nv 0 1 0 1.0\nv 1 1 0 # 1 2 3\nf 1 2 3\nf 2 3 4\n", MeshFormat::obj);
  CHECK(same(mesh.colors.vertex, {1, 0, .5f, 0, 1, 0, none, none, none, none, none, none}));
  CHECK(mesh.vertex_count() == 4);
  CHECK(read_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", MeshFormat::obj).colors.vertex.empty());
}

TEST_CASE("colors: OBJ #MRGB comments give one color per vertex") {
  const std::string vertices = "v 0 0 0\nv 1 0 0\nv 0 1 0\n", face = "f 1 2 3\n";
  const Values expected = {1, 0, 0, 0, 1, 0, 0, 0, 51 / 255.f};
  const std::string red = "ffFF0000", green = "ff00ff00", blue = "00000033";
  for (const std::string& painted :
       {"#MRGB " + red + green + blue + "\n", "#MRGB " + red + "\r\n#MRGB " + green + blue + " \n"})
    CHECK(same(read_text(vertices + painted + face, MeshFormat::obj).colors.vertex, expected));
  // In blocks of few bytes, too.
  CHECK(same(read_text(vertices + "#MRGB " + red + "\n#MRGB " + green + "\n#MRGB " + blue + "\n" + face,
                       MeshFormat::obj, true, BlockRule{1, 16})
                 .colors.vertex,
             expected));
  CHECK(read_text(vertices + "#MRGB " + red + "\n" + face, MeshFormat::obj, false).colors.vertex.empty());
  const PolygonMesh fewer = read_text(vertices + "#MRGB " + red + green + "\n" + face, MeshFormat::obj);
  CHECK(fewer.colors.vertex.empty());
  CHECK(fewer.notes[Note::colors_ignored] == 1);
  const PolygonMesh inline_colors =
      read_text("v 0 0 0 1 1 1\nv 1 0 0 1 1 1\nv 0 1 0 1 1 1\n#MRGB " + red + green + blue + "\n" + face,
                MeshFormat::obj);
  CHECK(same(inline_colors.colors.vertex, {1, 1, 1, 1, 1, 1, 1, 1, 1}));
}

TEST_CASE("colors: comments and options next to material and image names are parsed") {
  const std::string text =
      "newmtl red\nmap_Kd tex #1.png # inline\nnewmtl Material #25\nmap_Kd tex.png -s 2 3 -bm 1\n"
      "newmtl c\nmap_Kd -colorspace sRGB -s 4 my -s tex.png\nnewmtl d\nmap_Kd sub\\my\\ tex.png\nnewmtl "
      "e\nmap_Kd a #b\n";
  const CompanionFile file = library(text);
  const MtlMaterials materials = read_materials(std::span(&file, 1));
  CHECK(materials.find("red")->image == "tex #1.png");
  CHECK(materials.find("red # a comment")->image == "tex #1.png");
  CHECK(materials.find("Material #25")->image == "tex.png");
  CHECK(materials.find("Material #25 # a # b")->image == "tex.png");
  CHECK(materials.find("Material #25")->texture.placement[0] == 2);
  CHECK(materials.find("Material #25")->texture.placement[4] == -3);
  CHECK(materials.find("c")->image == "my -s tex.png");
  CHECK(materials.find("c")->texture.placement[0] == 4);
  CHECK(materials.find("d")->image == "sub/my tex.png");
  CHECK(materials.find("e")->image == "a #b");
  CHECK(materials.find("Material") == nullptr);
  CHECK(materials.find("red#") == nullptr);
  const std::string obj = "mtllib none.mtl not\\ there.mtl my own.mtl\n";
  CHECK(row_of(MeshFormat::obj).color_companions(std::as_bytes(std::span(obj.data(), obj.size()))) ==
        std::vector<std::string>{"none.mtl", "not there.mtl", "my own.mtl"});
}

TEST_CASE("colors: PLY materials are referenced by faces by number") {
  const auto file = [](const char* rows) {
    return std::string(
               "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float "
               "z\n"
               "element face 2\nproperty list uchar int vertex_indices\nproperty int material_index\n"
               "element material 2\nproperty uchar ambient_red\nproperty uchar diffuse_red\nproperty uchar "
               "diffuse_green\nproperty uchar diffuse_blue\nend_header\n0 0 0\n1 0 0\n0 1 0\n") +
           rows + "9 255 0 0\n9 0 0 51\n";
  };
  const PolygonMesh mesh = read_text(file("3 0 1 2 1\n3 0 2 1 0\n"), MeshFormat::ply);
  CHECK(same(mesh.colors.face, {0, 0, .2f, 1, 0, 0}));
  CHECK_FALSE(mesh.notes.any());
  const PolygonMesh wrong = read_text(file("3 0 1 2 2\n3 0 2 1 0\n"), MeshFormat::ply);
  CHECK(same(wrong.colors.face, {none, none, none, 1, 0, 0}));
  CHECK(wrong.notes[Note::material_missing] == 1);
  CHECK(read_text(file("3 0 1 2 1\n3 0 2 1 0\n"), MeshFormat::ply, false).colors.face.empty());
}

TEST_CASE("colors: OBJ materials that are repeated, without a Kd, or unknown") {
  const std::string text =
      "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nusemtl a b\nf 1 2 3\nusemtl gray\r\nf 1 2 3\nusemtl dull\nf 1 2 "
      "3\n"
      "usemtl spectral\nf 1 2 3\nusemtl missing\nf 1 2 3\n";
  const std::vector<CompanionFile> libraries = {
      library("newmtl a b \n  Kd 1 0.5 0\nnewmtl gray\nKd 0.25\nnewmtl dull\nKa 1 1 1\nnewmtl spectral\n"
              "Kd spectral x.rfl 1\n"),
      library("newmtl other\nKd 1 1 1\n", "no such file"), library("newmtl gray\nKd 1 1 1\n")};
  const PolygonMesh mesh = read_text(text, MeshFormat::obj, true, BlockRule{}, libraries);
  CHECK(mesh.colors.of_materials);
  CHECK(same(mesh.colors.face, {none, none, none, 1, .5f, 0, .25f, .25f, .25f, none, none, none, none, none,
                                none, none, none, none}));
}

TEST_CASE("colors: OBJ material libraries, absolute paths by their file name alone") {
  const std::string text =
      "mtllib a.mtl b.mtl\n# mtllib no.mtl\nmtllib two words.mtl\r\nmtllib tex\\c.MTL ./a.mtl\nmtllib "
      "../up.mtl\n"
      "mtllib /etc/passwd\nmtllib\nv 0 0 0\nmtllib last.mtl";
  CHECK(row_of(MeshFormat::obj).color_companions(std::as_bytes(std::span(text.data(), text.size()))) ==
        std::vector<std::string>{"a.mtl", "b.mtl", "two words.mtl", "tex/c.MTL", "../up.mtl", "passwd",
                                 "last.mtl"});
  CHECK(row_of(MeshFormat::off).color_companions == nullptr);
}

TEST_CASE("colors: ModelBytes hashes an OBJ file apart from its materials") {
  const ScratchFolder scratch;
  write_file(scratch / "a.obj", "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m\nf 1 2 3\n");
  const auto hashes = [&](bool colors) {
    const ModelBytes file({scratch / "a.obj", {}, MeshFormat::obj}, ~std::uint64_t{0}, colors);
    return std::pair(file.content_sha256(), file.color_sha256());
  };
  const auto plain = hashes(false), without = hashes(true);
  CHECK(plain.second == std::array<std::uint8_t, 32>{});
  write_file(scratch / "a.mtl", "newmtl m\nKd 1 0 0\n");
  const auto red = hashes(true);
  write_file(scratch / "a.mtl", "newmtl m\nKd 0 0 1\n");
  const auto blue = hashes(true);
  CHECK(without.first == plain.first);
  CHECK(red.first == plain.first);
  CHECK(red.second != without.second);
  CHECK(red.second != blue.second);
  const ModelBytes file({scratch / "a.obj", {}, MeshFormat::obj}, ~std::uint64_t{0}, true);
  CHECK(same(file.mesh().colors.face, {0, 0, 1}));
}

TEST_CASE("colors: glTF materials and COLOR_0 are read, and invalid ones do not fail the model") {
  GltfFile file = cube_file();
  std::vector<std::uint8_t> values;
  for (int v = 0; v < 8; ++v)
    for (int k = 0; k < 4; ++k) values.push_back(static_cast<std::uint8_t>(k == 0 ? 255 : k == 1 ? 51 : 0));
  file.add_accessor(file.add_view(values), 5121, 8, "VEC4", ",\"normalized\":true");
  const auto read = [&](const std::string& primitive, const std::string& materials) {
    const std::string bytes = file.glb(R"(,"meshes":[{"primitives":[{"attributes":{"POSITION":0)" +
                                       primitive + R"(}]}],"nodes":[{"mesh":0}])" + materials);
    return read_text(bytes, MeshFormat::gltf);
  };
  const std::string blue =
      R"(,"materials":[{"pbrMetallicRoughness":{"baseColorFactor":[0.5,0,1,1]}},{"name":"white"},7])";
  PolygonMesh mesh = read(R"(,"COLOR_0":2},"indices":1,"material":0)", blue);
  CHECK(mesh.colors.linear);
  REQUIRE(mesh.colors.vertex.size() == 24);
  CHECK(same(Values(mesh.colors.vertex.begin(), mesh.colors.vertex.begin() + 3), {1, .2f, 0}));
  REQUIRE(mesh.colors.face.size() == 36);
  CHECK(same(Values(mesh.colors.face.begin(), mesh.colors.face.begin() + 3), {.5f, 0, 1}));
  mesh = read(R"(},"indices":1,"material":1)", blue);
  CHECK(std::isnan(mesh.colors.vertex[0]));
  CHECK(same(Values(mesh.colors.face.begin(), mesh.colors.face.begin() + 3), {1, 1, 1}));
  // Accessors and materials that are not there, and a color with as many values as there are indices.
  for (const char* primitive :
       {R"(,"COLOR_0":9},"indices":1,"material":9)", R"(,"COLOR_0":"x"},"indices":1,"material":"y")",
        R"(,"COLOR_0":1},"indices":1)"}) {
    mesh = read(primitive, blue);
    INFO(primitive);
    CHECK(mesh.polygon_count() == 12);
    CHECK(std::isnan(mesh.colors.vertex[0]));
    CHECK(std::isnan(mesh.colors.face[0]));
  }
}

TEST_CASE("colors: integer types are divided by 255, real types are fractions, and both are clamped") {
  const auto vertices = [](const char* type, const std::vector<std::string>& rows) {
    std::string text = fmt::format(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n"
        "property {} red\nproperty {} green\nproperty {} blue\nelement face 1\nproperty list uchar int "
        "vertex_indices\nend_header\n",
        rows.size(), type, type, type);
    for (std::size_t v = 0; v < rows.size(); ++v) text += fmt::format("{} {} 0 {}\n", v, v * v, rows[v]);
    return read_text(text + "3 0 1 2\n", MeshFormat::ply).colors.vertex;
  };
  constexpr float byte = 1 / 255.f;
  for (const char* const type : {"uchar", "ushort", "int", "uint", "short", "int8", "uint16"})
    CHECK(same(vertices(type, {"1 0 1", "1 0 1", "1 0 1"}), {byte, 0, byte, byte, 0, byte, byte, 0, byte}));
  CHECK(same(vertices("ushort", {"256 0 0", "65535 0 0", "0 0 0"}), {256 / 65535.f, 0, 0, 1, 0, 0, 0, 0, 0}));
  CHECK(same(vertices("char", {"-1 127 -128", "0 0 0", "0 0 0"}),
             {1, 127 * byte, 128 * byte, 0, 0, 0, 0, 0, 0}));
  for (const char* const type : {"float", "double"}) {
    // One ulp or a highlight above 1 among others.
    CHECK(same(vertices(type, {"1.0000001 .5 .25", "1 .5 .25", "1.5 .5 .25"}),
               {1, .5f, .25f, 1, .5f, .25f, 1, .5f, .25f}));
    CHECK(same(vertices(type, {"255 0 51", "0 0 0", "102 1 0"}), {1, 0, .2f, 0, 0, 0, .4f, byte, 0}));
    CHECK(same(vertices(type, {"0 0 0", "0 0 0", "0 0 0"}), Values(9, 0)));
  }
}

TEST_CASE("colors: OFF face colors are bytes if every number of the file is an integer") {
  const auto faces = [](const std::string& first, const std::string& second) {
    const PolygonMesh mesh =
        read_text("OFF\n4 2 0\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n3 0 1 2 " + first + "\n3 1 3 2 " + second + "\n",
                  MeshFormat::off);
    return std::pair(mesh.colors.face, mesh.notes[Note::color_map_ignored]);
  };
  constexpr float byte = 1 / 255.f;
  CHECK(same(faces("1 1 1", "0 1 0").first, {byte, byte, byte, 0, byte, 0}));
  CHECK(same(faces("255 0 51 255", "0 1 0 255").first, {1, 0, .2f, 0, byte, 0}));
  CHECK(same(faces("1 1 1", "0 1.0 0").first, {1, 1, 1, 0, 1, 0}));
  CHECK(same(faces("1 1 1 0.5", "0 1 0 1").first, {1, 1, 1, 0, 1, 0}));
  CHECK(same(faces("1e0 0 0", "0 1 0").first, {1, 0, 0, 0, 1, 0}));
  CHECK(same(faces("1.0000001 0 0", "0 0.5 0").first, {1, 0, 0, 0, .5f, 0}));
  // One number is an entry of a color map.
  CHECK(faces("5", "7").first.empty());
  CHECK(faces("5", "7").second == 2);
  CHECK(faces("5", "255 0 0").second == 1);
}

TEST_CASE("colors: OBJ and OFF vertex colors are fractions unless most numbers exceed 1") {
  const auto obj = [](const std::string& a, const std::string& b) {
    return read_text("v 0 0 0 " + a + "\nv 1 0 0 " + b + "\nv 0 1 0 0 0 0\nf 1 2 3\n", MeshFormat::obj)
        .colors.vertex;
  };
  const auto coff = [](const std::string& a, const std::string& b) {
    return read_text("COFF\n3 1 0\n0 0 0 " + a + "\n1 0 0 " + b + "\n0 1 0 0 0 0\n3 0 1 2\n", MeshFormat::off)
        .colors.vertex;
  };
  for (const auto& vertices : {std::function(obj), std::function(coff)}) {
    CHECK(same(vertices("1 1 1", "1 0 0"), {1, 1, 1, 1, 0, 0, 0, 0, 0}));
    CHECK(same(vertices("1.2 .5 .5", "1 0 0"), {1, .5f, .5f, 1, 0, 0, 0, 0, 0}));
    CHECK(same(vertices("255 51 0", "1 0 0"), {1, .2f, 0, 1 / 255.f, 0, 0, 0, 0, 0}));
  }
}

namespace {

CompanionFile image_file(const std::string& name, const std::string& bytes) {
  return {.path = name, .bytes = std::as_bytes(std::span(bytes)), .is_image = true};
}

}  // namespace

TEST_CASE("colors: PLY textures by face or vertex coordinates, in text and binary") {
  const std::string head =
      "ply\nformat {} 1.0\ncomment TextureFile a.png\ncomment TextureFile b.png\n"
      "element vertex 4\nproperty float x\nproperty float y\nproperty float z\n{}element face 2\n"
      "property list uchar int vertex_indices\n{}end_header\n";
  const std::string wedges = "property list uchar float texcoord\nproperty int texnumber\n";
  const std::string text =
      fmt::format(fmt::runtime(head), "ascii", "", wedges) +
      "0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2 6 0 0 .5 0 .5 1 1\n3 0 2 3 6 0 .25 1 1 0 1 -1\n";
  std::string binary = fmt::format(fmt::runtime(head), "binary_little_endian", "", wedges);
  const auto put = [&](const auto& value) {
    binary.append(reinterpret_cast<const char*>(&value), sizeof value);
  };
  for (const float value : {0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 1.f, 1.f, 0.f, 0.f, 1.f, 0.f}) put(value);
  const auto face = [&](std::array<std::int32_t, 3> corners, std::array<float, 6> coordinates,
                        std::int32_t number) {
    put(std::uint8_t{3});
    for (const std::int32_t corner : corners) put(corner);
    put(std::uint8_t{6});
    for (const float value : coordinates) put(value);
    put(number);
  };
  face({0, 1, 2}, {0, 0, .5f, 0, .5f, 1}, 1);
  face({0, 2, 3}, {0, .25f, 1, 1, 0, 1}, -1);
  const std::string not_an_image = "x";
  const std::vector<CompanionFile> images = {image_file("a.png", not_an_image),
                                             image_file("b.png", not_an_image)};
  for (const std::string& file : {text, binary}) {
    const PolygonMesh mesh = read_text(file, MeshFormat::ply, true, {}, images);
    REQUIRE(mesh.colors.textures);
    const SurfaceTextures& textures = *mesh.colors.textures;
    CHECK(textures.face == std::vector<std::uint32_t>{1, no_index});
    CHECK(textures.images.size() == 2);
    CHECK(textures.corner == std::vector<std::uint32_t>{0, 1, 2, 3, 4, 5});
    CHECK(textures.coordinates == Values{0, 0, .5f, 0, .5f, 1, 0, .25f, 1, 1, 0, 1});
    CHECK(mesh.polygon_count() == 2);
  }
  const PolygonMesh of_vertices = read_text(
      fmt::format(fmt::runtime(head), "ascii", "property float texture_u\nproperty float texture_v\n", "") +
          "0 0 0 0 0\n1 0 0 1 0\n1 1 0 1 1\n0 1 0 0 1\n3 0 1 2\n3 0 2 3\n",
      MeshFormat::ply, true, {}, images);
  REQUIRE(of_vertices.colors.textures);
  CHECK(of_vertices.colors.textures->face == std::vector<std::uint32_t>{0, 0});
  CHECK(of_vertices.colors.textures->corner == std::vector<std::uint32_t>{0, 1, 2, 0, 2, 3});
  // A list of another length than its face, and images that are lost, are noted.
  const PolygonMesh odd =
      read_text(fmt::format(fmt::runtime(head), "ascii", "", wedges) +
                    "0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2 4 0 0 .5 0 0\n3 0 2 3 6 0 .25 1 1 0 1 2\n",
                MeshFormat::ply);
  CHECK(odd.notes[Note::coordinates_missing] == 1);
  CHECK(odd.notes[Note::image_missing] == 3);  // two files, and the number 2
  CHECK(ply_image_paths(std::as_bytes(std::span(text))) == std::vector<std::string>{"a.png", "b.png"});
}

TEST_CASE("colors: library names end at comments, and blanks alone are no name") {
  const auto names = [](const std::string& text) {
    return row_of(MeshFormat::obj).color_companions(std::as_bytes(std::span(text)));
  };
  CHECK(names("mtllib m.mtl # by x\n") == std::vector<std::string>{"m.mtl"});
  CHECK(names("mtllib a" + std::string(100000, ' ') + "b.mtl\n").size() == 1);
  const std::string mtl = "newmtl a\nmap_Kd x" + std::string(100000, ' ') + "y.png\n";
  const std::vector<CompanionFile> libraries = {library(mtl)};
  CHECK(read_materials(libraries).find("a")->has_image);
}

TEST_CASE("colors: a missing material and an image referenced again are noted once") {
  const std::string face = "v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\nf 1 2 3\n";
  CHECK(read_text(face, MeshFormat::obj).notes[Note::material_missing] == 1);
  CHECK(read_text("mtllib ..\n" + face, MeshFormat::obj).notes[Note::material_missing] == 1);
  const std::vector<CompanionFile> lost = {library("", "no such file")};
  const PolygonMesh without = read_text("mtllib m.mtl\n" + face, MeshFormat::obj, true, {}, lost);
  CHECK(without.notes[Note::library_missing] == 1);
  CHECK(without.notes[Note::material_missing] == 0);
  const std::vector<CompanionFile> two = {library("newmtl a\nKd 1 0 0\nnewmtl b\nKd 0 1 0\n")};
  CHECK(read_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", MeshFormat::obj, true, {}, two)
            .notes[Note::material_missing] == 1);
  std::string ply = "ply\nformat ascii 1.0\n";
  for (int k = 0; k < 50; ++k) ply += "comment TextureFile t.png\n";
  ply +=
      "element vertex 3\nproperty float x\nproperty float y\nproperty float z\nproperty float s\nproperty "
      "float t\n"
      "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0 0 0\n1 0 0 1 0\n0 1 0 0 "
      "1\n3 0 1 2\n";
  const PolygonMesh mesh = read_text(ply, MeshFormat::ply);
  CHECK(mesh.notes[Note::image_missing] == 1);
  REQUIRE(mesh.colors.textures);
  CHECK(mesh.colors.textures->images.size() == 1);
  CHECK(mesh.colors.textures->textures.size() == 50);
}
