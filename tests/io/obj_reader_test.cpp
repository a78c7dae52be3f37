#include <cmath>

#include "io/reading.h"
#include "support/mesh_files.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;

namespace {

PolygonMesh obj(std::string_view content) { return read(content, MeshFormat::obj); }

const std::string four = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n";

std::string utf16(const std::string& ascii, bool big_endian) {
  std::string bytes = big_endian ? "\xFE\xFF" : "\xFF\xFE";
  for (const char c : ascii) {
    if (big_endian) bytes += '\0';
    bytes += c;
    if (!big_endian) bytes += '\0';
  }
  return bytes;
}

}  // namespace

TEST_CASE("OBJ: faces of every form, polygons and positions are read") {
  const PolygonMesh mesh =
      obj(four +
          "f 1 2 3\nf 1/1 2/2 4/3\nf 1//1 3//2 4//3\nf 2/1/1 3/2/2 4/3/3\nf 1 2 3 4\nf 1// 2// 3//\n"
          "f 1/ 2/ 3/\nf 1/5/ 2 3/7\n");
  check_consistent(mesh);
  REQUIRE(mesh.x == std::vector<double>{0, 1, 0, 0});
  REQUIRE(mesh.z == std::vector<double>{0, 0, 0, 1});
  REQUIRE(faces_of(mesh) ==
          Faces{{0, 1, 2}, {0, 1, 3}, {0, 2, 3}, {1, 2, 3}, {0, 1, 2, 3}, {0, 1, 2}, {0, 1, 2}, {0, 1, 2}});
}

TEST_CASE("OBJ: faces with the older keyword fo, and indices with points and exponents") {
  REQUIRE(faces_of(obj(four + "fo 1 2 3\nfo 1/1 3//2 4/4/4\nfoo 1 2 4\n")) == Faces{{0, 1, 2}, {0, 2, 3}});
  REQUIRE(faces_of(obj(four + "f 1.0 2.0 3.0\nf 1.000000e+00 3.000000e+00 4.000000e+00\nf -1. -2 -3.0\n")) ==
          Faces{{0, 1, 2}, {0, 2, 3}, {3, 2, 1}});
  REQUIRE(faces_of(obj(four + "f 1.5 2 3\nf 1 2 3\nf 1. 2e 3\n")) == Faces{{}, {0, 1, 2}, {}});
}

TEST_CASE("OBJ: free-form surfaces are noted, curves and faces are not") {
  const PolygonMesh mesh =
      obj(four + "cstype bezier\nsurf 0 1 0 1 1 2 3 4\ncurv 0 1 1 2\nend\nbzp 1 2 3 4\nf 1 2 3\nsurface 1\n");
  REQUIRE(faces_of(mesh) == Faces{{0, 1, 2}});
  REQUIRE(mesh.notes[Note::feature_ignored] == 2);
  REQUIRE_FALSE(obj(four + "s 1\ncurv 0 1 1 2\nf 1 2 3\n").notes.any());
}

TEST_CASE("OBJ: negative indices count back from their line") {
  const PolygonMesh mesh = obj("v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\nv 0 0 1\nf -4 -3 -1\nf 1 -1 2\n");
  REQUIRE(faces_of(mesh) == Faces{{0, 1, 2}, {0, 1, 3}, {0, 3, 1}});
}

TEST_CASE("OBJ: indices of missing vertices keep the polygon in its place") {
  const PolygonMesh mesh = obj(four + "f 1 2 9\nf 0 1 2\nf -5 1 2\nf 1 2 3\nf 1 2 99999999999999999999\n");
  REQUIRE(faces_of(mesh) ==
          Faces{{0, 1, no_index}, {no_index, 0, 1}, {no_index, 0, 1}, {0, 1, 2}, {0, 1, no_index}});
  // A vertex may come after the face that names it.
  REQUIRE(faces_of(obj("f 1 2 3\n" + four)) == Faces{{0, 1, 2}});
}

TEST_CASE("OBJ: normals are read per corner") {
  const PolygonMesh mesh =
      obj("vn 0 0 1\nvn 0 1 0\n" + four + "f 1//1 2//2 3//-1\nf 1 2 3\nf 2//2 3//9 4//-7\n");
  check_consistent(mesh);
  REQUIRE(mesh.normals == std::vector<float>{0, 0, 1, 0, 1, 0});
  REQUIRE(mesh.corner_normals ==
          std::vector<std::uint32_t>{0, 1, 1, no_index, no_index, no_index, 1, no_index, no_index});
  // Normals that no face refers to are ignored.
  const PolygonMesh unused = obj("vn 0 0 1\n" + four + "f 1 2 3\n");
  REQUIRE(unused.normals.empty());
  REQUIRE(unused.corner_normals.empty());
  // A normal that cannot be read keeps its number.
  const PolygonMesh broken = obj("vn 0 0\nvn a b c\nvn 0 1 0\n" + four + "f 1//3 2//2 3//1\n");
  REQUIRE(broken.normals == std::vector<float>{0, 0, 0, 0, 0, 0, 0, 1, 0});
}

