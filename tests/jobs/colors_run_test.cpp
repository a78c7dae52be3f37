// `run --colors` as a user sees it: /rgb of every source, its counts, and all that is done with stores.
#include <filesystem>

#include "io/store/store_reader.h"
#include "support/archive_files.h"
#include "support/catch.h"
#include "support/meander_program.h"
#include "support/mesh_files.h"
#include "support/store_rows.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;
using Catch::Matchers::ContainsSubstring;

namespace {

namespace fs = std::filesystem;
using Words = std::vector<std::string>;

constexpr const char* cube_corners =
    "v -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\nv -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1\n";
// The bottom has no material, the top a missing one.
const std::string painted_cube = std::string("mtllib paint/cube.mtl\n") + cube_corners +
                                 "f 4 3 2 1\nusemtl red\nf 1 2 6 5\nf 2 3 7 6\nusemtl green\nf 3 4 8 7\n"
                                 "f 4 1 5 8\nusemtl none\nf 5 6 7 8\n";

void put_painted_models(const fs::path& folder) {
  fs::create_directories(folder / "paint");
  write_file(folder / "cube.obj", painted_cube);
  write_file(folder / "paint/cube.mtl", "newmtl red\nKd 1 0 0\nnewmtl green\nKd 0 0.2 0\n");
  write_file(folder / "lost.obj", "mtllib lost.mtl\n" + std::string(cube_corners) + "usemtl a\nf 1 2 3 4\n");
  write_file(folder / "faces.off",
             "OFF\n4 2 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2 255 0 0\n3 0 2 3 0 0 255\n");
  write_file(folder / "vertices.obj", "v 0 0 0 0 0 1\nv 1 0 0 1 0 1\nv 0 1 0 0 1 1\nf 1 2 3\n");
  write_mesh(folder / "plain.stl", cube());
  write_file(folder / "broken.off", "OFF\nnothing\n");
}

ProcessResult run_colors(const fs::path& input, const fs::path& store, const Words& more = {"--colors"}) {
  Words arguments = {"run", input.string(), "-o", store.string(), "-n", "200", "--progress", "none"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return meander_with(arguments);
}

using Rgb = std::array<int, 3>;
Rgb color(const Samples& samples, std::size_t i) {
  return {samples.rgb[3 * i], samples.rgb[3 * i + 1], samples.rgb[3 * i + 2]};
}

}  // namespace

TEST_CASE("run --colors: every sample has the color of its place, and missing ones are counted") {
  const ScratchFolder scratch;
  put_painted_models(scratch / "in");
  const ProcessResult result = run_colors(scratch / "in", scratch / "s.h5");
  INFO(result.out << result.err);
  REQUIRE(result.exit_code == 3);
  CHECK_THAT(result.out, ContainsSubstring("colors: none") && ContainsSubstring("colors: material") &&
                             ContainsSubstring("colors: face") && ContainsSubstring("colors: vertex"));
  CHECK_THAT(result.out, ContainsSubstring("color fills"));
  CHECK(StoreReader(scratch / "s.h5").columns() == StoreColumns{.asked = ColumnSet(&Samples::rgb)});

  const Row cube = row_of(scratch / "s.h5", "cube.obj");
  CHECK(cube.report.color_source == ColorSource::material);
  std::uint32_t fills = 0;
  for (std::size_t i = 0; i < 200; ++i) {
    const std::uint32_t face = cube.samples.face[i];
    const Rgb expected = face == 1 || face == 2   ? Rgb{255, 0, 0}
                         : face == 3 || face == 4 ? Rgb{0, 51, 0}
                                                  : Rgb{204, 204, 204};
    CHECK(color(cube.samples, i) == expected);
    fills += face == 0 || face == 5 ? 1 : 0;
  }
  CHECK(cube.report.color_fills == fills);
  CHECK(fills > 0);

  const Row faces = row_of(scratch / "s.h5", "faces.off");
  for (std::size_t i = 0; i < 200; ++i)
    CHECK(color(faces.samples, i) == (faces.samples.face[i] == 0 ? Rgb{255, 0, 0} : Rgb{0, 0, 255}));

  const Row vertices = row_of(scratch / "s.h5", "vertices.obj");
  CHECK(vertices.report.color_fills == 0);
  for (std::size_t i = 0; i < 200; ++i)
    for (std::size_t k = 0; k < 2; ++k)
      CHECK(std::abs(vertices.samples.rgb[3 * i + k] - 255 * vertices.samples.points[3 * i + k]) < 0.51);

  for (const char* id : {"lost.obj", "plain.stl"}) {
    const Row row = row_of(scratch / "s.h5", id);
    CHECK(row.report.status == Status::ok);
    CHECK(row.report.color_source == ColorSource::none);
    CHECK(row.report.color_fills == 200);
    CHECK(color(row.samples, 7) == Rgb{204, 204, 204});
  }
  const ProcessResult verified = meander_with({"verify", scratch / "s.h5"});
  INFO(verified.out << verified.err);
  CHECK(verified.exit_code == 0);
}

TEST_CASE("run --colors: the points are the same as without colors") {
  const ScratchFolder scratch;
  put_painted_models(scratch / "in");
  REQUIRE(run_colors(scratch / "in", scratch / "plain.h5", {}).exit_code == 3);
  REQUIRE(run_colors(scratch / "in", scratch / "colored.h5").exit_code == 3);
  for (const char* id : {"cube.obj", "faces.off", "vertices.obj", "plain.stl"}) {
    const Row plain = row_of(scratch / "plain.h5", id), colored = row_of(scratch / "colored.h5", id);
    CHECK(plain.samples.points == colored.samples.points);
    CHECK(plain.report.content_sha256 == colored.report.content_sha256);
    CHECK(plain.samples.rgb.empty());
  }
  // One store is not continued as the other.
  const ProcessResult result = run_colors(scratch / "in", scratch / "plain.h5");
  CHECK(result.exit_code == 2);
  CHECK_THAT(result.err, ContainsSubstring("colors"));
}

TEST_CASE("run --colors: a folder, zip and tar with material libraries give the same bytes") {
  const ScratchFolder scratch;
  put_painted_models(scratch / "folder/set");
  const std::vector<ArchiveEntry> entries = entries_of(scratch / "folder/set");
  for (const char* kind : {"zip", "tar", "tgz"}) fs::create_directories(scratch / kind);
  write_file(scratch / "zip/set.zip", zip_bytes(entries));
  write_file(scratch / "tar/set.tar", tar_bytes(entries));
  write_file(scratch / "tgz/set.tar.gz", gzip_bytes(tar_bytes(entries)));
  REQUIRE(run_colors(scratch / "folder/set", scratch / "folder.h5").exit_code == 3);
  const std::string expected = read_file(scratch / "folder.h5");
  for (const char* kind : {"zip/set.zip", "tar/set.tar", "tgz/set.tar.gz"}) {
    const ProcessResult result = run_colors(scratch / kind, scratch / "archive.h5", {"--colors", "--fresh"});
    INFO(kind << result.out << result.err);
    CHECK(result.exit_code == 3);
    CHECK(read_file(scratch / "archive.h5") == expected);
  }
}

TEST_CASE(
    "run --colors: shards, threads and a second run give the same bytes, and describe and export keep them") {
  const ScratchFolder scratch;
  put_painted_models(scratch / "in");
  REQUIRE(run_colors(scratch / "in", scratch / "s.h5", {"--colors", "-j", "1"}).exit_code == 3);
  const std::string expected = read_file(scratch / "s.h5");
  REQUIRE(run_colors(scratch / "in", scratch / "two.h5", {"--colors", "-j", "2", "--fresh"}).exit_code == 3);
  CHECK(read_file(scratch / "two.h5") == expected);
  REQUIRE(run_colors(scratch / "in", scratch / "s.h5").exit_code == 3);
  CHECK(read_file(scratch / "s.h5") == expected);

  const ProcessResult described =
      meander_with({"describe", scratch / "s.h5", "--descriptors", "d2", "-o", scratch / "described.h5"});
  INFO(described.out << described.err);
  REQUIRE(described.exit_code == 0);
  CHECK(row_of(scratch / "described.h5", "cube.obj").samples.rgb ==
        row_of(scratch / "s.h5", "cube.obj").samples.rgb);
  REQUIRE(meander_with({"export", scratch / "s.h5", "cube.obj", "-o", scratch / "out"}).exit_code == 0);
  const std::string ply = read_file(scratch / "out/cube.obj.ply");
  CHECK_THAT(
      ply, ContainsSubstring("property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n"));
  const std::size_t body = ply.find("end_header\n") + 11;
  const Samples samples = row_of(scratch / "s.h5", "cube.obj").samples;
  constexpr std::size_t row_bytes = 3 * 8 + 3 * 4 + 4 + 4 + 3;
  REQUIRE(ply.size() == body + 200 * row_bytes);
  for (std::size_t i = 0; i < 200; ++i)
    CHECK(static_cast<std::uint8_t>(ply[body + (i + 1) * row_bytes - 3]) == samples.rgb[3 * i]);
}

TEST_CASE("run --colors: a changed material library is detected, and --reuse does not take its old colors") {
  const ScratchFolder scratch;
  put_painted_models(scratch / "in");
  REQUIRE(run_colors(scratch / "in", scratch / "old.h5").exit_code == 3);
  write_file(scratch / "in/paint/cube.mtl", "newmtl red\nKd 0 0 1\n");
  const ProcessResult again = run_colors(scratch / "in", scratch / "old.h5", {"--colors", "--json"});
  CHECK_THAT(again.out, ContainsSubstring("\"changed\":[\"cube.obj\"]"));
  REQUIRE(
      run_colors(scratch / "in", scratch / "new.h5", {"--colors", "--reuse", scratch / "old.h5"}).exit_code ==
      3);
  REQUIRE(run_colors(scratch / "in", scratch / "fresh.h5").exit_code == 3);
  CHECK(read_file(scratch / "new.h5") == read_file(scratch / "fresh.h5"));
  const Row cube = row_of(scratch / "new.h5", "cube.obj");
  for (std::size_t i = 0; i < 200; ++i)
    if (cube.samples.face[i] == 1) CHECK(color(cube.samples, i) == Rgb{0, 0, 255});
}
