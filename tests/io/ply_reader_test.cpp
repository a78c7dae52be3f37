#include <bit>
#include <cmath>
#include <cstring>

#include "io/mesh/ply_header.h"
#include "io/reading.h"
#include "support/mesh_files.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;

namespace {

PolygonMesh ply(std::string_view content) { return read(content, MeshFormat::ply); }

const std::string vertex_head = "element vertex 4\nproperty float x\nproperty float y\nproperty float z\n";
const std::string face_head = "element face 2\nproperty list uchar int vertex_indices\n";
const std::string four_rows = "0 0 0\n1 0 0\n0 1 0\n0 0 1\n";
const std::string two = "3 0 1 2\n3 1 2 3\n";
const Faces two_faces = {{0, 1, 2}, {1, 2, 3}};

std::string ascii(const std::string& elements, const std::string& body) {
  return "ply\nformat ascii 1.0\ncomment made by hand\nobj_info none\n" + elements + "end_header\n" + body;
}

// Binary rows, value by value, in one byte order.
class Bytes {
 public:
  explicit Bytes(bool big_endian) : big_endian_(big_endian) {}
  template <class T>
  Bytes& put(T value) {
    char bytes[sizeof value];
    std::memcpy(bytes, &value, sizeof value);
    if (big_endian_ != (std::endian::native == std::endian::big)) std::reverse(bytes, bytes + sizeof value);
    data.append(bytes, sizeof value);
    return *this;
  }
  std::string data;

 private:
  bool big_endian_;
};

std::string binary_head(bool big_endian, const std::string& elements) {
  return std::string("ply\nformat binary_") + (big_endian ? "big" : "little") + "_endian 1.0\n" + elements +
         "end_header\n";
}

std::vector<double> values(const std::vector<ScalarAttribute>& attributes, std::string_view name) {
  for (const ScalarAttribute& attribute : attributes)
    if (attribute.name == name) return attribute.values;
  FAIL("no attribute " << name);
  return {};
}

}  // namespace

TEST_CASE("PLY: text with LF, CRLF and CR line ends") {
  const std::string text = ascii(vertex_head + face_head, four_rows + two);
  std::string crlf, cr = text;
  for (const char c : text) crlf += c == '\n' ? std::string("\r\n") : std::string(1, c);
  std::replace(cr.begin(), cr.end(), '\n', '\r');
  for (const std::string& variant : {text, crlf, "\xEF\xBB\xBF" + text, text.substr(0, text.size() - 1)}) {
    const PolygonMesh mesh = ply(variant);
    check_consistent(mesh);
    REQUIRE(mesh.x == std::vector<double>{0, 1, 0, 0});
    REQUIRE(faces_of(mesh) == two_faces);
    REQUIRE(mesh.repairs.counts == RepairCounts{}.counts);
  }
  const PolygonMesh mesh = ply(cr);
  REQUIRE(faces_of(mesh) == two_faces);
}

