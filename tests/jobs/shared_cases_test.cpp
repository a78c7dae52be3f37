// Small inputs that public reports describe, in a folder beside the shared meshes, each with its right
// result. Skipped where the folder is not there: the same is tested on files that the tests make.
#include <algorithm>
#include <array>
#include <filesystem>
#include <map>

#include "io/store/store_reader.h"
#include "support/archive_files.h"
#include "support/catch.h"
#include "support/meander_program.h"
#include "support/store_rows.h"

using namespace meander;
using namespace meander::test;

namespace {

namespace fs = std::filesystem;
using Rgb = std::array<int, 3>;

const fs::path cases = fs::path(MEANDER_SHARED_DATA).parent_path() / "cases";

// Whether the case is there; says "skipped" where it is not.
bool is_there(const std::string& name) {
  if (fs::exists(cases / name)) return true;
  WARN("skipped: no folder " << (cases / name).string());
  return false;
}

// The rows of a case, by id.
std::map<std::string, Row> rows_of(const fs::path& input, const std::vector<std::string>& more = {}) {
  const ScratchFolder scratch;
  std::vector<std::string> arguments = {"run", input.string(), "-o",       (scratch / "s.h5").string(),
                                        "-n",  "512",          "--colors", "--progress",
                                        "none"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  const ProcessResult result = meander_with(arguments);
  INFO(result.out << result.err);
  REQUIRE(result.exit_code == 0);
  const StoreReader store(scratch / "s.h5");
  std::map<std::string, Row> rows;
  for (std::uint64_t row = 0; row < store.rows(); ++row) rows[store.id(row)] = store.read_row(row);
  return rows;
}

Rgb color(const Row& row, std::size_t i) {
  return {row.samples.rgb[3 * i], row.samples.rgb[3 * i + 1], row.samples.rgb[3 * i + 2]};
}

bool is_near(const Rgb& a, const Rgb& b, int tolerance) {
  for (std::size_t k = 0; k < 3; ++k)
    if (std::abs(a[k] - b[k]) > tolerance) return false;
  return true;
}

bool all_have(const Row& row, const Rgb& wanted, int tolerance = 0) {
  for (std::size_t i = 0; i < row.samples.count(); ++i)
    if (!is_near(color(row, i), wanted, tolerance)) return false;
  return row.report.color_fills == 0;
}

// The share of samples with this color.
double share_of(const Row& row, const Rgb& wanted, int tolerance = 0) {
  double count = 0;
  for (std::size_t i = 0; i < row.samples.count(); ++i) count += is_near(color(row, i), wanted, tolerance);
  return count / static_cast<double>(row.samples.count());
}

}  // namespace

TEST_CASE("shared cases: ShapeNet images next to its models are found, in a folder and in a zip") {
  if (!is_there("shapenet_v2_images")) return;
  const ScratchFolder scratch;
  write_file(scratch / "set.zip", zip_bytes(entries_of(cases / "shapenet_v2_images")));
  for (const fs::path& input : {cases / "shapenet_v2_images", scratch / "set.zip"}) {
    const auto rows = rows_of(input);
    REQUIRE(rows.size() == 1);
    const Row& row = rows.begin()->second;
    CHECK(row.report.color_source == ColorSource::texture);
    CHECK(share_of(row, {254, 0, 0}, 2) > .2);
    CHECK(share_of(row, {0, 0, 254}, 2) > .2);
    // Between the halves, and where the image repeats, pixels are blended, and midway both colors are the
    // same.
    for (std::size_t i = 0; i < row.samples.count(); ++i) {
      const Rgb rgb = color(row, i);
      CHECK((row.samples.points[3 * i] < .5f ? rgb[0] >= rgb[2] : rgb[2] >= rgb[0]));
    }
  }
}

TEST_CASE("shared cases: colors by declared type, valid bit, single material and encoding") {
  if (is_there("obj_without_usemtl"))
    for (const auto& [id, row] : rows_of(cases / "obj_without_usemtl")) CHECK(all_have(row, {200, 30, 40}));
  if (is_there("encodings"))
    for (const auto& [id, row] : rows_of(cases / "encodings")) CHECK(all_have(row, {200, 30, 40}));
  if (is_there("colors_overshoot")) {
    const auto rows = rows_of(cases / "colors_overshoot");
    CHECK(all_have(rows.at("a_in_range.ply"), {255, 128, 64}, 1));
    CHECK(all_have(rows.at("b_over.ply"), {255, 128, 64}, 1));
    CHECK(all_have(rows.at("h_int_dark.ply"), {1, 0, 1}));
  }
  if (is_there("stl_colors"))
    for (const auto& [id, row] : rows_of(cases / "stl_colors")) {
      CHECK(row.report.color_source == ColorSource::face);
      CHECK(share_of(row, {255, 0, 0}) + share_of(row, {0, 0, 255}) == 1);
      CHECK(share_of(row, {255, 0, 0}) == Approx(.5).margin(.05));
    }
  if (is_there("ply_texture"))
    for (const auto& [id, row] : rows_of(cases / "ply_texture")) {
      CHECK(share_of(row, {255, 0, 0}) > .2);
      CHECK(share_of(row, {0, 0, 255}) > .2);
      CHECK(row.report.color_source == ColorSource::texture);
    }
}

TEST_CASE("shared cases: areas and boxes of glTF, OFF, STL and of faces without area") {
  const auto area = [](const char* folder, const char* id) {
    return rows_of(cases / folder).at(id).report.area;
  };
  if (is_there("gltf_instancing")) CHECK(area("gltf_instancing", "used.glb") == Approx(6));
  if (is_there("ascii_stl_header_lines"))
    CHECK(area("ascii_stl_header_lines", "a_color_before_first.stl") == Approx(1));
  if (is_there("gltf_morph")) {
    const auto rows = rows_of(cases / "gltf_morph");
    CHECK(rows.at("mesh_weights.glb").report.bbox[2] == 1);
    CHECK(rows.at("no_weights.glb").report.bbox[5] == 0);
  }
  if (is_there("draco_normalized"))
    for (const auto& [id, row] : rows_of(cases / "draco_normalized")) {
      CHECK(row.report.area == Approx(96));
      CHECK(row.report.bbox[0] == Approx(-2));
      CHECK(row.report.bbox[5] == Approx(2));
    }
  if (is_there("off_without_keyword"))
    for (const auto& [id, row] : rows_of(cases / "off_without_keyword")) {
      CHECK(row.report.area == Approx(12.387).epsilon(1e-3));
      for (const double side : row.report.bbox) CHECK(std::abs(side) <= 1);
    }
  if (is_there("far_face_without_area"))
    for (const auto& [id, row] : rows_of(cases / "far_face_without_area")) {
      CHECK(row.report.area == Approx(6));
      CHECK(row.report.bbox == std::array<double, 6>{0, 0, 0, 1, 1, 1});
    }
}

TEST_CASE("shared cases: labels and objects are classes, with their names") {
  if (is_there("integer_labels")) {
    const Row row = rows_of(cases / "integer_labels", {"--attribute", "label"}).at("scene.ply");
    REQUIRE(row.samples.classes.size() == 1);
    for (const std::int32_t value : row.samples.classes[0]) CHECK((value == 1 || value == 40));
  }
  if (is_there("obj_groups")) {
    const Row row = rows_of(cases / "obj_groups", {"--attribute", "object"}).at("parts.obj");
    REQUIRE(row.samples.classes.size() == 1);
    const auto seats = std::count(row.samples.classes[0].begin(), row.samples.classes[0].end(), 0);
    CHECK(std::abs(seats - 256) <= 16);
    CHECK(row.names == R"({"object":["seat","leg"]})");
  }
}
