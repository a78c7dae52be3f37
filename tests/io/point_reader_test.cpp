#include "io/mesh/point_reader.h"

#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

#include "io/point_files.h"
#include "io/reading.h"
#include "support/archive_files.h"
#include "support/mesh_files.h"

using namespace meander;
using namespace meander::test;

namespace {

using Values = std::vector<double>;

PointCloud points(const std::string& name, std::string_view content) {
  return read_points_in_blocks(content, name, {}, {});
}

// "unreadable: line 3: ...", or how many points there are.
std::string result(const std::string& name, std::string_view content) {
  try {
    return std::to_string(points(name, content).count()) + " points";
  } catch (const ItemError& error) {
    return std::string(name_of(error.status())) + ": " + error.what();
  }
}

bool same(const PointCloud& a, const PointCloud& b) {
  return same_bits(a.x, b.x) && same_bits(a.y, b.y) && same_bits(a.z, b.z) && same_bits(a.normals, b.normals);
}

template <class T>
void put(std::string& data, T value, bool big_endian) {
  char bytes[sizeof value];
  std::memcpy(bytes, &value, sizeof value);
  if (big_endian != (std::endian::native == std::endian::big)) std::reverse(bytes, bytes + sizeof value);
  data.append(bytes, sizeof value);
}

std::string ply(const std::string& format, const std::string& elements, const std::string& body) {
  return "ply\nformat " + format + " 1.0\n" + elements + "end_header\n" + body;
}

const std::string three_vertices = "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n";
const std::string three_rows = "0 1 2\n3 4 5\n6 7 8\n";
const std::string two_faces = "element face 2\nproperty list uchar int vertex_indices\n";

Samples some_samples(std::size_t count) {
  Samples samples;
  for (std::size_t i = 0; i < count; ++i) {
    const auto t = static_cast<float>(i);
    samples.points.insert(samples.points.end(), {std::sin(t), t / 3, -1e-20f * t});
    samples.normals.insert(samples.normals.end(), {std::cos(t), std::sin(t), 0});
    samples.face.push_back(static_cast<std::uint32_t>(i));
    samples.density.push_back(1);
  }
  return samples;
}

}  // namespace

TEST_CASE("read_points: reads what write_points writes, digit for digit and in order") {
  const ScratchFolder folder;
  const Samples samples = some_samples(5000);
  ItemReport report;
  report.loc = {1e8, -0.125, 3};
  report.scale = 0.3;
  for (const auto& [name, format] :
       {std::pair{"a.PLY", PointFormat::ply}, {"a.off", PointFormat::off}, {"a.xyz", PointFormat::xyz}}) {
    CAPTURE(name);
    write_points(folder / name, format, samples, report);
    const PointCloud cloud = read_points(folder / name);
    REQUIRE(cloud.count() == 5000);
    bool equal = true;
    for (std::size_t i = 0; i < 5000; ++i) {
      const std::array<double, 3> point = {cloud.x[i], cloud.y[i], cloud.z[i]};
      for (std::size_t k = 0; k < 3; ++k)
        equal = equal && point[k] == report.loc[k] + report.scale * double{samples.points[3 * i + k]};
    }
    REQUIRE(equal);
    if (format == PointFormat::off)
      REQUIRE(cloud.normals.empty());
    else
      REQUIRE(cloud.normals == samples.normals);
    write_points(folder / name, format, {}, {});
    REQUIRE_THROWS_AS(read_points(folder / name), ItemError);
  }
}

TEST_CASE("read_points: PLY in three encodings, with faces, lists and elements around the vertices") {
  const std::string elements =
      "element camera 2\nproperty int id\nproperty list uchar float view\n"
      "element vertex 3\nproperty double z\nproperty list uchar short tags\nproperty float nx\n"
      "property float ny\nproperty float nz\nproperty uchar red\nproperty int x\nproperty float y\n" +
      two_faces;
  std::string text = "1 2 0.5 0.5\n2 0\n";
  for (int v = 0; v < 3; ++v)
    text += std::to_string(v) + ".25 " + (v == 1 ? "0" : "2 7 8") + " 0 0 " + std::to_string(v) + " 255 -" +
            std::to_string(v) + " 1.5\n";
  std::vector<PointCloud> clouds = {points("a.ply", ply("ascii", elements, text + "3 0 1 2\n3 2 1 0\n")),
                                    points("a.ply", ply("ascii", elements, text))};
  for (const bool big : {false, true}) {
    std::string data;
    put(data, 1, big);
    put(data, std::uint8_t{2}, big);
    put(data, 0.5f, big);
    put(data, 0.5f, big);
    put(data, 2, big);
    put(data, std::uint8_t{0}, big);
    for (int v = 0; v < 3; ++v) {
      put(data, v + 0.25, big);
      put(data, static_cast<std::uint8_t>(v == 1 ? 0 : 2), big);
      for (int k = 0; k < (v == 1 ? 0 : 2); ++k) put(data, std::int16_t{7}, big);
      put(data, 0.f, big);
      put(data, 0.f, big);
      put(data, static_cast<float>(v), big);
      put(data, std::uint8_t{255}, big);
      put(data, -v, big);
      put(data, 1.5f, big);
    }
    clouds.push_back(points(
        "a.ply", ply(big ? "binary_big_endian" : "binary_little_endian", elements, data + "faces, cut")));
  }
  for (const PointCloud& cloud : clouds) {
    REQUIRE(cloud.x == Values{0, -1, -2});
    REQUIRE(cloud.y == Values{1.5, 1.5, 1.5});
    REQUIRE(cloud.z == Values{0.25, 1.25, 2.25});
    REQUIRE(cloud.normals == std::vector<float>{0, 0, 0, 0, 0, 1, 0, 0, 2});
  }
}