TEST_CASE("PLY: every scalar type under both names, in all three encodings") {
  const std::pair<const char*, const char*> names[] = {
      {"char", "int8"}, {"uchar", "uint8"}, {"short", "int16"},   {"ushort", "uint16"},
      {"int", "int32"}, {"uint", "uint32"}, {"float", "float32"}, {"double", "float64"}};
  static_assert(bytes_of(PlyType::int64) == 8 && bytes_of(PlyType::uint64) == 8);
  for (const bool second : {false, true}) {
    std::string head = vertex_head;
    for (const auto& [a, b] : names) head += std::string("property ") + (second ? b : a) + " p_" + a + "\n";
    head += face_head;
    const auto check = [&](const PolygonMesh& mesh) {
      check_consistent(mesh);
      REQUIRE(mesh.vertex_attributes.size() == 8);
      REQUIRE(values(mesh.vertex_attributes, "p_char") == std::vector<double>{-100, -100, -100, -100});
      REQUIRE(values(mesh.vertex_attributes, "p_uchar")[3] == 200);
      REQUIRE(values(mesh.vertex_attributes, "p_short")[3] == -30000);
      REQUIRE(values(mesh.vertex_attributes, "p_ushort")[3] == 60000);
      REQUIRE(values(mesh.vertex_attributes, "p_int")[3] == -2000000000);
      REQUIRE(values(mesh.vertex_attributes, "p_uint")[3] == 4000000000.0);
      REQUIRE(values(mesh.vertex_attributes, "p_float")[3] == 0.5);
      REQUIRE(values(mesh.vertex_attributes, "p_double")[3] == 0.1);
      REQUIRE(mesh.x == std::vector<double>{0, 1, 2, 3});
      REQUIRE(faces_of(mesh) == two_faces);
    };
    std::string body;
    for (int v = 0; v < 4; ++v)
      body += std::to_string(v) + " 0 0 -100 200 -30000 60000 -2000000000 4000000000 0.5 0.1\n";
    check(ply(ascii(head, body + two)));
    for (const bool big_endian : {false, true}) {
      Bytes bytes(big_endian);
      for (int v = 0; v < 4; ++v)
        bytes.put(static_cast<float>(v))
            .put(0.f)
            .put(0.f)
            .put(std::int8_t{-100})
            .put(std::uint8_t{200})
            .put(std::int16_t{-30000})
            .put(std::uint16_t{60000})
            .put(-2000000000)
            .put(4000000000u)
            .put(0.5f)
            .put(0.1);
      for (int f = 0; f < 2; ++f) bytes.put(std::uint8_t{3}).put(f).put(f + 1).put(f + 2);
      check(ply(binary_head(big_endian, head) + bytes.data));
    }
  }
}

TEST_CASE("PLY: lists of every index type are read, other lists and elements are skipped") {
  const std::string head = "element edge 2\nproperty int a\nproperty list uint short weights\n" +
                           vertex_head + "property list uchar float ring\n" +
                           "element face 2\nproperty uchar red\nproperty list ushort uint vertex_index\n"
                           "property list uchar float texcoord\nelement material 1\nproperty float shine\n";
  const auto check = [&](const PolygonMesh& mesh) {
    check_consistent(mesh);
    REQUIRE(mesh.y == std::vector<double>{0, 2, 4, 6});
    REQUIRE(faces_of(mesh) == Faces{{0, 1, 2}, {0, 1, 2, 3}});
    REQUIRE(mesh.vertex_attributes.empty());
    REQUIRE(mesh.face_attributes.size() == 1);
    REQUIRE(mesh.face_attributes[0].name == "red");
    REQUIRE(mesh.face_attributes[0].values == std::vector<double>{10, 20});
    REQUIRE(mesh.repairs.counts == RepairCounts{}.counts);
  };
  check(ply(ascii(head,
                  "7 3 1 2 3\n8 0\n"
                  "0 0 0 1 0.5\n1 2 0 0\n2 4 0 0\n3 6 0 2 0.5 x\n"
                  "10 3 0 1 2 6 0 0 0 0 0 0\n20 4 0 1 2 3 0\n0.5\n")));
  for (const bool big_endian : {false, true}) {
    Bytes bytes(big_endian);
    bytes.put(7).put(3u).put(std::int16_t{1}).put(std::int16_t{2}).put(std::int16_t{3}).put(8).put(0u);
    for (int v = 0; v < 4; ++v) {
      bytes.put(static_cast<float>(v))
          .put(static_cast<float>(2 * v))
          .put(0.f)
          .put(static_cast<std::uint8_t>(v));
      for (int k = 0; k < v; ++k) bytes.put(0.5f);
    }
    for (std::uint16_t f = 0; f < 2; ++f) {
      bytes.put(static_cast<std::uint8_t>(10 + 10 * f)).put(static_cast<std::uint16_t>(3 + f));
      for (std::uint32_t c = 0; c < 3u + f; ++c) bytes.put(c);
      bytes.put(static_cast<std::uint8_t>(6 * (1 - f)));
      for (int k = 0; k < 6 * (1 - f); ++k) bytes.put(0.25f);
    }
    bytes.put(0.5f);
    check(ply(binary_head(big_endian, head) + bytes.data));
  }
}

