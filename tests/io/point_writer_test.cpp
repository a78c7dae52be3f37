#include "io/mesh/point_writer.h"

#include <cmath>
#include <sstream>

#include "io/mesh/point_reader.h"
#include "io/point_files.h"
#include "io/reading.h"
#include "io/run_error.h"
#include "support/mesh_files.h"

using namespace meander;
using namespace meander::test;

namespace {

Samples three_samples() {
  Samples samples;
  samples.points = {0, 0, 0, 0.1f, -0.25f, 1, 1e-20f, 3, 1.0f / 3};
  samples.normals = {0, 0, 1, 0.6f, 0.8f, 0, -1, 0, 0};
  samples.face = {5, 0, 4000000000u};
  samples.corners.assign(9, 0);
  samples.barycentric.assign(6, 0.25f);
  samples.curve_rank = {0, 1, 2};
  samples.density = {1, 0.5f, 2};
  return samples;
}

ItemReport placed() {
  ItemReport report;
  report.loc = {1e8, -0.125, 3};
  report.scale = 0.3;
  return report;
}

double coordinate(const Samples& samples, const ItemReport& report, std::size_t i, std::size_t k) {
  return report.loc[k] + report.scale * double{samples.points[3 * i + k]};
}

}  // namespace

TEST_CASE("write_points: XYZ holds positions in file coordinates and normals, digit for digit") {
  const ScratchFolder folder;
  const Samples samples = three_samples();
  write_points(folder / "a.xyz", PointFormat::xyz, samples, placed());
  std::istringstream text(read_file(folder / "a.xyz"));
  for (std::size_t i = 0; i < 3; ++i) {
    std::string line;
    REQUIRE(std::getline(text, line));
    std::istringstream row(line);
    double value = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      REQUIRE(row >> value);
      REQUIRE(value == coordinate(samples, placed(), i, k));
    }
    for (std::size_t k = 0; k < 3; ++k) {
      REQUIRE(row >> value);
      REQUIRE(static_cast<float>(value) == samples.normals[3 * i + k]);
    }
    REQUIRE_FALSE(row >> value);
  }
  std::string rest;
  REQUIRE(std::getline(text, rest));
  REQUIRE(rest == "# frame file");
  REQUIRE_FALSE(std::getline(text, rest));
}

TEST_CASE("write_points: OFF has vertices and no faces") {
  const ScratchFolder folder;
  Samples samples = three_samples();
  write_points(folder / "a.off", PointFormat::off, samples, placed());
  std::string content = read_file(folder / "a.off");
  REQUIRE(content.starts_with("OFF\n3 0 0\n"));
  REQUIRE(content.ends_with("\n# frame file\n"));
  // With a face added it is a mesh with these vertices.
  content.replace(4, 5, "3 1 0");
  const PolygonMesh mesh = read(content + "3 0 1 2\n", MeshFormat::off);
  for (std::size_t i = 0; i < 3; ++i) {
    REQUIRE(mesh.x[i] == coordinate(samples, placed(), i, 0));
    REQUIRE(mesh.y[i] == coordinate(samples, placed(), i, 1));
    REQUIRE(mesh.z[i] == coordinate(samples, placed(), i, 2));
  }
}

TEST_CASE("write_points: PLY reads back with normals, faces and densities") {
  const ScratchFolder folder;
  const Samples samples = three_samples();
  write_points(folder / "a.ply", PointFormat::ply, samples, placed());
  std::string content = read_file(folder / "a.ply");
  REQUIRE(
      content.starts_with("ply\nformat binary_little_endian 1.0\ncomment frame file\nelement vertex 3\n"));
  const std::string end = "end_header\n";
  content.replace(content.find(end), end.size(),
                  "element face 1\nproperty list uchar uchar vertex_indices\n" + end);
  const PolygonMesh mesh = read(content + std::string("\3\0\1\2", 4), MeshFormat::ply);
  for (std::size_t i = 0; i < 3; ++i) {
    REQUIRE(mesh.x[i] == coordinate(samples, placed(), i, 0));
    REQUIRE(mesh.y[i] == coordinate(samples, placed(), i, 1));
    REQUIRE(mesh.z[i] == coordinate(samples, placed(), i, 2));
  }
  REQUIRE(mesh.normals == samples.normals);
  REQUIRE(mesh.vertex_attributes.size() == 2);
  REQUIRE(mesh.vertex_attributes[0].name == "face");
  REQUIRE(mesh.vertex_attributes[0].values == std::vector<double>{5, 0, 4000000000.0});
  REQUIRE(mesh.vertex_attributes[1].name == "density");
  REQUIRE(mesh.vertex_attributes[1].values == std::vector<double>{1, 0.5, 2});
}