TEST_CASE("read_points: PLY and OFF in small parallel blocks give the same points") {
  std::string rows, faces;
  for (int i = 0; i < 3000; ++i) {
    rows += std::to_string(i * 0.37) + " " + std::to_string(-i) + " 1e-3\n";
    faces += "3 0 1 " + std::to_string(i) + "\n";
  }
  const BlockRule small{1, 100};
  for (const bool with_faces : {false, true}) {
    const std::string vertex = "element vertex 3000\nproperty float x\nproperty float y\nproperty double z\n";
    const std::string content =
        ply("ascii",
            "element note 1\nproperty int n\n" + vertex +
                (with_faces ? "element face 3000\nproperty list uchar int vertex_indices\n" : ""),
            "17\n" + rows + (with_faces ? faces : ""));
    const PointCloud serial = read_ply_points(content, {}, {}), blocks = read_ply_points(content, {}, small);
    REQUIRE(serial.count() == 3000);
    REQUIRE(serial.y[2999] == -2999);
    REQUIRE(same(serial, blocks));
    const std::string off = std::string("OFF 3000 ") + (with_faces ? "3000 0\n" : "0 0\n") + rows;
    const PolygonMesh a = read_off_vertices(off + (with_faces ? faces : ""), {}, {}),
                      b = read_off_vertices(off + (with_faces ? faces : ""), {}, small);
    REQUIRE(same_bits(a.x, serial.x));
    REQUIRE(same_bits(a.z, serial.z));
    REQUIRE(same_mesh(a, b));
    REQUIRE(a.polygon_count() == 0);
    // What is wrong is found in blocks too.
    std::string wrong = content;
    wrong.replace(wrong.find("-1500"), 5, "-inf!");
    REQUIRE_THROWS_WITH(read_ply_points(wrong, {}, small),
                        Catch::Matchers::ContainsSubstring("`-inf!` is not a number"));
    wrong.replace(wrong.find("-inf!"), 5, "-inf ");
    REQUIRE_THROWS_WITH(read_ply_points(wrong, {}, small),
                        Catch::Matchers::ContainsSubstring("vertex 1500 of 3000 is not finite"));
    REQUIRE_THROWS_WITH(read_off_vertices("OFF 3001 0 0\n" + rows, {}, small),
                        Catch::Matchers::ContainsSubstring("the file ends in vertex 3000 of 3001"));
  }
}

TEST_CASE("read_points: OFF with and without faces, normals and colors, text and binary") {
  const Values x = {0, 3, 6};
  REQUIRE(points("a.off", "OFF\n3 0 0\n" + three_rows).x == x);
  REQUIRE(points("a.off", "OFF\n3 2\n# a comment\n" + three_rows + "3 0 1 2\n3 9 9 9\n").x == x);
  REQUIRE(points("a.off", "OFF\n3 2 0\n" + three_rows).x == x);
  REQUIRE(points("a.off", "COFF\n3 0 0\n0 1 2 255 0 0 255\n3 4 5 1 2 3 4\n6 7 8 1 1 1 1\n").x == x);
  const PointCloud normals = points("a.off", "NOFF\n2 0 0\n0 1 2 0 0 1\n3 4 5 1 0 0\n");
  REQUIRE(normals.x == Values{0, 3});
  REQUIRE(normals.normals == std::vector<float>{0, 0, 1, 1, 0, 0});
  for (const bool big : {false, true}) {
    std::string data = "OFF BINARY\n";
    for (const int count : {3, 0, 0}) put(data, count, big);
    for (int k = 0; k < 9; ++k) put(data, static_cast<float>(k), big);
    REQUIRE(points("a.off", data).x == x);
    REQUIRE(result("a.off", data + "more") ==
            "unreadable: byte 59: data follow the 3 vertices that the header promises");
    REQUIRE(result("a.off", data.substr(0, data.size() - 1)) ==
            "unreadable: byte 11: the counts of the binary file do not fit its size");
    data.resize(data.size() - 4);
    put(data, std::numeric_limits<float>::quiet_NaN(), big);
    REQUIRE(result("a.off", data) == "non_finite: vertex 2 of 3 is not finite");
  }
}