TEST_CASE("PLY: lists of floating-point numbers and 64-bit integers are read") {
  const auto check = [](const PolygonMesh& mesh) {
    check_consistent(mesh);
    REQUIRE(faces_of(mesh) == two_faces);
    REQUIRE(mesh.repairs.counts == RepairCounts{}.counts);
  };
  const auto head = [](const char* types) {
    return vertex_head + "element face 2\nproperty list " + types + " vertex_indices\n";
  };
  check(ply(ascii(head("float double"), four_rows + "3.0 0.0 1.0 2.0\n3 1 2 3.000000e+00\n")));
  check(ply(ascii(head("uint64 int64"), four_rows + two)));
  for (const bool big_endian : {false, true}) {
    const auto binary = [&](const char* types, auto length, auto first) {
      Bytes bytes(big_endian);
      for (const float value : {0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 1.f}) bytes.put(value);
      for (int f = 0; f < 2; ++f) {
        bytes.put(length);
        for (int c = 0; c < 3; ++c) bytes.put(static_cast<decltype(first)>(f + c));
      }
      return ply(binary_head(big_endian, head(types)) + bytes.data);
    };
    check(binary("float int", 3.f, 0));
    check(binary("double uint64", 3.0, std::uint64_t{0}));
    check(binary("uint64 int64", std::uint64_t{3}, std::int64_t{0}));
    check(binary("int64 float", std::int64_t{3}, 0.f));
    for (const double length : {3.5, -1.0, 1e300, std::numeric_limits<double>::quiet_NaN()})
      REQUIRE_THROWS_AS(binary("double int", length, 0), ItemError);
    REQUIRE_THROWS_AS(binary("uint64 int", ~std::uint64_t{0}, 0), ItemError);
  }
  // Text of an integer type has no point.
  REQUIRE(failure(ascii(head("uchar int"), four_rows + "3 0.0 1.0 2.0\n3 1.0 2.0 3.0\n"), MeshFormat::ply)
              ->status() == Status::unreadable);
}

TEST_CASE("PLY: header lines may end in LF CR, and rows may begin with a line end") {
  const auto file = [](const std::string& end, const std::string& first) {
    std::string head;
    for (const char c : binary_head(false,
                                    "element vertex 4\nproperty uchar tag\nproperty float x\nproperty "
                                    "float y\nproperty float z\n" +
                                        face_head))
      head += c == '\n' ? end : std::string(1, c);
    Bytes bytes(false);
    for (int v = 0; v < 4; ++v) {
      bytes.data += first;
      bytes.put(v == 1 ? 1.f : 0.f).put(v == 2 ? 1.f : 0.f).put(v == 3 ? 1.f : 0.f);
    }
    for (int f = 0; f < 2; ++f) bytes.put(std::uint8_t{3}).put(f).put(f + 1).put(f + 2);
    return head + bytes.data;
  };
  for (const char* const end : {"\n", "\r\n", "\n\r", "\r"})
    for (const char* const first : {"\r", "\n", "x"}) {
      if (std::string(end) == "\r" && *first == '\n') continue;  // CRLF, as far as anyone can tell
      CAPTURE(end, first);
      const PolygonMesh mesh = ply(file(end, first));
      REQUIRE(faces_of(mesh) == two_faces);
      REQUIRE(mesh.x == std::vector<double>{0, 1, 0, 0});
    }
}