TEST_CASE("write_points: the stored frame gives float32 and the transform to the file") {
  const ScratchFolder folder;
  const Samples samples = three_samples();
  const std::string words = "frame stored loc 1e+08 -0.125 3 scale 0.3";
  for (const auto& [name, format] :
       {std::pair{"a.ply", PointFormat::ply}, {"a.off", PointFormat::off}, {"a.xyz", PointFormat::xyz}}) {
    INFO(name);
    write_points(folder / name, format, samples, placed(), PointFrame::stored);
    const std::string content = read_file(folder / name);
    if (format == PointFormat::ply)
      CHECK(content.find("\ncomment " + words + "\nelement vertex 3\nproperty float x\n") !=
            std::string::npos);
    else
      CHECK(content.ends_with("\n# " + words + "\n"));
    const PointCloud cloud = read_points(folder / name);
    REQUIRE(cloud.count() == 3);
    // Digit for digit: as float32 writes and reads itself.
    for (std::size_t i = 0; i < 3; ++i) {
      CHECK(static_cast<float>(cloud.x[i]) == samples.points[3 * i]);
      CHECK(static_cast<float>(cloud.y[i]) == samples.points[3 * i + 1]);
      CHECK(static_cast<float>(cloud.z[i]) == samples.points[3 * i + 2]);
    }
    if (format != PointFormat::off) CHECK(cloud.normals == samples.normals);
  }
  CHECK(read_file(folder / "a.xyz").starts_with("0 0 0 0 0 1\n0.1 -0.25 1 0.6 0.8 0\n"));
}

TEST_CASE("write_points: more than one buffer, and no points at all") {
  const ScratchFolder folder;
  Samples samples;
  for (std::uint32_t i = 0; i < 100000; ++i) {
    for (int k = 0; k < 3; ++k) {
      samples.points.push_back(static_cast<float>(i) / 3);
      samples.normals.push_back(0);
    }
    samples.face.push_back(i);
    samples.density.push_back(1);
  }
  write_points(folder / "a.ply", PointFormat::ply, samples, {});
  const std::string content = read_file(folder / "a.ply");
  const std::size_t body = content.find("end_header\n") + 11;
  REQUIRE(content.size() - body == 44 * 100000);
  for (const PointFormat format : {PointFormat::ply, PointFormat::off, PointFormat::xyz})
    REQUIRE_NOTHROW(write_points(folder / "none", format, {}, {}));
  REQUIRE(read_file(folder / "none") == "# frame file\n");
}

TEST_CASE("write_points: the old file stays when writing fails, and no temporary file is left") {
  const ScratchFolder folder;
  REQUIRE_THROWS_AS(write_points(folder / "absent" / "a.xyz", PointFormat::xyz, three_samples(), {}),
                    RunError);
  std::filesystem::create_directory(folder / "a.xyz");  // a name that no file can take
  REQUIRE_THROWS_AS(write_points(folder / "a.xyz", PointFormat::xyz, three_samples(), {}), RunError);
  REQUIRE(std::distance(std::filesystem::directory_iterator(folder.path()), {}) == 1);
  write_points(folder / "b.xyz", PointFormat::xyz, three_samples(), {});
  write_points(folder / "b.xyz", PointFormat::xyz, {}, {});
  REQUIRE(read_file(folder / "b.xyz") == "# frame file\n");
}

TEST_CASE("is_written_points: what write_points wrote, and nothing else") {
  const ScratchFolder folder;
  const auto is = [&](const std::string& bytes) {
    write_file(folder / "a", bytes);
    return is_written_points(folder / "a");
  };
  ItemReport far = placed();  // the longest numbers that there are
  far.loc = {-1.2345678901234567e-300, -1.2345678901234567e-300, -1.2345678901234567e-300};
  for (const ItemReport& report : {placed(), far})
    for (const PointFrame frame : {PointFrame::file, PointFrame::stored})
      for (const PointFormat format : {PointFormat::ply, PointFormat::off}) {
        write_points(folder / "p", format, three_samples(), report, frame);
        const std::string bytes = read_file(folder / "p");
        CHECK(is(bytes));
        CHECK_FALSE(is(bytes.substr(1)));
        CHECK_FALSE(is(bytes.substr(0, 30)));
        if (format == PointFormat::off) CHECK_FALSE(is(bytes.substr(0, bytes.size() - 8)));
      }
  for (const char* other : {"", "ply\nformat binary_little_endian 1.0\nelement vertex 1\n",
                            "ply\nformat binary_little_endian 1.0\ncomment frame filed\n", "OFF\n",
                            "OFF\n1 0 0\n0 0 0\n", "OFF\n1 0 0\n0 0 0\n# frame filed\n",
                            "OFF\n1 1 0\n0 0 0\n# frame file\n", "OFF\n1 0 0\n0 0 0\n# frame file"})
    CHECK_FALSE(is(other));
  CHECK_FALSE(is_written_points(folder / "none"));
  CHECK_FALSE(is_written_points(folder.path()));
}