TEST_CASE("read_points: text files of points") {
  for (const char* const name : {"a.xyz", "a.TXT", "a.csv", "a.pts"}) {
    for (const std::string& content :
         {three_rows, std::string("0,1,2\n3,4,5\n6,7,8"),
          std::string("0\t1\t2\r\n\r\n3\t4\t5\r\n6\t7\t8\r\n"),
          std::string("# made by hand\n 0 , 1, 2 # first\n\n3 ,4 ,5\n6,7,8#last\n"),
          std::string("\xEF\xBB\xBF\"X\",\"Y\",\"Z\"\n0,1,2\n3,4,5\n6,7,8\n"),
          std::string("//X Y Z Intensity\n") + three_rows, std::string("3\n") + three_rows,
          std::string("0 1 2\r3 4 5\r6 7 8"), std::string("points of a scan\n+0 1. 2e0\n3 4 5\n.6e1 7 8")}) {
      CAPTURE(name, content);
      const PointCloud cloud = points(name, content);
      REQUIRE(cloud.x == Values{0, 3, 6});
      REQUIRE(cloud.y == Values{1, 4, 7});
      REQUIRE(cloud.z == Values{2, 5, 8});
      REQUIRE(cloud.normals.empty());
    }
  }
  const PointCloud flat = points("a.txt", "x y\n0.5 0.25\n-1 2\n");
  REQUIRE(flat.x == Values{0.5, -1});
  REQUIRE(flat.y == Values{0.25, 2});
  REQUIRE(flat.z == Values{0, 0});
  const std::string utf16(
      "\xFF\xFE"
      "1\0 \0"
      "2\0\n\0",
      10);
  REQUIRE(points("a.txt", utf16).y == Values{2});
  // Equal points are points.
  REQUIRE(points("a.xyz", "1 1 1\n1 1 1\n1 1 1\n").count() == 3);
}

TEST_CASE("read_points: columns 4 to 6 of a text file are normals if they can be") {
  const std::vector<float> none;
  REQUIRE(points("a.xyz", "0 0 0 0 0 1\n1 1 1 0 0 0\n2 2 2 nan nan nan\n").normals.size() == 9);
  REQUIRE(points("a.xyz", "0 0 0 0.58 0.58 0.58 chair\n1 1 1 0 0 -1 9,9\n").normals ==
          std::vector<float>{0.58f, 0.58f, 0.58f, 0, 0, -1});
  REQUIRE(points("a.xyz", "0 0 0 0 0 1\n1 1 1 128 0 255\n2 2 2 0 1 0\n").normals == none);
  REQUIRE(points("a.xyz", "0 0 0 0 0 0\n").normals == none);
  REQUIRE(points("a.csv", "x,y,z,nx,ny,nz\n0,0,0,0,0,7\n").normals == std::vector<float>{0, 0, 7});
  REQUIRE(points("a.csv", "x,y,z,r,g,b\n0,0,0,0,0,1\n").normals == none);
  REQUIRE(points("a.pts", "1\n0 0 0 -1200 12 13 14\n").normals == none);
}

