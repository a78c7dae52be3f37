#include "io/reading.h"
#include "support/mesh_files.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;

namespace {

PolygonMesh off(std::string_view content) { return read(content, MeshFormat::off); }

const std::string triangle = "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";

void check_triangle(const PolygonMesh& mesh) {
  check_consistent(mesh);
  REQUIRE(mesh.x == std::vector<double>{0, 1, 0});
  REQUIRE(mesh.y == std::vector<double>{0, 0, 1});
  REQUIRE(mesh.z == std::vector<double>{0, 0, 0});
  REQUIRE(faces_of(mesh) == Faces{{0, 1, 2}});
}

}  // namespace

TEST_CASE("OFF: headers of every kind found in the wild are read") {
  for (const std::string head :
       {"OFF\n3 1 0\n", "OFF 3 1 0\n", "OFF3 1 0\n", "3 1 0\n", "OFF\n3 1\n", "OFF\n3\n1\n0\n",
        "OFF\n\n\n3 1 0\n", "\xEF\xBB\xBFOFF\n3 1 0\n", "# comment\nOFF # more\n# and more\n3 1 0 # last\n",
        "off\n3 1 0\n", "OFF\r\n3 1 0\r\n", "OFF\n3 1 99999\n", "OFF\n3\n1\n", "  \n\t OFF\n 3  1\t0\n"}) {
    CAPTURE(head);
    const PolygonMesh mesh = off(head + triangle);
    check_triangle(mesh);
    REQUIRE(mesh.repairs.counts == RepairCounts{}.counts);
  }
}

TEST_CASE("OFF: counts of several digits may follow the keyword without a blank") {
  const PolygonMesh sphere = icosphere(3);
  std::string text = mesh_bytes(sphere, MeshFile::off);
  REQUIRE(text.substr(0, 4) == "OFF\n");
  text.erase(3, 1);
  REQUIRE(same_mesh(off(text), sphere));
}

TEST_CASE("OFF: comments and blank lines anywhere, CRLF, no line end at the end") {
  check_triangle(off("OFF#\n#\n3 1 0\n0 0 0#a\n# 1 1 1\n\n1 0 0 # b\n0 1 0\n#\n3 0 1 2#c\n#end"));
  check_triangle(off("OFF\r\n3 1 0\r\n0 0 0\r\n1 0 0\r\n\r\n0 1 0\r\n3 0 1 2\r\n"));
  check_triangle(off("OFF\r3 1 0\r0 0 0\r1 0 0\r0 1 0\r3 0 1 2\r"));
  check_triangle(off("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2"));
}

TEST_CASE("OFF: faces over several lines, several vertices on a line, trailing face colors") {
  check_triangle(off("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3\n0\n1 2\n"));
  check_triangle(off("OFF\n3 1 0\n0 0 0 1 0 0 0 1 0\n3 0 1 2\n"));
  check_triangle(off("OFF\n3 1 0\n0 0\n0 1 0 0 0\n1 0\n3 0 1 2\n"));
  check_triangle(off("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2 255 0 0\n"));
  const PolygonMesh two = off("OFF\n4 2 0\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n3 0 1 2 0.5 0.5 0.5 1\n3 1 3 2 3\n");
  REQUIRE(faces_of(two) == Faces{{0, 1, 2}, {1, 3, 2}});
}

TEST_CASE("OFF: colors, normals, texture and homogeneous coordinates by prefix") {
  for (const std::string color : {"", " 255 0 0", " 255 0 0 255", " 0.5 0.5 0.5 1", " 3"}) {
    CAPTURE(color);
    check_triangle(off("COFF\n3 1 0\n0 0 0" + color + "\n1 0 0" + color + "\n0 1 0" + color + "\n3 0 1 2\n"));
    // Not announced.
    check_triangle(off("OFF\n3 1 0\n0 0 0" + color + "\n1 0 0" + color + "\n0 1 0" + color + "\n3 0 1 2\n"));
  }
  const std::vector<float> normals = {0, 0, 1, 0, 0, 1, 0, 0.6f, 0.8f};
  for (const auto& [head, behind, before] :
       {std::tuple{"NOFF", "", ""}, std::tuple{"STNOFF", " 0.5 0.5", ""}, std::tuple{"CNOFF", " 1 0.5 0", ""},
        std::tuple{"NCOFF", "", " 200 100 0"}, std::tuple{"NCOFF", "", " 200 100 0 255"}}) {
    CAPTURE(head, behind, before);
    // Named anew: clang 14 cannot capture structured bindings.
    const auto line = [before = before, behind = behind](const std::string& position,
                                                         const std::string& normal) {
      return position + before + normal + behind + "\n";
    };
    const PolygonMesh mesh = off(std::string(head) + "\n3 1 0\n" + line("0 0 0", " 0 0 1") +
                                 line("1 0 0", " 0 0 1") + line("0 1 0", " 0 0.6 0.8") + "3 0 1 2\n");
    check_triangle(mesh);
    REQUIRE(mesh.normals == normals);
    REQUIRE(mesh.corner_normals.empty());
  }
  check_triangle(off("4OFF\n3 1 0\n0 0 0 5\n2 0 0 2\n0 0.5 0 0.5\n3 0 1 2\n"));
}

