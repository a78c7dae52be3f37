#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <span>

#include "io/reading.h"
#include "support/mesh_files.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;

namespace {

PolygonMesh stl(std::string_view content) { return read(content, MeshFormat::stl); }

std::string facet(const std::string& vertices) {
  return "facet normal 0 0 1\nouter loop\n" + vertices + "endloop\nendfacet\n";
}
const std::string three = "vertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n";

void set_count(std::string& data, std::uint32_t count) {
  for (std::size_t k = 0; k < 4; ++k) data[80 + k] = static_cast<char>(count >> (8 * k));
}

void overwrite(std::string& data, std::size_t at, std::string_view text) {
  std::copy(text.begin(), text.end(), data.begin() + static_cast<std::ptrdiff_t>(at));
}

// Facet f has the vertices 3 f, 3 f + 1 and 3 f + 2.
void check_own_vertices(const PolygonMesh& mesh) {
  check_consistent(mesh);
  REQUIRE(mesh.vertex_count() == 3 * mesh.polygon_count());
  for (std::size_t c = 0; c < mesh.corners.size(); ++c) REQUIRE(mesh.corners[c] == c);
  REQUIRE(mesh.corners.size() == 3 * mesh.polygon_count());
}

}  // namespace

TEST_CASE("STL: comments before, within and after the facets of a text file are skipped") {
  std::string commented = "# vertex 9 9 9\n# solid\n", cr;
  for (const char c : "solid name\n" + facet(three) + "endsolid name\n")
    commented += c == '\n' ? std::string(" # vertex 7 7 7\n # facet\n") : std::string(1, c);
  cr = commented;
  std::replace(cr.begin(), cr.end(), '\n', '\r');
  for (const std::string& text : {commented, cr}) {
    const PolygonMesh mesh = stl(text);
    check_own_vertices(mesh);
    REQUIRE(mesh.x == std::vector<double>{0, 1, 0});
  }
}

TEST_CASE("STL: binary and text files hold the same facets, each with its own vertices") {
  PolygonMesh sphere = icosphere(2);
  for (std::vector<double>* const values : {&sphere.x, &sphere.y, &sphere.z})
    for (double& value : *values) value = static_cast<float>(value);
  const PolygonMesh binary = stl(mesh_bytes(sphere, MeshFile::stl_binary));
  const PolygonMesh text = stl(mesh_bytes(sphere, MeshFile::stl_ascii));
  check_own_vertices(binary);
  REQUIRE(same_mesh(binary, text));
  REQUIRE(binary.polygon_count() == sphere.polygon_count());
  for (std::size_t c = 0; c < sphere.corners.size(); ++c) {
    REQUIRE(binary.x[c] == sphere.x[sphere.corners[c]]);
    REQUIRE(binary.y[c] == sphere.y[sphere.corners[c]]);
    REQUIRE(binary.z[c] == sphere.z[sphere.corners[c]]);
  }
}

TEST_CASE("STL: a binary file that begins with solid is binary") {
  std::string data = mesh_bytes(cube(), MeshFile::stl_binary);
  const std::string solid = "solid made by a CAD program\nfacet normal 0 0 1\n";
  overwrite(data, 0, solid);
  REQUIRE(stl(data).polygon_count() == 12);
  // With a wrong count too, unless the text looks like facets.
  data = mesh_bytes(cube(), MeshFile::stl_binary);
  overwrite(data, 0, "solid");
  set_count(data, 10000);
  REQUIRE(stl(data).polygon_count() == 12);
}