TEST_CASE("read_points: errors in text files say what and where") {
  const std::pair<const char*, const char*> wrong[] = {
      {"", "empty: the file is empty"},
      {" \n\t\n", "empty: the file holds nothing but blanks"},
      {"# nothing\n", "empty: the file holds no point"},
      {"x y z\n", "empty: the file holds no point"},
      {"0\n", "empty: the file holds no point"},
      {"1000000000000\n1 2 3\n",
       "unreadable: the first line promises 1000000000000 points, but the file holds 1"},
      {"2\n1 2 3\n1 2 3\n1 2 3\n", "unreadable: the first line promises 2 points, but the file holds 3"},
      {"1.5\n1 2 3\n", "unsupported_format: line 1: 1 number, but a point has 2, 3 or 6 and more"},
      {"1 2 3 4\n", "unsupported_format: line 1: 4 numbers, but a point has 2, 3 or 6 and more"},
      {"# a\n\n1,2,3,4,5\n", "unsupported_format: line 3: 5 numbers, but a point has 2, 3 or 6 and more"},
      {"1 2 3\n4 5\n", "unreadable: line 2: 2 numbers, but the first point has 3"},
      {"1 2\n4 5 6\n", "unreadable: line 2: 3 numbers, but the first point has 2"},
      {"1 2 3\n\n4 x 6\n", "unreadable: line 3: `x` is not a number"},
      {"C 0 0 0\n", "unreadable: line 1: `C` is not a number"},
      {"1 2 3\nx y z\n", "unreadable: line 2: `x` is not a number"},
      {"1;2;3\n4 5 6\n", "unreadable: line 1: `1;2;3` is not a number"},
      {"1 2 3\n4;5;6\n", "unreadable: line 2: `4;5;6` is not a number"},
      {"1,5 2,5 3,5\n",
       "unreadable: line 1: commas and blanks both separate numbers; a decimal mark is a point"},
      {"1,2,\n", "unreadable: line 1: nothing follows the last comma"},
      {"1,,2\n", "unreadable: line 1: nothing precedes a comma"},
      {",1,2\n", "unreadable: line 1: nothing precedes a comma"},
      {"id,x,y\n1,2,3\n",
       "unsupported_format: line 1: the columns do not begin with x y or x y z, as they must"},
      {"x y weight\n1 2 3\n",
       "unsupported_format: line 1: the columns do not begin with x y or x y z, as they must"},
      {"1 2 3\n1 nan 3\n", "non_finite: line 2: point 1 is not finite"},
      {"1 2 1e999\n", "non_finite: line 1: point 0 is not finite"},
      {"1.#INF,2,3\n", "non_finite: line 1: point 0 is not finite"},
      {"0x10 2 3\n", "unreadable: line 1: `0x10` is not a number"},
      {"\x01\x02\x7f\n1 2 3\n", "unreadable: line 1: `???` is not a number"},
      {"OFF\n1 0 0\n1 2 3\n",
       "unreadable: by its name this is a text of points, by its content it is an OFF file"},
      {"v 1 2 3\nv 1 2 3\nv 1 2 3\n",
       "unreadable: by its name this is a text of points, by its content it is an OBJ file"},
      {"PK\x03\x04", "unreadable: by its name this is a text of points, by its content it is a zip archive"}};
  for (const auto& [content, expected] : wrong) {
    CAPTURE(content);
    CHECK(result("a.xyz", content) == expected);
  }
}

TEST_CASE("read_points: errors in PLY files say what and where") {
  const auto ascii = [](const std::string& elements, const std::string& body) {
    return result("a.ply", ply("ascii", elements, body));
  };
  const std::string& head = three_vertices;
  CHECK(ascii(head, three_rows) == "3 points");
  CHECK(ascii(head, "0 1 2\n3 4 5\n6 7 8") == "3 points");
  CHECK(ascii(head, "0.125 1 2\n3 4 5.875\n\n") ==
        "unreadable: line 11: the file ends before row 2 of 3 of the element `vertex`");
  CHECK(ascii(head, three_rows + "9 9 9\n") ==
        "unreadable: line 11: `9` follows the 3 vertices that the header promises");
  CHECK(ascii(head, "0 1 2\n3 4\n5 6 7 8\n") ==
        "unreadable: line 9: row 1 of 3 of the element `vertex` is not complete on its line");
  CHECK(ascii(head + two_faces, "0 1 2\n3 4 5\n3 0\n3 0 1 2\n") ==
        "unreadable: line 12: row 2 of 3 of the element `vertex` is not complete on its line");
  CHECK(ascii(head, "0 1 2\n3 4,5 5\n6 7 8\n") ==
        "unreadable: line 9: row 1 of 3 of the element `vertex`: `4,5` is not a number");
  CHECK(ascii(head, "0 1 2\n3 4 5\n6 7 -inf\n") == "non_finite: line 10: vertex 2 of 3 is not finite");
  CHECK(ascii("element vertex 0\nproperty float x\n", "") == "empty: the header promises no vertex");
  CHECK(ascii("element face 0\n", "") == "unreadable: the header has no element vertex");
  CHECK(ascii("element vertex 1\nproperty float x\nproperty float y\n", "1 2\n") ==
        "unreadable: the element vertex has no property z");
  CHECK(result("a.ply", "ply\nformat ascii 1.0\n") == "unreadable: line 3: the header has no end_header");
  CHECK(result("a.ply", three_rows) == "unreadable: line 1: not a PLY file: it does not begin with `ply`");
  for (const char* const count : {"1000", "999999999999999999", "99999999999999999999999"}) {
    const std::string huge =
        std::string("element vertex ") + count + "\nproperty float x\nproperty float y\nproperty float z\n";
    CHECK_THAT(ascii(huge, three_rows),
               Catch::Matchers::StartsWith("unreadable: the header promises ") &&
                   Catch::Matchers::EndsWith(" vertices, but only 19 bytes follow it"));
    CHECK_THAT(result("a.ply", ply("binary_little_endian", huge, three_rows)),
               Catch::Matchers::StartsWith("unreadable: the header promises ") &&
                   Catch::Matchers::EndsWith(" vertices, but only 18 bytes follow it"));
    CHECK(ascii(std::string("element other ") + count + "\nproperty int a\n" + head, three_rows) ==
          "unreadable: line 13: the file ends before the vertices");
    CHECK_THAT(
        result("a.ply", ply("binary_big_endian",
                            std::string("element other ") + count + "\nproperty int a\n" + head, three_rows)),
        Catch::Matchers::ContainsSubstring("row 4 of ") &&
            Catch::Matchers::EndsWith("of the element `other` is not complete"));
  }
  // A list longer than the file, and one of negative length.
  const std::string listed =
      "element vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
      "property list int double l\n";
  for (const int length : {1 << 30, -1}) {
    std::string data(12, '\0');
    put(data, length, false);
    CHECK_THAT(result("a.ply", ply("binary_little_endian", listed, data)),
               Catch::Matchers::EndsWith("row 0 of 1 of the element `vertex` is not complete"));
    CHECK_THAT(ascii(listed, "1 2 3 " + std::to_string(length) + " 1\n"),
               Catch::Matchers::StartsWith("unreadable: line 9: row 0 of 1 of the element `vertex`"));
  }
  for (const bool big : {false, true}) {
    const char* const format = big ? "binary_big_endian" : "binary_little_endian";
    std::string data;
    for (int k = 0; k < 9; ++k) put(data, static_cast<float>(k), big);
    CHECK(result("a.ply", ply(format, head, data)) == "3 points");
    CHECK(result("a.ply", ply(format, head, data + "\n")) == "3 points");
    CHECK_THAT(result("a.ply", ply(format, head, data + "x")),
               Catch::Matchers::StartsWith("unreadable: byte ") &&
                   Catch::Matchers::EndsWith(": data follow the 3 vertices that the header promises"));
    CHECK(result("a.ply", ply(format, head, data.substr(1))) ==
          "unreadable: the header promises 3 vertices, but only 35 bytes follow it");
    data.resize(32);
    put(data, std::numeric_limits<float>::infinity(), big);
    CHECK(result("a.ply", ply(format, head, data)) == "non_finite: vertex 2 of 3 is not finite");
  }
}