TEST_CASE("PLY: comments between rows of text are skipped") {
  const std::string plain = ascii(vertex_head + face_head, four_rows + two);
  const std::string commented =
      ascii(vertex_head + face_head,
            "comment 1 2 3\n\n0 0 0\ncomment\n1 0 0\n0 1 0\n0 0 1\ncomment faces\n3 0 1 2\n"
            "comment x\n3 1 2 3\ncomment the end\n");
  REQUIRE(faces_of(ply(commented)) == two_faces);
  REQUIRE(ply(commented).x == ply(plain).x);
  REQUIRE(outcome(ascii(vertex_head + face_head, "0 0 0\ncomments\n"), MeshFormat::ply) ==
          "unreadable: line 13: vertex 1 of 4: `comments` is not a number");
}

TEST_CASE("PLY: uppercase names of coordinates, normals and face lists are read") {
  const std::string capitals = "element vertex 4\nproperty float X\nproperty float Y\nproperty float Z\n";
  REQUIRE(ply(ascii(capitals + face_head, four_rows + two)).x == std::vector<double>{0, 1, 0, 0});
  // One of exactly the name goes first.
  const PolygonMesh both =
      ply(ascii("element vertex 4\nproperty float X\nproperty float x\nproperty float y\nproperty float z\n" +
                    face_head,
                "9 0 0 0\n9 1 0 0\n9 0 1 0\n9 0 0 1\n" + two));
  REQUIRE(both.x == std::vector<double>{0, 1, 0, 0});
  REQUIRE(values(both.vertex_attributes, "X") == std::vector<double>{9, 9, 9, 9});
}

TEST_CASE("PLY: normals are kept if all three are there") {
  const std::string normals = "property float nx\nproperty float ny\nproperty float nz\n";
  const std::string rows = "0 0 0 0 0 1\n1 0 0 0 0 1\n0 1 0 0 1 0\n0 0 1 nan 0 0\n";
  const PolygonMesh mesh = ply(ascii(vertex_head + normals + face_head, rows + two));
  REQUIRE(mesh.normals.size() == 12);
  REQUIRE(mesh.normals[2] == 1);
  REQUIRE(mesh.normals[7] == 1);
  REQUIRE(std::isnan(mesh.normals[9]));
  REQUIRE(mesh.corner_normals.empty());
  REQUIRE(mesh.vertex_attributes.empty());
  const PolygonMesh partial = ply(
      ascii(vertex_head + "property float nx\n" + face_head, "0 0 0 1\n1 0 0 1\n0 1 0 1\n0 0 1 1\n" + two));
  REQUIRE(partial.normals.empty());
  REQUIRE(partial.vertex_attributes.size() == 1);
  // Not one vertex that is whole.
  REQUIRE(outcome(binary_head(false, vertex_head + normals + face_head) + "cut", MeshFormat::ply) ==
          "unreadable: the file ends in row 0 of 4 of the element `vertex`, before any face");
  const PolygonMesh none =
      ply(binary_head(false, face_head + vertex_head + normals) +
          Bytes(false).put('\3').put(0).put(1).put(2).put('\3').put(1).put(2).put(3).data);
  REQUIRE(none.vertex_count() == 0);
  REQUIRE(none.polygon_count() == 2);
  REQUIRE(none.normals.empty());
}

TEST_CASE("PLY: faces before vertices, properties in any order, and double are read") {
  const PolygonMesh mesh = ply(ascii(
      face_head +
          "element vertex 4\nproperty double z\nproperty uchar q\nproperty double x\nproperty double y\n",
      two + "1 5 2 3\n4 5 6 7\n8 5 9 10\n11 5 12 13\n"));
  REQUIRE(mesh.z == std::vector<double>{1, 4, 8, 11});
  REQUIRE(mesh.x == std::vector<double>{2, 6, 9, 12});
  REQUIRE(faces_of(mesh) == two_faces);
  REQUIRE(mesh.vertex_attributes[0].values == std::vector<double>{5, 5, 5, 5});
}