TEST_CASE("STL: wrong facet counts of binary files are repaired") {
  const std::string data = mesh_bytes(cube(), MeshFile::stl_binary);
  std::string more = data, fewer = data, zero = data, unknown = data;
  set_count(more, 20);
  const PolygonMesh missing = stl(more);
  check_own_vertices(missing);
  REQUIRE(missing.polygon_count() == 12);
  REQUIRE(missing.repairs[Repair::missing_faces] == 8);
  set_count(fewer, 10);
  const PolygonMesh extra = stl(fewer);
  check_own_vertices(extra);
  REQUIRE(extra.polygon_count() == 10);
  REQUIRE(extra.repairs[Repair::extra_data] == 100);
  // Counts left by programs that never went back to fill them in.
  set_count(zero, 0);
  set_count(unknown, 0xFFFFFFFFu);
  for (const std::string& streamed : {zero, unknown}) {
    const PolygonMesh mesh = stl(streamed);
    REQUIRE(mesh.polygon_count() == 12);
    REQUIRE(mesh.repairs.counts == RepairCounts{}.counts);
  }
  const PolygonMesh cut = stl(data.substr(0, data.size() - 60));
  REQUIRE(cut.polygon_count() == 10);
  REQUIRE(cut.repairs[Repair::missing_faces] == 2);
  REQUIRE(cut.repairs[Repair::extra_data] == 40);
  REQUIRE(stl(data + "tail").repairs[Repair::extra_data] == 4);
}

TEST_CASE("STL: line feeds and carriage returns in damaged binary files are not line ends") {
  std::string data = mesh_bytes(cube(), MeshFile::stl_binary);
  for (std::size_t at = 84; at + 4 < data.size(); at += 50) overwrite(data, at + 48, "\r");
  const std::string cut = data.substr(0, data.size() - 7);
  REQUIRE(cut.find('\n') == std::string::npos);
  const PolygonMesh mesh = stl(cut), whole = stl(data);
  REQUIRE(mesh.polygon_count() == 11);
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) REQUIRE(mesh.x[v] == whole.x[v]);
}

TEST_CASE("STL: text in every layout is read") {
  const std::string text = std::string("solid a name with words\n") + facet(three) +
                           facet("vertex 0 0 1\nvertex 1 0 1\nvertex 0 1 1\n") +
                           "endsolid a name with words\n";
  std::string upper = text, crlf, cr = text, one_line = text;
  for (char& c : upper) c = static_cast<char>(std::toupper(c));
  for (const char c : text) crlf += c == '\n' ? std::string("\r\n") : std::string(1, c);
  std::replace(cr.begin(), cr.end(), '\n', '\r');
  std::replace(one_line.begin(), one_line.end(), '\n', ' ');
  std::string glued = text, nameless = text;
  glued.erase(5, 1);  // solida
  nameless.erase(5, 18);
  const std::string headless = text.substr(text.find('\n') + 1);
  const PolygonMesh expected = stl(text);
  check_own_vertices(expected);
  REQUIRE(expected.z == std::vector<double>{0, 0, 0, 1, 1, 1});
  for (const std::string& variant :
       {upper, crlf, cr, one_line, glued, nameless, headless, "\n\n  " + text, "\xEF\xBB\xBF" + text}) {
    CAPTURE(variant);
    REQUIRE(same_mesh(stl(variant), expected));
  }
}

TEST_CASE("STL: several text solids are one mesh") {
  const std::string one = std::string("solid a\n") + facet(three) + "endsolid a\n",
                    two = std::string("solid b\n") + facet(three) + "endsolid\n";
  const PolygonMesh mesh = stl(one + "\n" + two + "solid c\nendsolid c\n");
  check_own_vertices(mesh);
  REQUIRE(mesh.polygon_count() == 2);
}

TEST_CASE("STL: solids may end and begin on one line") {
  const std::string facet =
      "facet normal 0 0 1 outer loop vertex 0 0 0 vertex 1 0 0 vertex 0 1 0 endloop endfacet ";
  const std::string solid = "solid a vertex " + facet + "endsolid a ";  // the name is no vertex
  const std::string text = solid + solid + solid + "\n" + solid + "\nsolid last\n" + facet + solid;
  CHECK(read(text, MeshFormat::stl).polygon_count() == 6);
}