TEST_CASE("read_points: errors in OFF files say what and where") {
  CHECK(result("a.off", "OFF\n0 0 0\n") == "empty: the header promises no vertex");
  CHECK(result("a.off", "OFF\n4 0 0\n0.5 1.25 2\n3 4 5\n6 7 8.125\n") ==
        "unreadable: line 6: the file ends in vertex 3 of 4");
  CHECK(result("a.off", "OFF\n2 0 0\n" + three_rows) ==
        "unreadable: line 5: `6` follows the 2 vertices that the header promises");
  CHECK(result("a.off", "OFF\n4 1 0\n" + three_rows + "3 0 1 2\n3 1 2 0\n") ==
        "unreadable: line 6: `2` follows vertex 3 of 4 on its line, where all before it end theirs: "
        "a number or a vertex too many or too few");
  CHECK(result("a.off", "OFF\n3 0 0\n0 1 2\n3 4 five\n6 7 8\n") ==
        "unreadable: line 4: vertex 1 of 3: `five` is not a number");
  CHECK(result("a.off", "OFF\n3 0 0\n0 1 2\n3 nan 5\n6 7 8\n") ==
        "non_finite: line 4: vertex 1 of 3 is not finite");
  CHECK(result("a.off", "4OFF\n1 0 0\n0 1 2 0\n") == "non_finite: line 3: vertex 0 of 1 is not finite");
  CHECK(result("a.off", "OFF\n400000000 0 0\n" + three_rows) ==
        "unreadable: the header promises 400000000 vertices, but only 19 bytes follow it");
  CHECK(result("a.off", "nOFF\n5\n1 0 0\n") ==
        "unsupported_format: nOFF: vertices of 5 dimensions are not supported");
  // The reader of meshes still wants faces.
  CHECK(outcome("OFF\n3 0 0\n" + three_rows, MeshFormat::off) ==
        "empty: the header promises 3 vertices and no face");
}

namespace {

// A file of numpy, whose dictionary is filled up to what numpy aligns to.
std::string npy(std::string_view dictionary, const std::string& data, char version = 1) {
  std::string text(dictionary);
  const std::size_t length_bytes = version == 1 ? 2 : 4;
  while ((8 + length_bytes + text.size() + 1) % 64 != 0) text += ' ';
  text += '\n';
  std::string file("\x93NUMPY", 6);
  file += version;
  file += '\0';
  for (std::size_t k = 0; k < length_bytes; ++k) file += static_cast<char>(text.size() >> (8 * k) & 0xFF);
  return file + text + data;
}

template <class T>
std::string reals(std::initializer_list<double> values, bool big_endian) {
  std::string data;
  for (const double value : values) put(data, static_cast<T>(value), big_endian);
  return data;
}

std::string npy_dictionary(const std::string& type, const std::string& shape, bool fortran = false) {
  return "{'descr': '" + type + "', 'fortran_order': " + (fortran ? "True" : "False") +
         ", 'shape': " + shape + ", }";
}

}  // namespace