TEST_CASE("OBJ: objects, groups, materials, texture coordinates, lines, points and free forms are skipped") {
  const PolygonMesh mesh = obj("mtllib a b.mtl\no one\ng x\n" + four +
                               "vt 0 0\nvp 0 1\ns off\nusemtl m\nf 1 2 3\nl 1 2\np 1\n"
                               "o two\nv 5 5 5\ncurv 0 1 1 2\nf 3 4 5\n# f 1 2 3\nvertex 1 2 3\nfoo 1 2 3\n");
  REQUIRE(mesh.vertex_count() == 5);
  REQUIRE(faces_of(mesh) == Faces{{0, 1, 2}, {2, 3, 4}});
}

TEST_CASE("OBJ: colors and weights after a position are ignored, also when they are NaN") {
  const PolygonMesh mesh = obj("v 0 0 0 nan nan nan\nv 1 0 0 1.0\nv 0 1 0 0.5 0.25 1 x\nf 1 2 3\n");
  REQUIRE(mesh.y == std::vector<double>{0, 0, 1});
  REQUIRE(mesh.vertex_attributes.empty());
}

TEST_CASE("OBJ: line ends, continuations, blanks and comments are accepted") {
  const Faces expected = {{0, 1, 2}, {1, 2, 3}};
  std::string text = four + "f 1 2 3\nf 2 3 4\n";
  std::string crlf;
  for (const char c : text) crlf += c == '\n' ? std::string("\r\n") : std::string(1, c);
  std::string cr = text;
  std::replace(cr.begin(), cr.end(), '\n', '\r');
  for (const std::string& variant : {text, crlf, cr, "\xEF\xBB\xBF" + text, text.substr(0, text.size() - 1),
                                     utf16(text, true), utf16(text, false), utf16(crlf, false)}) {
    const PolygonMesh mesh = obj(variant);
    REQUIRE(mesh.vertex_count() == 4);
    REQUIRE(faces_of(mesh) == expected);
  }
  REQUIRE(faces_of(obj(four + "f 1 2 \\\n3\nf 2 \\\r\n 3\\\n 4\n")) == expected);
  REQUIRE(faces_of(obj("  \tv\t0 0 0\nv 1 0 0#c\n v 0\t1  0\nv 0 0 1 \\\n0.5 0.5\n\n\nf   1\t2 3 # f 1 1 "
                       "1\nf 2 3 4#\n")) == expected);
  // Blanks between the backslash and the end of the line, wherever the blocks are cut.
  const std::string blanks = four + "f 1 2 \\ \t\n3\nf 2 \\  \r\n 3\\ \n 4\n";
  for (std::size_t block = 1; block <= blanks.size(); ++block)
    REQUIRE(faces_of(read(blanks, MeshFormat::obj, {.parallel_from = 0, .block_bytes = block})) == expected);
  // The backslash of a Windows path does not continue the line.
  REQUIRE(faces_of(obj("# C:\\models\\\nmtllib C:\\models\\\n" + four + "f 1 2 3\nf 2 3 4\n")) == expected);
}

TEST_CASE("OBJ: very long lines are read") {
  std::string text = four + "f";
  std::vector<std::uint32_t> face;
  for (int i = 0; i < 200000; ++i) {
    (text += ' ') += std::to_string(1 + i % 4);
    face.push_back(i % 4);
  }
  REQUIRE(faces_of(obj(text)) == Faces{face});
  REQUIRE(faces_of(read(text, MeshFormat::obj, {.parallel_from = 0, .block_bytes = 1000})) == Faces{face});
}

TEST_CASE("OBJ: NaN and infinite coordinates are kept") {
  const PolygonMesh mesh = obj("v nan -nan(ind) 1.#QNAN\nv inf -1.#INF 1e400\nv +1.5 -.5 1.\nf 1 2 3\n");
  REQUIRE(std::isnan(mesh.x[0]));
  REQUIRE(std::isnan(mesh.y[0]));
  REQUIRE(std::isnan(mesh.z[0]));
  REQUIRE(mesh.x[1] == HUGE_VAL);
  REQUIRE(mesh.y[1] == -HUGE_VAL);
  REQUIRE(mesh.z[1] == HUGE_VAL);
  REQUIRE(mesh.x[2] == 1.5);
  REQUIRE(mesh.y[2] == -0.5);
  REQUIRE(mesh.z[2] == 1);
}