TEST_CASE("OFF: nOFF vertices of two or three dimensions are read") {
  check_triangle(off("nOFF\n3\n3 1 0\n" + triangle));
  check_triangle(off("nOFF 3\n3 1 0\n" + triangle));
  check_triangle(off("nOFF\n2\n3 1 0\n0 0\n1 0\n0 1\n3 0 1 2\n"));
  check_triangle(off("4nOFF\n3\n3 1 0\n0 0 0 5\n2 0 0 2\n0 0.5 0 0.5\n3 0 1 2\n"));
  check_triangle(off("4nOFF\n2\n3 1 0\n0 0 5\n2 0 2\n0 0.5 0.5\n3 0 1 2\n"));
  check_triangle(off("CnOFF\n3\n3 1 0\n0 0 0 1 0 0 1\n1 0 0 1 0 0 1\n0 1 0 1 0 0 1\n3 0 1 2\n"));
  REQUIRE(outcome("nOFF\n4\n3 1 0\n" + triangle, MeshFormat::off) ==
          "unsupported_format: nOFF: vertices of 4 dimensions are not supported");
  REQUIRE(failure("nOFF\n1\n3 1 0\n" + triangle, MeshFormat::off)->status() == Status::unsupported_format);
  REQUIRE(failure("nOFF BINARY\n" + triangle, MeshFormat::off)->status() == Status::unsupported_format);
  REQUIRE(outcome("nOFF\n", MeshFormat::off) ==
          "unreadable: line 2: the file ends before the number of dimensions");
}

TEST_CASE("OFF: face indices may have points and exponents") {
  const std::string vertices = "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n";
  for (const char* const face : {"3.0 0.0 1.0 2.0\n", "3 0.0 1.0 2.0\n", "3. 0 1 2. # last\n",
                                 "3.000000e+00 0.000000e+00 1.000000e+00 2.000000e+00"})
    check_triangle(off(vertices + face));
  const PolygonMesh mesh = off("OFF\n3 2 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1.5 2\n3 0 1 2\n");
  REQUIRE(faces_of(mesh) == Faces{{}, {0, 1, 2}});
  // A vertex too many is no face.
  for (const char* const row : {"3.0 0.0 1.0\n", "0.0 0.0 0.0\n", "2.0 1.0 0.0\n"})
    REQUIRE(failure("OFF\n3 2 0\n0 0 0\n1 0 0\n0 1 0\n" + std::string(row) + "3 0 1 2\n3 0 2 1\n",
                    MeshFormat::off)
                ->status() == Status::unreadable);
}

TEST_CASE("OFF: binary in both byte orders, with normals") {
  PolygonMesh sphere = icosphere(2);
  for (std::vector<double>* const values : {&sphere.x, &sphere.y, &sphere.z})
    for (double& value : *values) value = static_cast<float>(value);
  std::string data = mesh_bytes(sphere, MeshFile::off_binary);
  REQUIRE(same_mesh(off(data), sphere));
  const std::size_t body = data.find('\n') + 1;
  for (std::size_t at = body; at < data.size(); at += 4)
    std::reverse(data.begin() + at, data.begin() + at + 4);
  REQUIRE(same_mesh(off(data), sphere));
  for (std::size_t v = 0; v < sphere.vertex_count(); ++v)
    for (const double value : {sphere.x[v], sphere.y[v], sphere.z[v]})
      sphere.normals.push_back(static_cast<float>(value));
  REQUIRE(same_mesh(off(mesh_bytes(sphere, MeshFile::off_binary)), sphere));
}