TEST_CASE("read_points: NumPy arrays in both precisions, byte orders and layouts") {
  const auto rows = {1.5, -2.0, 3.25, 4.0, 5.0, -6.5};
  const auto columns = {1.5, 4.0, -2.0, 5.0, 3.25, -6.5};
  for (const bool big : {false, true})
    for (const bool fortran : {false, true})
      for (const char version : {'\1', '\2', '\3'}) {
        const std::string order = big ? ">" : "<";
        const auto values = fortran ? columns : rows;
        for (const PointCloud& cloud : {points("a.npy", npy(npy_dictionary(order + "f4", "(2, 3)", fortran),
                                                            reals<float>(values, big), version)),
                                        points("a.NPY", npy(npy_dictionary(order + "f8", "(2, 3)", fortran),
                                                            reals<double>(values, big), version))}) {
          CHECK(cloud.x == Values{1.5, 4});
          CHECK(cloud.y == Values{-2, 5});
          CHECK(cloud.z == Values{3.25, -6.5});
          CHECK(cloud.normals.empty());
        }
      }
  // Two columns are the plane; normals and other columns as in text.
  const PointCloud flat =
      points("a.npy", npy(npy_dictionary("<f8", "(3, 2)"), reals<double>({1, 2, 3, 4, 5, 6}, false)));
  CHECK(flat.y == Values{2, 4, 6});
  CHECK(flat.z == Values{0, 0, 0});
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK(points("a.npy", npy(npy_dictionary("<f8", "(2, 6)"),
                            reals<double>({0, 0, 0, 0, 0, 1, 1, 1, 1, nan, nan, nan}, false)))
            .normals.size() == 6);
  CHECK(points("a.npy", npy(npy_dictionary("<f4", "(7, 7)"), std::string(4 * 49, '\0'))).count() == 7);
  CHECK(points("a.npy", npy(npy_dictionary("<f8", "(1, 6)"), reals<double>({0, 0, 0, 9, 9, 9}, false)))
            .normals == std::vector<float>());
  // What other writers do: other quotes and orders of keys, no last comma, no blanks, long integers, zeros to
  // fill.
  CHECK(points("a.npy",
               npy("{\"shape\":(1L,2L),\"fortran_order\":False,\"descr\":\"<f4\"}" + std::string(3, '\0'),
                   reals<float>({1, 2}, false)))
            .y == Values{2});
}