TEST_CASE("STL: a text facet with four vertices is split, one with two keeps its number") {
  const PolygonMesh mesh = stl(std::string("solid\n") + facet(three + "vertex -1 0 0\n") +
                               facet("vertex 5 5 5\nvertex 6 6 6\n") + facet(three) + "endsolid\n");
  check_consistent(mesh);
  REQUIRE(faces_of(mesh) == Faces{{0, 1, 2}, {3, 4, 5}, {}, {9, 10, 11}});
  REQUIRE(mesh.x[3] == 0);
  REQUIRE(mesh.y[4] == 1);
  REQUIRE(mesh.x[5] == -1);
  REQUIRE(mesh.x[6] == 5);
  REQUIRE(std::isnan(mesh.x[8]));
}

TEST_CASE("STL: invalid normals do not matter, NaN positions are kept") {
  const PolygonMesh mesh =
      stl("solid\nfacet normal nan 1,5 ?\nouter loop\nvertex nan inf -1.#IND\nvertex 1 0 0\nvertex 0 1 "
          "0\nendloop\nendfacet\n");
  check_own_vertices(mesh);
  REQUIRE(std::isnan(mesh.x[0]));
  REQUIRE(mesh.y[0] == HUGE_VAL);
}

TEST_CASE("STL: a facet cut off at the end of a text file is counted") {
  const std::string start = std::string("solid\n") + facet(three);
  for (const std::string end : {"facet", "facet normal 0 0", "facet normal 0 0 1\nouter loop\nvertex 1 2",
                                "facet normal 0 0 1\nouter loop\nvertex 1 2 3\nvertex 1 2 -",
                                "facet normal 0 0 1\nouter loop\nvertex 1 2 3\nvertex 1 2 3\nvertex 1 2 3"}) {
    CAPTURE(end);
    const PolygonMesh mesh = stl(start + end);
    check_own_vertices(mesh);
    REQUIRE(mesh.polygon_count() == 1);
    REQUIRE(mesh.repairs[Repair::missing_faces] == 1);
  }
  for (const std::string end : {"\n", "\nendloop", "\nendl", "\nendloop\nendface"}) {
    CAPTURE(end);
    const PolygonMesh mesh =
        stl(start + "facet normal 0 0 1\nouter loop\nvertex 1 2 3\nvertex 1 2 3\nvertex 1 2 3" + end);
    REQUIRE(mesh.polygon_count() == 2);
    REQUIRE(mesh.repairs[Repair::missing_faces] == 0);
  }
}

TEST_CASE("STL: errors say where") {
  std::string none(84, '\0');
  overwrite(none, 0, "empty!");
  std::string lost = none;
  set_count(lost, 7);
  const std::pair<std::string, const char*> cases[] = {
      {"", "empty: the file is empty"},
      {"solid Empty\nendsolid Empty", "empty: the ascii STL file holds no facet"},
      {"solid", "empty: the ascii STL file holds no facet"},
      {none, "empty: the binary STL file states 0 facets"},
      {lost, "unreadable: the file ends before the first of 7 facets"},
      {"hello world, this is no STL file", "unreadable: line 1: neither a binary nor an ascii STL file"},
      {"\x81\x82\x83", "unreadable: byte 3: the file ends in the header of a binary STL file"},
      {"solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0\n",
       "unreadable: line 5: the file ends before its first facet is complete"},
      {"solid\nfacet normal 0 0 1\nouter loop\nvertex 0 1,5 0\nvertex 0 0 0\nvertex 1 1 1\n",
       "unreadable: line 4: a vertex needs three numbers, but there is `1,5`"}};
  for (const auto& [content, expected] : cases) {
    CAPTURE(content);
    REQUIRE(outcome(content, MeshFormat::stl) == expected);
  }
}