TEST_CASE("PLY: triangle strips with restarts keep one orientation") {
  const std::string head = vertex_head + "element tristrips 2\nproperty list int int vertex_indices\n";
  const Faces expected = {{0, 1, 2}, {2, 1, 3}, {3, 2, 1}, {0, 1, 2}, {2, 1, 3}, {2, 3, 0}};
  REQUIRE(faces_of(ply(ascii(head, four_rows + "8 0 1 2 3 -1 3 2 1\n5 0 1 2 3 0\n"))) == expected);
  Bytes bytes(true);
  for (int k = 0; k < 12; ++k) bytes.put(static_cast<float>(k));
  for (const int value : {8, 0, 1, 2, 3, -1, 3, 2, 1, 5, 0, 1, 2, 3, 0}) bytes.put(value);
  REQUIRE(faces_of(ply(binary_head(true, head) + bytes.data)) == expected);
  REQUIRE(outcome(ascii(head, four_rows + "2 0 1\n3 0 -1 2\n"), MeshFormat::ply) ==
          "empty: the strips hold no triangle");
}

TEST_CASE("PLY: faces and strips together, strips have no face attributes") {
  const PolygonMesh mesh =
      ply(ascii(vertex_head + "element face 1\nproperty list uchar int vertex_indices\nproperty float q\n" +
                    "element tristrips 1\nproperty list int int vertex_indices\n",
                four_rows + "3 0 1 2 0.5\n4 0 1 2 3\n"));
  check_consistent(mesh);
  REQUIRE(faces_of(mesh) == Faces{{0, 1, 2}, {0, 1, 2}, {2, 1, 3}});
  REQUIRE(mesh.face_attributes[0].values[0] == 0.5);
  REQUIRE(std::isnan(mesh.face_attributes[0].values[2]));
}

TEST_CASE("PLY: fewer faces than declared are a repair if at least one is left") {
  const std::string head =
      vertex_head + "element face 5\nproperty list uchar int vertex_indices\nproperty float q\n";
  const PolygonMesh text = ply(ascii(head, four_rows + "3 0 1 2 1\n3 1 2 3 2\n"));
  check_consistent(text);
  REQUIRE(text.polygon_count() == 2);
  REQUIRE(text.repairs[Repair::missing_faces] == 3);
  REQUIRE(ply(ascii(head, four_rows + "3 0 1 2 1\n3 1 2 3 2")).polygon_count() == 1);  // perhaps it was 2.5
  for (const bool big_endian : {false, true}) {
    Bytes bytes(big_endian);
    for (int k = 0; k < 12; ++k) bytes.put(static_cast<float>(k));
    bytes.put(std::uint8_t{3}).put(0).put(1).put(2).put(1.f);
    bytes.put(std::uint8_t{4}).put(0).put(1).put(2).put(3).put(2.f).put(std::uint8_t{3}).put(0);
    const PolygonMesh mesh = ply(binary_head(big_endian, head) + bytes.data);
    check_consistent(mesh);
    REQUIRE(faces_of(mesh) == Faces{{0, 1, 2}, {0, 1, 2, 3}});
    REQUIRE(mesh.repairs[Repair::missing_faces] == 3);
    REQUIRE(mesh.repairs[Repair::missing_vertices] == 0);
  }
}

TEST_CASE("PLY: a truncated vertex element is an error unless faces came first") {
  REQUIRE(outcome(ascii(vertex_head + face_head, "0 0 0\n1 0 0\n"), MeshFormat::ply) ==
          "unreadable: the file ends in row 2 of 4 of the element `vertex`, before any face");
  // Faces first: they are kept, and so are the vertices that are there.
  const PolygonMesh mesh = ply(ascii(face_head + vertex_head, two + "0 0 0\n1 0 0\n2 0"));
  check_consistent(mesh);
  REQUIRE(mesh.vertex_count() == 2);
  REQUIRE(faces_of(mesh) == two_faces);
  REQUIRE(mesh.repairs[Repair::missing_vertices] == 2);
  REQUIRE(mesh.repairs[Repair::missing_faces] == 0);
  Bytes bytes(false);
  for (int f = 0; f < 2; ++f) bytes.put(std::uint8_t{3}).put(0).put(1).put(2);
  for (int k = 0; k < 8; ++k) bytes.put(static_cast<float>(k));
  const PolygonMesh binary = ply(binary_head(false, face_head + vertex_head) + bytes.data);
  REQUIRE(binary.vertex_count() == 2);
  REQUIRE(binary.repairs[Repair::missing_vertices] == 2);
}