TEST_CASE("read_points: errors in NumPy arrays say what is wrong") {
  const std::string two = reals<double>({1, 2}, false);
  const double infinity = std::numeric_limits<double>::infinity();
  const std::pair<std::string, std::string> cases[] = {
      {"", "empty: the file is empty"},
      {"1 2 3\n", "unreadable: the file does not begin as .npy files do"},
      {"\x1F\x8B", "unreadable: by its name this is an array of numpy, by its content it is a gzip archive"},
      {std::string("\x93NUMPY\x01", 7), "unreadable: the header of the array is not complete"},
      {std::string("\x93NUMPY\x02\0\xFF", 9), "unreadable: the header of the array is not complete"},
      {std::string("\x93NUMPY\x02\0\xFF\xFF\xFF\xFF", 12) + "{",
       "unreadable: the header of the array promises 4294967295 bytes of itself, but 1 follow"},
      {npy(npy_dictionary("<f8", "(1, 2)"), two, 4),
       "unsupported_format: version 4 of the .npy format is not known: 1 to 3 are"},
      {npy("", two),
       "unreadable: the header of the array is no dictionary that numpy writes: `{` is missing"},
      {npy("{'descr': '<f8", two), "unreadable: the header of the array has a text without an end"},
      {npy("{'descr': '<f8', 'shape': (1, 2)}", two),
       "unreadable: the header of the array lacks one of descr, fortran_order and shape"},
      {npy("{'descr': '<f8', 'fortran_order': 0, 'shape': (1, 2)}", two),
       "unreadable: the header of the array says neither True nor False for fortran_order"},
      {npy(npy_dictionary("<f8", "(1, -2)"), two),
       "unreadable: the header of the array has a shape that is no tuple of sizes"},
      {npy(npy_dictionary("<f8", "(99999999999999999999999, 2)"), two),
       "unreadable: the header of the array has a shape that is no tuple of sizes"},
      {npy(npy_dictionary("<f8", "(1, 2)") + "x", two),
       "unreadable: the header of the array goes on behind its dictionary"},
      {npy("{'order': 'C'}", two),
       "unreadable: the header of the array has a key besides descr, fortran_order and shape"},
      {npy("{'descr': [('x', '<f8'), ('y', '<f8', (1,))], 'fortran_order': False, 'shape': (1,)}", two),
       "unsupported_format: the array has fields; points are a plain array of float32 or float64"},
      {npy("{'descr': [('x', '<f8')", two), "unreadable: the header of the array has a list without an end"},
      {npy(npy_dictionary("|O", "(1, 2)"), two),
       "unsupported_format: the array has values of the type `|O`; points are float32 or float64: save "
       "array.astype('<f8')"},
      {npy(npy_dictionary("<i4", "(1, 2)"), two),
       "unsupported_format: the array has values of the type `<i4`; points are float32 or float64: save "
       "array.astype('<f8')"},
      {npy(npy_dictionary("<f8", "(2,)"), two),
       "unsupported_format: the array has 1 dimensions; points have two: a row for each"},
      {npy(npy_dictionary("<f8", "()"), two),
       "unsupported_format: the array has 0 dimensions; points have two: a row for each"},
      {npy(npy_dictionary("<f8", "(0, 3)"), ""), "empty: the array has no row"},
      {npy(npy_dictionary("<f8", "(3, 0)"), ""),
       "unsupported_format: the array has the shape (3, 0), but a point has 2, 3 or 6 and more numbers"},
      {npy(npy_dictionary("<f8", "(3, 4)"), two),
       "unsupported_format: the array has the shape (3, 4), but a point has 2, 3 or 6 and more numbers"},
      {npy(npy_dictionary("<f8", "(3, 1000)"), two),
       "unsupported_format: the array has the shape (3, 1000): a point is a row; is it transposed?"},
      {npy(npy_dictionary("<f8", "(2, 2)"), two),
       "unreadable: the header promises 2 x 2 values of 8 bytes, but only 16 bytes follow it"},
      {npy(npy_dictionary("<f8", "(4611686018427387905, 2)"), two),
       "unreadable: the header promises 4611686018427387905 x 2 values of 8 bytes, but only 16 bytes follow "
       "it"},
      {npy(npy_dictionary("<f8", "(18446744073709551615, 18446744073709551615)"), two),
       "unreadable: the header promises 18446744073709551615 x 18446744073709551615 values of 8 bytes, but "
       "only 16 "
       "bytes follow it"},
      {npy(npy_dictionary("<f4", "(1, 2)"), two),
       "unreadable: 8 bytes follow the values that the header promises"},
      {npy(npy_dictionary("<f8", "(2, 2)"), two + reals<double>({3, infinity}, false)),
       "non_finite: point 1 of 2 is not finite"}};
  for (const auto& [content, expected] : cases) CHECK(result("a.npy", content) == expected);
}

namespace {

std::string array(const std::string& type, const std::string& shape, const std::string& data) {
  return npy(npy_dictionary(type, shape), data);
}

std::string npz(const std::vector<std::pair<std::string, std::string>>& arrays, bool deflate) {
  std::vector<ArchiveEntry> entries;
  for (const auto& [name, content] : arrays) {
    ArchiveEntry& entry = entries.emplace_back();
    entry.name = name;
    entry.content = content;
    entry.deflate = deflate;
  }
  return zip_bytes(entries);
}

}  // namespace

TEST_CASE("read_points: archives of NumPy arrays, packed or not, with normals, density and frame") {
  const std::string places = array("<f4", "(2, 3)", reals<float>({1, 2, 3, 4, 5, 6}, false)),
                    normals = array(">f8", "(2, 3)", reals<double>({0, 0, 1, 0, 1, 0}, true)),
                    density = array("<f4", "(2,)", reals<float>({1, 3}, false)),
                    loc = array("<f8", "(3,)", reals<double>({10, 20, 30}, false)),
                    scale = array("<f8", "()", reals<double>({2}, false)),
                    stored =
                        array("<U6", "()", std::string("s\0\0\0t\0\0\0o\0\0\0r\0\0\0e\0\0\0d\0\0\0", 24)),
                    file = array("<U4", "()", std::string("f\0\0\0i\0\0\0l\0\0\0e\0\0\0", 16));
  for (const bool deflate : {false, true}) {
    const PointCloud all = points("a.npz", npz({{"rgb.npy", array("|u1", "(2, 3)", "abcdef")},
                                                {"points.npy", places},
                                                {"normals.npy", normals},
                                                {"density.npy", density},
                                                {"frame.npy", stored},
                                                {"loc.npy", loc},
                                                {"scale.npy", scale}},
                                               deflate));
    CHECK(all.x == Values{12, 18});
    CHECK(all.y == Values{24, 30});
    CHECK(all.z == Values{36, 42});
    CHECK(all.normals == std::vector<float>{0, 0, 1, 0, 1, 0});
    CHECK(all.density == Values{1, 3});
    const PointCloud placed = points(
        "a.npz",
        npz({{"points.npy", places}, {"frame.npy", file}, {"loc.npy", loc}, {"scale.npy", scale}}, deflate));
    CHECK(placed.x == Values{1, 4});
    CHECK(placed.normals.empty());
    CHECK(points("a.npz", npz({{"arr_0.npy", places}}, deflate)).y == Values{2, 5});
  }
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"1 2 3\n", "unreadable: the file does not begin as .npz files, which are zip archives, do"},
      {npz({{"a.txt", places}}, true), "unsupported_format: the archive holds no array"},
      {npz({{"pos.npy", places}, {"neg.npy", places}}, true),
       "unsupported_format: the archive holds several arrays and none is called `points`: `pos`, `neg`"},
      {npz({{"points.npy", places}, {"normals.npy", array("<f4", "(1, 3)", reals<float>({0, 0, 1}, false))}},
           true),
       "unsupported_format: the array `normals`: its shape is not that of the points"},
      {npz({{"points.npy", places}, {"density.npy", array("<f4", "(2,)", reals<float>({1}, false))}}, true),
       "unreadable: the array `density`: its values are not as many as its header promises"},
      {npz({{"points.npy", places}, {"frame.npy", stored}}, true),
       "unreadable: the points are in the frame `stored`, without `loc` and `scale`"}};
  for (const auto& [content, expected] : cases) CHECK(result("a.npz", content) == expected);
}