TEST_CASE("OFF: a truncated binary file keeps its complete faces") {
  const PolygonMesh box = cube();
  const std::string data = mesh_bytes(box, MeshFile::off_binary);
  const PolygonMesh cut = off(data.substr(0, data.size() - 10));
  check_consistent(cut);
  REQUIRE(cut.polygon_count() == 5);
  REQUIRE(cut.repairs[Repair::missing_faces] == 1);
  REQUIRE(outcome(data.substr(0, 60), MeshFormat::off).starts_with("unreadable: byte 11: the counts"));
}

TEST_CASE("OFF: polygons of any size keep their corners") {
  const PolygonMesh mesh =
      off("OFF\n5 5 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n2 2 2\n4 0 1 2 3\n5 0 1 2 3 4\n0\n2 0 1\n1 4\n");
  check_consistent(mesh);
  REQUIRE(faces_of(mesh) == Faces{{0, 1, 2, 3}, {0, 1, 2, 3, 4}, {}, {0, 1}, {4}});
}

TEST_CASE("OFF: corners that refer to missing vertices are kept") {
  const PolygonMesh mesh = off("OFF\n3 2 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 7\n3 -1 1 99999999999\n");
  REQUIRE(faces_of(mesh) == Faces{{0, 1, 7}, {no_index, 1, no_index}});
}

TEST_CASE("OFF: NaN and infinite coordinates are kept") {
  const PolygonMesh mesh =
      off("OFF\n3 1 0\nnan -nan(ind) 1.#QNAN\ninf -inf 1.#INF\n1e400 -1e400 0\n3 0 1 2\n");
  REQUIRE(std::isnan(mesh.x[0]));
  REQUIRE(std::isnan(mesh.y[0]));
  REQUIRE(std::isnan(mesh.z[0]));
  REQUIRE(mesh.x[1] == HUGE_VAL);
  REQUIRE(mesh.y[1] == -HUGE_VAL);
  REQUIRE(mesh.z[1] == HUGE_VAL);
  REQUIRE(mesh.x[2] == HUGE_VAL);
  REQUIRE(mesh.y[2] == -HUGE_VAL);
}

TEST_CASE("OFF: fewer faces than declared are a repair if at least one is left") {
  const PolygonMesh mesh = off("OFF\n3 5 0\n" + triangle);
  check_triangle(mesh);
  REQUIRE(mesh.repairs[Repair::missing_faces] == 4);
  // Cut in a face, and cut after a digit: the last face may refer to another vertex than before.
  for (const std::string end : {"3 0 1", "3 0", "3", "3 0 1 2"}) {
    const PolygonMesh cut = off("OFF\n3 3 0\n" + triangle + end);
    check_triangle(cut);
    REQUIRE(cut.repairs[Repair::missing_faces] == 2);
  }
  REQUIRE(outcome("OFF\n3 5 0\n0 0 0\n1 0 0\n0 1 0\n", MeshFormat::off) ==
          "unreadable: line 6: the file ends before the first of 5 faces");
}

TEST_CASE("OFF: bytes after the last face are counted") {
  const PolygonMesh mesh = off("OFF\n3 1 0\n" + triangle + "# comment\n3 0 1 2\n");
  check_triangle(mesh);
  REQUIRE(mesh.repairs[Repair::extra_data] == 8);
}

TEST_CASE("OFF: an unreadable face keeps its number") {
  const PolygonMesh mesh = off("OFF\n3 4 0\n0 0 0\n1 0 0\n0 1 0\n3 0 x 2\n3 0 1 2\n-3 0 1 2\n99999 0 1 2\n");
  check_consistent(mesh);
  REQUIRE(faces_of(mesh) == Faces{{}, {0, 1, 2}, {}, {}});
  REQUIRE(outcome("OFF\n3 2 0\n0 0 0\n1 0 0\n0 1 0\nx y\nz\n", MeshFormat::off) ==
          "unreadable: line 6: `x` does not begin a face");
}