TEST_CASE("PLY: bytes after the last element are counted, blanks are not") {
  REQUIRE(ply(ascii(vertex_head + face_head, four_rows + two + "3 0 1 2\n")).repairs[Repair::extra_data] ==
          8);
  REQUIRE(ply(ascii(vertex_head + face_head, four_rows + two + "\n\n")).repairs[Repair::extra_data] == 0);
  const std::string data = mesh_bytes(cube(), MeshFile::ply_little_endian);
  REQUIRE(ply(data + "\r\n").repairs[Repair::extra_data] == 0);
  REQUIRE(ply(data + "more").repairs[Repair::extra_data] == 4);
}

TEST_CASE("PLY: a bad face keeps its number, a bad attribute is NaN, a bad coordinate is an error") {
  // A bad face keeps its number, a bad attribute becomes NaN, a bad coordinate is an error.
  const std::string head =
      vertex_head + "property float q\nelement face 3\nproperty list uchar int vertex_indices\n";
  const PolygonMesh mesh =
      ply(ascii(head, "0 0 0 1\n1 0 0 oops\n0 1 0 2\n0 0 1 3\n3 0 x 2\n3 0 1 2\n-4 1 2 3\n"));
  check_consistent(mesh);
  REQUIRE(faces_of(mesh) == Faces{{}, {0, 1, 2}, {}});
  REQUIRE(std::isnan(mesh.vertex_attributes[0].values[1]));
  REQUIRE(mesh.vertex_attributes[0].values[3] == 3);
  REQUIRE(mesh.repairs[Repair::bad_attributes] == 1);
  REQUIRE(outcome(ascii(vertex_head + face_head, "0 0 0\n1 0 0\n0 1,5 0\n0 0 1\n" + two), MeshFormat::ply) ==
          "unreadable: line 14: vertex 2 of 4: `1,5` is not a number");
  REQUIRE(outcome(ascii(vertex_head + face_head, "0 0 0\n1 0\n0 1 0\n0 0 1\n" + two), MeshFormat::ply) ==
          "unreadable: line 13: vertex 1 of 4 has fewer numbers on its line than the header promises");
  // Rows that all stand on two lines are read.
  REQUIRE(ply(ascii(vertex_head + face_head, "0 0\n0\n1 0\n0\n0 1\n0\n0 0\n1\n" + two)).x ==
          std::vector<double>{0, 1, 0, 0});
  REQUIRE(outcome(ascii(vertex_head + face_head, four_rows + "x\ny\n"), MeshFormat::ply) ==
          "unreadable: none of 2 faces has a corner that can be read");
}

TEST_CASE("PLY: corners that refer to missing vertices are kept") {
  REQUIRE(faces_of(ply(ascii(vertex_head + face_head, four_rows + "3 0 1 7\n3 -1 1 99999999999\n"))) ==
          Faces{{0, 1, 7}, {no_index, 1, no_index}});
  const std::string head = vertex_head + "element face 1\nproperty list uchar float vertex_indices\n";
  Bytes bytes(false);
  for (int k = 0; k < 12; ++k) bytes.put(static_cast<float>(k));
  bytes.put(std::uint8_t{4}).put(1.f).put(-1.f).put(std::nanf("")).put(1e20f);
  REQUIRE(faces_of(ply(binary_head(false, head) + bytes.data)) == Faces{{1, no_index, no_index, no_index}});
}