TEST_CASE("read_points: other kinds of files and missing files are refused") {
  const ScratchFolder folder;
  CHECK(result("a.las", "x") ==
        "unsupported_format: the extension `.las` is none of .ply .off .xyz .txt .csv .pts .npy .npz");
  CHECK(result("points", "1 2 3\n") ==
        "unsupported_format: a name without extension is none of .ply .off .xyz .txt .csv .pts .npy .npz");
  CHECK(result("a.off", ply("ascii", three_vertices, three_rows)) ==
        "unreadable: by its name this is an OFF file, by its content it is a PLY file");
  CHECK_THROWS_WITH(read_points(folder / "absent.ply"),
                    "the file cannot be opened: No such file or directory");
  std::filesystem::create_directory(folder / "a.xyz");
  CHECK_THROWS_WITH(read_points(folder / "a.xyz"), "not a regular file");
  std::atomic<bool> canceled{true};
  CancelToken cancel;
  cancel.canceled = &canceled;
  CHECK_THROWS_AS(read_points(folder / "a.xyz", cancel), RunCanceled);
}

TEST_CASE("read_points: every truncation and every changed byte gives points or an error") {
  const std::string contents[] = {
      ply("ascii", three_vertices + two_faces, three_rows + "3 0 1 2\n3 0 1 2\n"),
      ply("binary_big_endian", three_vertices + "property list uchar uchar l\n", std::string(39, '\0')),
      "NOFF\n3 0 0\n0 1 2 1 0 0\n3 4 5 1 0 0\n6 7 8 1 0 0\n",
      std::string("OFF BINARY\n\0\0\0\1\0\0\0\0\0\0\0\0", 23) + std::string(12, '\0'),
      "x,y,z,nx,ny,nz\n0,1,2,0,0,1\n3, 4, 5, 1.#INF, 0, 0\n",
      npy(npy_dictionary(">f4", "(3, 2)", true), std::string(24, '\0')),
      npz({{"points.npy", array("<f4", "(1, 3)", std::string(12, '\0'))},
           {"normals.npy", array("<f4", "(1, 3)", std::string(12, '\0'))}},
          true)};
  const char* const names[] = {"a.ply", "a.ply", "a.off", "a.off", "a.csv", "a.npy", "a.npz"};
  std::size_t read = 0, refused = 0;
  for (std::size_t f = 0; f < std::size(contents); ++f) {
    const auto attempt = [&](std::string_view content) {
      try {
        const PointCloud cloud = points(names[f], content);
        ++read;
        const bool sound = cloud.count() > 0 && cloud.y.size() == cloud.count() &&
                           cloud.z.size() == cloud.count() &&
                           (cloud.normals.empty() || cloud.normals.size() == 3 * cloud.count());
        if (!sound) FAIL("an unsound cloud from " << content);
      } catch (const ItemError& error) {
        ++refused;
        if (std::string_view(error.what()).empty()) FAIL("no sentence");
      }
    };
    for (std::size_t size = 0; size <= contents[f].size(); ++size) attempt(contents[f].substr(0, size));
    for (std::size_t at = 0; at < contents[f].size(); ++at)
      for (const char byte : {'\0', '\xFF', '9', ',', '\n', '#'}) {
        std::string changed = contents[f];
        changed[at] = byte;
        attempt(changed);
      }
  }
  REQUIRE(read > 100);
  REQUIRE(refused > 500);
}