TEST_CASE("OBJ: short and unreadable faces keep their numbers") {
  const PolygonMesh mesh =
      obj("vn 0 0 1\n" + four + "f 1 2\nf\nf 1//1 2//1 x\nf -1 -2 -3x\nf 2//1 3//1 4//1\nf 1,2,3\n");
  check_consistent(mesh);
  REQUIRE(faces_of(mesh) == Faces{{0, 1}, {}, {}, {}, {1, 2, 3}, {}});
  REQUIRE(mesh.corner_normals == std::vector<std::uint32_t>{no_index, no_index, 0, 0, 0});
}

TEST_CASE("OBJ: normals of an unreadable face are ignored, whatever the blocks") {
  const std::string text = "vn 0 0 1\n" + four + "f 1 2 3\nf 1//1 2//1 x\n";
  for (std::size_t block = 1; block <= text.size(); ++block) {
    CAPTURE(block);
    const PolygonMesh mesh = read(text, MeshFormat::obj, {.parallel_from = 0, .block_bytes = block});
    REQUIRE(mesh.corner_normals.empty());
    REQUIRE(mesh.normals.empty());
    REQUIRE(faces_of(mesh) == Faces{{0, 1, 2}, {}});
  }
}

TEST_CASE("OBJ: a vertex cut off at the end is dropped and counted") {
  for (const std::string end : {"v", "v ", "v 1", "v 1 2", "v 1 2 -", "v 1 2 1e"}) {
    CAPTURE(end);
    const PolygonMesh mesh = obj(four + "f 1 2 3\n" + end);
    REQUIRE(mesh.vertex_count() == 4);
    REQUIRE(mesh.repairs[Repair::missing_vertices] == 1);
  }
  // The cut line may reach over the beginning of the last block, which then is empty, and over several.
  const std::string text = four + "f 1 2 3\nv 1 " + std::string(100, ' ');
  for (std::size_t block = 1; block <= text.size() + 1; ++block) {
    CAPTURE(block);
    const PolygonMesh mesh = read(text, MeshFormat::obj, {.parallel_from = 0, .block_bytes = block});
    REQUIRE(mesh.vertex_count() == 4);
    REQUIRE(mesh.repairs[Repair::missing_vertices] == 1);
  }
}

TEST_CASE("OBJ: errors say where") {
  const std::pair<std::string, const char*> cases[] = {
      {"", "empty: the file is empty"},
      {"\n \n", "empty: the file holds nothing but blanks"},
      {"# nothing\n", "empty: the file holds no vertex and no face"},
      {"o lonely\n", "empty: the file holds no vertex and no face"},
      {four, "empty: the file holds 4 vertices and no face"},
      {four + "l 1 2\nl 2 3\n", "empty: the file holds 4 vertices and no face"},
      {"hello world\n", "unreadable: line 1: not a line of an OBJ file: `hello`"},
      {"v 0 0 0\nv 1,5 0 0\nf 1 2 2\n",
       "unreadable: line 2: a vertex needs three numbers, but there is `1,5`"},
      {"v 0 0 0\nv 1 0\nf 1 2 2\n",
       "unreadable: line 2: a vertex needs three numbers, but there is the end of the line"},
      {four + "f a b c\nf d e f\n", "unreadable: line 5: this face cannot be read, nor any other"}};
  for (const auto& [content, expected] : cases) {
    CAPTURE(content);
    REQUIRE(outcome(content, MeshFormat::obj) == expected);
  }
}

TEST_CASE("OBJ: the first error is reported, whatever the blocks") {
  std::string text;
  for (int i = 0; i < 3000; ++i) text += i % 1000 == 700 ? "v 1 bad 2\n" : "v 1 2 3\n";
  text += "f 1 2 3\n";
  for (const std::size_t block : {64, 1000, 5000, 1000000}) {
    try {
      read(text, MeshFormat::obj, {.parallel_from = 0, .block_bytes = block});
      FAIL("read a bad vertex");
    } catch (const ItemError& error) {
      REQUIRE(std::string(error.what()) == "line 701: a vertex needs three numbers, but there is `bad`");
    }
  }
}

TEST_CASE("OBJ: positions and normals survive a round trip bit by bit") {
  PolygonMesh mesh = moved(icosphere(3), 1e-7, 1e5, -3, 1 / 3.0);
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v)
    for (const double value : {mesh.x[v], mesh.y[v], mesh.z[v]})
      mesh.normals.push_back(static_cast<float>(value));
  mesh.corner_normals = mesh.corners;
  REQUIRE(same_mesh(obj(mesh_bytes(mesh, MeshFile::obj)), mesh));
}