TEST_CASE("OFF: errors say where") {
  const std::pair<const char*, const char*> cases[] = {
      {"", "empty: the file is empty"},
      {" \n\t\r\n", "empty: the file holds nothing but blanks"},
      {"# comment\n", "empty: the file holds no data"},
      {"OFF\n3 0 0\n0 0 0\n1 0 0\n0 1 0\n", "empty: the header promises 3 vertices and no face"},
      {"OFF\n0 0 0\n", "empty: the header promises 0 vertices and no face"},
      {"hello\n", "unreadable: line 1: neither OFF nor counts, but `hello`"},
      {"OFF\n", "unreadable: line 2: the file ends before the number of vertices"},
      {"OFF\n3\n", "unreadable: line 3: the file ends before the number of faces"},
      {"OFF\n-3 1 0\n", "unreadable: line 2: `-3` is not a number of vertices"},
      {"OFF\nthree 1 0\n", "unreadable: line 2: `three` is not a number of vertices"},
      {"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1,5 0\n3 0 1 2\n",
       "unreadable: line 5: vertex 2 of 3: `1,5` is not a number"},
      {"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0 0.5\n3 0 1 2\n",
       "unreadable: line 5: `0.5` follows vertex 2 of 3 on its line, where all before it end theirs: "
       "a number or a vertex too many or too few"},
      {"OFF\n3 1 0\n0 0 0\n1 0\n0 1 0\n3 0 1 2\n",
       "unreadable: line 5: `1` follows vertex 1 of 3 on its line, where all before it end theirs: "
       "a number or a vertex too many or too few"},
      {"OFF\n3 1 0\n0 0 0\n1 0 0\n3 0 1 2\n",
       "unreadable: line 5: `2` follows vertex 2 of 3 on its line, where all before it end theirs: "
       "a number or a vertex too many or too few"},
      {"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n0.5 1 0\n3 0 1 2\n",
       "unreadable: line 6: `0.5` does not begin a face"},
      {"OFF\n3 2 0\n0 0 0\n1 0 0\n0 1 0\n0.5 1 0\n3 0 1 2\n3 0 2 1\n",
       "unreadable: line 6: `0.5` does not begin a face, and more lines than the header promises follow: "
       "the file has more than 3 vertices"},
      {"OFF\n3 1 0\n0 0 0\n1 0 0\n    0 1\n", "unreadable: line 6: the file ends in vertex 2 of 3"},
      {"OFF\n1000 1 0\n0 0 0\n", "unreadable: the header promises 1000 vertices, but only 7 bytes follow it"},
      {"OFF\n353535235358 6 0\n0 0 0\n",
       "unreadable: the header promises 353535235358 vertices, but only 7 bytes follow it"}};
  for (const auto& [content, expected] : cases) {
    CAPTURE(content);
    REQUIRE(outcome(content, MeshFormat::off) == expected);
  }
}

TEST_CASE("OFF: declared faces take no more memory than the file covers") {
  const PolygonMesh mesh = off("OFF\n3 900000000000000 0\n" + triangle);
  check_triangle(mesh);
  REQUIRE(mesh.repairs[Repair::missing_faces] == 0xFFFFFFFFu);
}

TEST_CASE("OFF: positions survive a round trip bit by bit") {
  const PolygonMesh knot = moved(torus(37, 11), 1e-7, 1e5, -3, 1 / 3.0);
  REQUIRE(same_mesh(off(mesh_bytes(knot, MeshFile::off)), knot));
}

TEST_CASE("OFF: a vertex count that begins with 4 is not read as 4OFF") {
  // Whatever digits the count begins with, and letters that are no keyword leave nothing behind.
  for (const int vertices : {4, 40, 400, 44}) {
    std::string rows;
    for (int v = 0; v < vertices; ++v) rows += std::to_string(v) + " " + std::to_string(v * v) + " 0\n";
    const std::string body = std::to_string(vertices) + " 1 0\n" + rows + "3 0 1 3\n";
    INFO(vertices);
    const PolygonMesh bare = read(body, MeshFormat::off), named = read("OFF\n" + body, MeshFormat::off);
    CHECK(same_mesh(bare, named));
    CHECK(bare.vertex_count() == static_cast<std::size_t>(vertices));
  }
  const PolygonMesh homogeneous =
      read("4OFF\n4 1 0\n0 0 0 1\n2 0 0 2\n0 2 0 2\n0 0 2 2\n3 0 1 2\n", MeshFormat::off);
  CHECK(homogeneous.x[1] == 1);
}