TEST_CASE("PLY: errors say where") {
  const std::string format = "ply\nformat ascii 1.0\n";
  const std::pair<std::string, const char*> cases[] = {
      {"", "empty: the file is empty"},
      {"plyx\n", "unreadable: line 1: not a PLY file: it does not begin with `ply`"},
      {"ply\n", "unreadable: line 2: the header has no end_header"},
      {format + "element vertex 3\n", "unreadable: line 4: the header has no end_header"},
      {"ply\nformat ebcdic 1.0\n", "unreadable: line 2: unknown PLY format `ebcdic`"},
      {"ply\nelement vertex 0\nend_header\n", "unreadable: line 3: the header states no format"},
      {format + "property float x\n", "unreadable: line 3: a property before any element"},
      {format + "element vertex -3\n", "unreadable: line 3: an element has no count"},
      {format + "element vertex\n", "unreadable: line 3: an element has no count"},
      {format + "element vertex 3\nproperty quad x\n", "unreadable: line 4: unknown type `quad`"},
      {format + "element vertex 3\nproperty \n", "unreadable: line 4: unknown type the end of the line"},
      {format + "element vertex 3\nproperty float\n", "unreadable: line 4: a property has no name"},
      {ascii(vertex_head + "element face 1\nproperty list float int vertex_indices\n",
             four_rows + "3.5 0 1 2\n"),
       "unreadable: none of 1 faces has a corner that can be read"},
      {format + "element vertex 3\nelephant 3\n",
       "unreadable: line 4: unknown keyword `elephant` in the header"},
      {ascii(vertex_head, four_rows), "empty: the header promises 4 vertices and no face"},
      {ascii(vertex_head + "element face 0\nproperty list uchar int vertex_indices\n", four_rows),
       "empty: the header promises 4 vertices and no face"},
      {ascii(vertex_head + "element face 2\nproperty list uchar int corners\n", four_rows + two),
       "unreadable: the element face has no list vertex_indices"},
      {ascii(face_head, two), "unreadable: the header has no element vertex"},
      {ascii("element vertex 4\nproperty float x\nproperty float y\n" + face_head, four_rows + two),
       "unreadable: the element vertex has no property z"}};
  for (const auto& [content, expected] : cases) {
    CAPTURE(content);
    REQUIRE(outcome(content, MeshFormat::ply) == expected);
  }
  // Counts larger than the file allocate no memory.
  const std::string huge =
      "element vertex 999999999999\nproperty float x\nproperty float y\nproperty float z\n";
  REQUIRE(outcome(ascii(huge + face_head, four_rows + two), MeshFormat::ply) ==
          "unreadable: the file ends in row 6 of 999999999999 of the element `vertex`, before any face");
  REQUIRE(outcome(binary_head(false, huge + face_head) + std::string(100, '\1'), MeshFormat::ply) ==
          "unreadable: the file ends in row 8 of 999999999999 of the element `vertex`, before any face");
  REQUIRE(outcome(ascii("element nothing 999999999999\n" + vertex_head + face_head, four_rows + two),
                  MeshFormat::ply) == "ok");
}

TEST_CASE("PLY: a header line without a keyword before the first element is a comment") {
  const std::string plain = mesh_bytes(cube(), MeshFile::ply_ascii);
  std::string named = plain;
  named.insert(named.find("element"), "Created by Blender3D 247 - www.blender.org, source file: \n");
  REQUIRE(same_mesh(ply(named), ply(plain)));
}

TEST_CASE("PLY: a mesh survives a round trip in every encoding") {
  PolygonMesh mesh = merged(moved(icosphere(2), 1e-7, 1e5, -3, 1 / 3.0), cube());
  mesh.vertex_attributes.push_back({"quality", mesh.z});
  mesh.face_attributes.push_back({"label", std::vector<double>(mesh.polygon_count(), 0.1)});
  mesh.face_attributes.back().values[3] = -7;
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v)
    for (const double value : {mesh.x[v], mesh.y[v], mesh.z[v]})
      mesh.normals.push_back(static_cast<float>(value));
  for (const MeshFile kind : {MeshFile::ply_ascii, MeshFile::ply_little_endian, MeshFile::ply_big_endian})
    REQUIRE(same_mesh(ply(mesh_bytes(mesh, kind)), mesh));
}