TEST_CASE("STL: unknown lines between a solid and its first facet are skipped") {
  const std::string facet =
      "facet normal 0 0 1\n outer loop\n  vertex 0 0 0\n  vertex 1 0 0\n  vertex 0 1 0\n endloop\nendfacet\n";
  const std::string two = facet + facet;
  for (const std::string header :
       {"color 0.9 0.1 0.1\n", "# a comment\n; another\n\n", "units mm\nfacets 12\nvertex count 3\n",
        "facetting of a part\n", "COLOR 1 0 0\r\n\tmaterial steel \xC3\xA9\n"}) {
    INFO(header);
    for (const std::string solid : {"solid\n", "solid part one\n", "SOLID x\n"}) {
      const PolygonMesh mesh = read(solid + header + two + "endsolid\n", MeshFormat::stl);
      CHECK(mesh.polygon_count() == 2);
      CHECK(mesh.x[1] == 1);
    }
    const PolygonMesh several =
        read("solid a\n" + header + facet + "endsolid a\nsolid b\n" + header + facet + "endsolid b\n",
             MeshFormat::stl);
    CHECK(several.polygon_count() == 2);
  }
  CHECK(outcome("solid a\ncolor 1 0 0\nendsolid\n", MeshFormat::stl) ==
        "empty: the ascii STL file holds no facet");
}

namespace {

// A binary file with these attributes of its facets; `color`: of the whole, by Magics.
std::string colored_stl(const std::vector<std::uint16_t>& attributes, const std::string& header = {}) {
  std::string bytes = header;
  bytes.resize(80, ' ');
  const auto put = [&](const auto& value) {
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
  };
  put(static_cast<std::uint32_t>(attributes.size()));
  for (std::size_t f = 0; f < attributes.size(); ++f) {
    for (const float value : {0.f, 0.f, 1.f, 0.f, 0.f, static_cast<float>(f), 1.f, 0.f, static_cast<float>(f),
                              0.f, 1.f, static_cast<float>(f)})
      put(value);
    put(attributes[f]);
  }
  return bytes;
}

PolygonMesh read_colored(const std::string& bytes) {
  MeshSurroundings around;
  around.colors = true;
  return read_mesh_in_blocks(std::as_bytes(std::span(bytes)), MeshFormat::stl, {}, {}, around);
}

}  // namespace

TEST_CASE("STL: VisCAM and Magics colors are told apart by their bits, and other attributes are no colors") {
  const float none = std::numeric_limits<float>::quiet_NaN();
  const auto faces = [](const PolygonMesh& mesh) { return mesh.colors.face; };
  const auto same = [&](const std::vector<float>& a, const std::vector<float>& b) {
    if (a.size() != b.size()) return false;
    for (std::size_t i = 0; i < a.size(); ++i)
      if (std::isnan(a[i]) != std::isnan(b[i]) || std::abs(a[i] - b[i]) > 1e-6f) return false;
    return true;
  };
  // The top bit is set: blue is lowest.
  CHECK(
      same(faces(read_colored(colored_stl({0xFC00, 0x801F, 0x0000}))), {1, 0, 0, 0, 0, 1, none, none, none}));
  // Magics: the top bit is clear, red is lowest, and others have the color of the whole.
  const std::string header = std::string("COLOR=\x00\xFF\x00\xFF", 10);
  CHECK(
      same(faces(read_colored(colored_stl({0x001F, 0xFFFF, 0x7C00}, header))), {1, 0, 0, 0, 1, 0, 0, 0, 1}));
  CHECK(same(faces(read_colored(colored_stl({0, 0}, header))), {0, 1, 0, 0, 1, 0}));
  // Attributes without the bit that says they are colors.
  const PolygonMesh others = read_colored(colored_stl({0x1234, 0, 7}));
  CHECK(others.colors.face.empty());
  CHECK(others.notes[Note::colors_ignored] == 2);
  CHECK(read_colored(colored_stl({0, 0})).notes.any() == false);
  // Nothing of it without colors.
  CHECK(read(colored_stl({0xFC00}), MeshFormat::stl).colors.face.empty());
}
