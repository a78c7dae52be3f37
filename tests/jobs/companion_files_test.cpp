// Files that models name: which are found, which are not, what the store says of those that are not, and
// --strict.
#include <fmt/format.h>

#include <array>
#include <filesystem>
#include <set>

#include "io/store/store_reader.h"
#include "support/archive_files.h"
#include "support/catch.h"
#include "support/gltf_files.h"
#include "support/image_files.h"
#include "support/meander_program.h"
#include "support/mesh_files.h"
#include "support/store_rows.h"

using namespace meander;
using namespace meander::test;
using Catch::Matchers::ContainsSubstring;

namespace {

namespace fs = std::filesystem;
using Words = std::vector<std::string>;

// One square with the whole image on it, v upwards.
std::string square_obj(const std::string& library) {
  return "mtllib " + library +
         "\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nusemtl skin\n"
         "f 1/1 2/2 3/3 4/4\n";
}
std::string library_of(const std::string& image) { return "newmtl skin\nKd 1 1 1\nmap_Kd " + image + "\n"; }

// Red on the left, blue on the right.
std::string halves_jpeg() {
  return jpeg_bytes(TestImage(64, 8, [](std::uint32_t x, std::uint32_t) {
    return x < 32 ? std::vector<int>{254, 0, 0} : std::vector<int>{0, 0, 254};
  }));
}
std::string plain_png(int red, int green, int blue) {
  return png_bytes(TestImage(4, 4, [&](std::uint32_t, std::uint32_t) {
    return std::vector<int>{red, green, blue};
  }));
}

ProcessResult run_with(const fs::path& input, const fs::path& store, const Words& more = {"--colors"}) {
  Words arguments = {"run", input.string(), "-o", store.string(), "-n", "128", "--progress", "none"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return meander_with(arguments);
}

using Rgb = std::array<int, 3>;
std::set<Rgb> colors_of(const Row& row) {
  std::set<Rgb> colors;
  for (std::size_t i = 0; i < row.samples.count(); ++i)
    colors.insert({row.samples.rgb[3 * i], row.samples.rgb[3 * i + 1], row.samples.rgb[3 * i + 2]});
  return colors;
}
constexpr Rgb fill = {204, 204, 204};

std::uint32_t notes_of(const Row& row, Note note) { return row.report.notes[static_cast<std::size_t>(note)]; }
bool has_notes(const Row& row) { return !row.report.note_text.empty(); }

// Every sample away from the middle, and from the edges, where the image repeats, has the color of its half.
void check_halves(const Row& row) {
  REQUIRE(row.report.status == Status::ok);
  CHECK(row.report.color_source == ColorSource::texture);
  CHECK(row.report.color_fills == 0);
  CHECK_FALSE(has_notes(row));
  for (std::size_t i = 0; i < row.samples.count(); ++i) {
    const float x = row.samples.points[3 * i];
    if (std::abs(x - .5f) < .1f || std::abs(x - .5f) > .4f) continue;
    CHECK(std::abs(row.samples.rgb[3 * i] - (x < .5f ? 254 : 0)) <= 3);
    CHECK(std::abs(row.samples.rgb[3 * i + 2] - (x < .5f ? 0 : 254)) <= 3);
  }
}

void put_shapenet(const fs::path& root, const std::string& model = "aaaa0001") {
  const fs::path folder = root / "03001627" / model;
  fs::create_directories(folder / "models");
  fs::create_directories(folder / "images");
  write_file(folder / "models/model_normalized.obj", square_obj("model_normalized.mtl"));
  write_file(folder / "models/model_normalized.mtl", library_of("../images/texture0.jpg"));
  write_file(folder / "images/texture0.jpg", halves_jpeg());
}

}  // namespace

TEST_CASE("companion files: images next to the model folder are found in folders and archives") {
  const ScratchFolder scratch;
  put_shapenet(scratch / "ShapeNetCore.v2");
  write_file(scratch / "a.zip", zip_bytes(entries_of(scratch / "ShapeNetCore.v2", "ShapeNetCore.v2/")));
  write_file(scratch / "b.tar", tar_bytes(entries_of(scratch / "ShapeNetCore.v2")));
  for (const char* const input : {"ShapeNetCore.v2", "a.zip", "b.tar"}) {
    INFO(input);
    const ProcessResult result =
        run_with(scratch / input, scratch / "s.h5", {"--colors", "--layout", "shapenet", "--fresh"});
    INFO(result.out << result.err);
    REQUIRE(result.exit_code == 0);
    check_halves(StoreReader(scratch / "s.h5").read_row(0));
  }
}

TEST_CASE("companion files: the points are the same as without colors") {
  const ScratchFolder scratch;
  put_shapenet(scratch / "in");
  REQUIRE(run_with(scratch / "in", scratch / "a.h5").exit_code == 0);
  REQUIRE(run_with(scratch / "in", scratch / "b.h5", {}).exit_code == 0);
  CHECK(StoreReader(scratch / "a.h5").read_row(0).samples.points ==
        StoreReader(scratch / "b.h5").read_row(0).samples.points);
}

TEST_CASE("companion files: paths reach up to the input folder and no further") {
  const ScratchFolder scratch;
  put_shapenet(scratch / "set");
  const fs::path model = scratch / "set/03001627/aaaa0001/models";
  const auto row_of_input = [&](const fs::path& input, const Words& more = {"--colors", "--fresh"}) {
    const ProcessResult result = run_with(input, scratch / "s.h5", more);
    INFO(result.out << result.err);
    REQUIRE(result.exit_code == 0);
    return StoreReader(scratch / "s.h5").read_row(0);
  };
  check_halves(row_of_input(scratch / "set"));
  check_halves(row_of_input(scratch / "set/03001627/aaaa0001"));
  // Of a file by itself, and of one in a list, one folder above its own.
  check_halves(row_of_input(model / "model_normalized.obj"));
  write_file(scratch / "list.txt", (model / "model_normalized.obj").string() + "\n");
  check_halves(row_of_input("@" + (scratch / "list.txt").string()));
  // The folder of the models as input: its images are outside.
  const Row outside = row_of_input(model);
  CHECK(colors_of(outside) == std::set{fill});
  CHECK(notes_of(outside, Note::image_outside) == 1);
  CHECK_THAT(outside.report.note_text, ContainsSubstring("../images/texture0.jpg"));
  // Two folders above the file.
  fs::create_directories(scratch / "deep/a/b");
  write_file(scratch / "deep/t.png", plain_png(9, 9, 9));
  write_file(scratch / "deep/a/b/m.obj", square_obj("m.mtl"));
  write_file(scratch / "deep/a/b/m.mtl", library_of("..\\..\\t.png"));
  CHECK(notes_of(row_of_input(scratch / "deep/a/b/m.obj"), Note::image_outside) == 1);
  CHECK(notes_of(row_of_input(scratch / "deep/a"), Note::image_outside) == 1);
  CHECK(colors_of(row_of_input(scratch / "deep")) == std::set{Rgb{9, 9, 9}});
}

TEST_CASE("companion files: paths in archives reach all members and never leave the archive") {
  const ScratchFolder scratch;
  const auto zip = [&](const std::string& image) {
    fs::create_directories(scratch / "in/a/models");
    fs::create_directories(scratch / "in/b");
    write_file(scratch / "in/a/models/m.obj", square_obj("m.mtl"));
    write_file(scratch / "in/a/models/m.mtl", library_of(image));
    write_file(scratch / "in/b/t.png", plain_png(1, 2, 3));
    write_file(scratch / "x.zip", zip_bytes(entries_of(scratch / "in")));
    write_file(scratch / "t.png", plain_png(7, 7, 7));
    REQUIRE(run_with(scratch / "x.zip", scratch / "s.h5", {"--colors", "--fresh"}).exit_code == 0);
    return StoreReader(scratch / "s.h5").read_row(0);
  };
  CHECK(colors_of(zip("../../b/t.png")) == std::set{Rgb{1, 2, 3}});
  CHECK(colors_of(zip("x/../../../b/./t.png")) == std::set{Rgb{1, 2, 3}});
  CHECK(notes_of(zip("../../../t.png"), Note::image_outside) == 1);
  CHECK(notes_of(zip("../../t.png"), Note::image_missing) == 1);
}

TEST_CASE("companion files: links do not lead out of the input") {
  const ScratchFolder scratch;
  put_shapenet(scratch / "in");
  const fs::path images = scratch / "in/03001627/aaaa0001/images";
  fs::rename(images, scratch / "outside");
  fs::create_directory_symlink(scratch / "outside", images);
  REQUIRE(run_with(scratch / "in", scratch / "s.h5").exit_code == 0);
  const Row row = StoreReader(scratch / "s.h5").read_row(0);
  CHECK(colors_of(row) == std::set{fill});
  CHECK(notes_of(row, Note::image_outside) == 1);
  // A model that a link of the input leads to has the files beside it.
  fs::remove(images);
  put_shapenet(scratch / "elsewhere");
  fs::create_directories(scratch / "linked");
  fs::create_directory_symlink(scratch / "elsewhere/03001627/aaaa0001", scratch / "linked/aaaa0001");
  REQUIRE(run_with(scratch / "linked", scratch / "s.h5", {"--colors", "--fresh"}).exit_code == 0);
  check_halves(StoreReader(scratch / "s.h5").read_row(0));
  // One that stays inside is followed.
  fs::rename(scratch / "outside", scratch / "in/03001627/pictures");
  fs::create_directory_symlink("../pictures", images);
  REQUIRE(run_with(scratch / "in", scratch / "s.h5", {"--colors", "--fresh"}).exit_code == 0);
  check_halves(StoreReader(scratch / "s.h5").read_row(0));
}

TEST_CASE("companion files: one that was missing and appears later changes the row") {
  const ScratchFolder scratch;
  put_shapenet(scratch / "in");
  const fs::path image = scratch / "in/03001627/aaaa0001/images/texture0.jpg";
  const std::string bytes = read_file(image);
  fs::remove(image);
  REQUIRE(run_with(scratch / "in", scratch / "s.h5").exit_code == 0);
  CHECK(notes_of(StoreReader(scratch / "s.h5").read_row(0), Note::image_missing) == 1);
  write_file(image, bytes);
  const ProcessResult again = run_with(scratch / "in", scratch / "s.h5");
  CHECK(again.exit_code == 3);
  CHECK_THAT(again.err, ContainsSubstring("changed"));
  REQUIRE(run_with(scratch / "in", scratch / "s.h5", {"--colors", "--retry", "changed"}).exit_code == 0);
  check_halves(StoreReader(scratch / "s.h5").read_row(0));
}

TEST_CASE("companion files: glTF buffers next to the model folder are part of its content") {
  const ScratchFolder scratch;
  GltfFile file;
  file.add_points(gltf_cube_points);
  file.add_indices(gltf_cube_indices);
  const std::string json = file.json(primitive_of(R"(,"indices":1)"), "../buffers/c.bin");
  fs::create_directories(scratch / "in/models");
  fs::create_directories(scratch / "in/buffers");
  write_file(scratch / "in/models/m.gltf", json);
  write_file(scratch / "in/buffers/c.bin", file.binary);
  REQUIRE(run_with(scratch / "in", scratch / "s.h5", {}).exit_code == 0);
  const ItemReport report = StoreReader(scratch / "s.h5").report(0);
  CHECK(report.area == Approx(6));
  CHECK(report.file_bytes == json.size() + file.binary.size());
  std::string other = file.binary;
  other[3] = static_cast<char>(other[3] ^ 0x40);
  write_file(scratch / "in/buffers/c.bin", other);
  CHECK(run_with(scratch / "in", scratch / "s.h5", {}).exit_code == 3);  // changed
  const ProcessResult outside = run_with(scratch / "in/models", scratch / "o.h5", {});
  CHECK(outside.exit_code == 3);
  const Row row = StoreReader(scratch / "o.h5").read_row(0);
  CHECK(row.report.status == Status::unreadable);
  CHECK_THAT(row.report.reason, ContainsSubstring("leads out of what was given as input"));
}

TEST_CASE("companion files: names in another case, normal form or Latin-1 are found") {
  const ScratchFolder scratch;
  const std::string decomposed = "t\x65\xCC\x81.png", composed = "t\xC3\xA9.png", latin1 = "t\xE9.png";
  struct Names {
    std::string on_disk, in_library;
  };
  for (const Names& names :
       {Names{composed, decomposed}, Names{decomposed, composed}, Names{composed, latin1},
        Names{latin1, composed}, Names{composed, "T\xC3\x89.PNG"}, Names{"a b.png", "\"a b.png\""},
        Names{"x.png", "C:\\work\\x.png"}}) {
    INFO(names.on_disk << " " << names.in_library);
    fs::remove_all(scratch / "in");
    fs::create_directories(scratch / "in");
    write_file(scratch / "in/m.obj", square_obj("m.mtl"));
    write_file(scratch / "in/m.mtl", library_of(names.in_library));
    write_file(scratch / "in" / names.on_disk, plain_png(3, 5, 7));
    REQUIRE(run_with(scratch / "in", scratch / "s.h5", {"--colors", "--fresh"}).exit_code == 0);
    CHECK(colors_of(StoreReader(scratch / "s.h5").read_row(0)) == std::set{Rgb{3, 5, 7}});
    write_file(scratch / "x.zip", zip_bytes(entries_of(scratch / "in")));
    REQUIRE(run_with(scratch / "x.zip", scratch / "z.h5", {"--colors", "--fresh"}).exit_code == 0);
    CHECK(colors_of(StoreReader(scratch / "z.h5").read_row(0)) == std::set{Rgb{3, 5, 7}});
  }
}

TEST_CASE("companion files: material libraries with a BOM, other line ends, capitals and unusual names") {
  const ScratchFolder scratch;
  const std::string plain = library_of("t.png");
  const auto utf16 = [](const std::string& text) {
    std::string wide = "\xFF\xFE";
    for (const char c : text) wide += {c, '\0'};
    return wide;
  };
  const auto with_cr = [](std::string text) {
    std::replace(text.begin(), text.end(), '\n', '\r');
    return text;
  };
  const auto capitals = [](std::string text) {
    for (const auto& [from, to] : {std::pair("newmtl", "NEWMTL"),
                                   {"Kd", "KD"},
                                   {"map_KD", "MAP_KD"},
                                   {"mtllib", "MTLLIB"},
                                   {"usemtl", "USEMTL"}})
      for (std::size_t at; (at = text.find(from)) != std::string::npos;)
        text.replace(at, std::string(from).size(), to);
    return text;
  };
  const std::string mark = "\xEF\xBB\xBF", obj = square_obj("m.mtl");
  struct Files {
    std::string obj, mtl;
  };
  for (const Files& files :
       {Files{obj, mark + plain}, Files{mark + obj, plain}, Files{utf16(obj), utf16(plain)},
        Files{with_cr(obj), with_cr(plain)}, Files{capitals(obj), capitals(plain)},
        Files{square_obj("\"m.mtl\""), plain}, Files{square_obj("D:\\models\\m.mtl"), plain},
        Files{square_obj("./M.MTL"), plain}, Files{obj, "newmtl other\rKd 0 1 0\r" + plain}}) {
    INFO(files.obj << files.mtl);
    fs::remove_all(scratch / "in");
    fs::create_directories(scratch / "in");
    write_file(scratch / "in/m.obj", files.obj);
    write_file(scratch / "in/m.mtl", files.mtl);
    write_file(scratch / "in/t.png", plain_png(200, 30, 40));
    REQUIRE(run_with(scratch / "in", scratch / "s.h5", {"--colors", "--fresh"}).exit_code == 0);
    const Row row = StoreReader(scratch / "s.h5").read_row(0);
    CHECK(row.report.area == Approx(1));
    CHECK(colors_of(row) == std::set{Rgb{200, 30, 40}});
    CHECK_FALSE(has_notes(row));
  }
}

TEST_CASE("companion files: lost files are named in the store, the summary, info and JSON") {
  const ScratchFolder scratch;
  fs::create_directories(scratch / "in");
  const auto model = [&](const std::string& name, const std::string& library) {
    write_file(scratch / "in" / (name + ".obj"), square_obj(name + ".mtl"));
    if (!library.empty()) write_file(scratch / "in" / (name + ".mtl"), library);
  };
  model("a_missing_image", library_of("none.png"));
  model("b_missing_library", "");
  model("c_damaged", library_of("damaged.png"));
  model("d_other_format", library_of("picture.tif"));
  model("e_material", "newmtl other\nKd 1 0 0\nnewmtl third\nKd 0 1 0\n");
  model("f_good", library_of("good.png"));
  write_file(scratch / "in/damaged.png", plain_png(1, 1, 1).substr(0, 40));
  write_file(scratch / "in/picture.tif", std::string("II*\0\x08\0\0\0", 8) + std::string(64, '\0'));
  write_file(scratch / "in/good.png", plain_png(10, 20, 30));
  write_file(scratch / "in/g_no_material.obj",
             "mtllib f_good.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n");
  write_file(scratch / "in/h_no_coordinates.obj",
             "mtllib f_good.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl skin\nf 1 2 3\n");
  const ProcessResult result = run_with(scratch / "in", scratch / "s.h5");
  INFO(result.out << result.err);
  REQUIRE(result.exit_code == 0);
  const auto note = [&](const std::string& id, Note kind) {
    return notes_of(row_of(scratch / "s.h5", id + ".obj"), kind);
  };
  CHECK(note("a_missing_image", Note::image_missing) == 1);
  CHECK(note("b_missing_library", Note::library_missing) == 1);
  CHECK(note("c_damaged", Note::image_unreadable) == 1);
  CHECK(note("d_other_format", Note::image_unsupported) == 1);
  CHECK(note("e_material", Note::material_missing) == 1);
  CHECK_FALSE(has_notes(row_of(scratch / "s.h5", "f_good.obj")));
  CHECK(note("g_no_material", Note::material_assumed) == 1);
  CHECK(colors_of(row_of(scratch / "s.h5", "g_no_material.obj")) == std::set{Rgb{10, 20, 30}});
  CHECK(note("h_no_coordinates", Note::coordinates_missing) == 1);
  CHECK_THAT(row_of(scratch / "s.h5", "a_missing_image.obj").report.note_text,
             ContainsSubstring("image_missing 1: `none.png`"));
  CHECK_THAT(result.out, ContainsSubstring("note: image_missing") &&
                             ContainsSubstring("a_missing_image.obj") && ContainsSubstring("`none.png`") &&
                             ContainsSubstring("note: library_missing"));
  const ProcessResult info = meander_with({"info", (scratch / "s.h5").string(), "a_missing_image.obj"});
  CHECK_THAT(info.out, ContainsSubstring("image_missing 1") && ContainsSubstring("`none.png`") &&
                           ContainsSubstring("128 of 128"));
  const ProcessResult json =
      meander_with({"info", (scratch / "s.h5").string(), "a_missing_image.obj", "--json"});
  CHECK_THAT(json.out,
             ContainsSubstring("\"image_missing\":1") && ContainsSubstring("\"color_source\":\"none\""));
  const ProcessResult again = run_with(scratch / "in", scratch / "s.h5", {"--colors", "--json"});
  CHECK_THAT(again.out, ContainsSubstring("\"notes\":{\"image_missing\":{\"count\":1,\"models\":1"));
  CHECK(meander_with({"verify", (scratch / "s.h5").string()}).exit_code == 0);
}

TEST_CASE("run --strict: models with the given notes are incomplete, and redone once nothing is missing") {
  const ScratchFolder scratch;
  put_shapenet(scratch / "in", "aaaa0001");
  put_shapenet(scratch / "in", "bbbb0002");
  const fs::path image = scratch / "in/03001627/bbbb0002/images/texture0.jpg";
  const std::string bytes = read_file(image);
  fs::remove(image);
  const Words strict = {"--colors", "--strict", "image_missing,library_missing"};
  const ProcessResult result = run_with(scratch / "in", scratch / "s.h5", strict);
  INFO(result.out << result.err);
  CHECK(result.exit_code == 3);
  const std::string id = "03001627/bbbb0002/models/model_normalized.obj";
  const Row row = row_of(scratch / "s.h5", id);
  CHECK(row.report.status == Status::incomplete);
  CHECK_THAT(row.report.reason, ContainsSubstring("image_missing 1: `../images/texture0.jpg`"));
  CHECK(notes_of(row, Note::image_missing) == 1);
  check_halves(StoreReader(scratch / "s.h5").read_row(0));
  CHECK(meander_with({"verify", (scratch / "s.h5").string()}).exit_code == 0);
  // Notes that are not named are accepted.
  REQUIRE(
      run_with(scratch / "in", scratch / "t.h5", {"--colors", "--strict", "image_unreadable"}).exit_code ==
      0);
  write_file(image, bytes);
  Words retry = strict;
  retry.insert(retry.end(), {"--retry", "incomplete"});
  const ProcessResult again = run_with(scratch / "in", scratch / "s.h5", retry);
  INFO(again.out << again.err);
  CHECK(again.exit_code == 0);
  check_halves(row_of(scratch / "s.h5", id));
}

TEST_CASE("run --strict: unknown words, and notes on colors without --colors, are refused") {
  const ScratchFolder scratch;
  put_shapenet(scratch / "in");
  const ProcessResult word =
      run_with(scratch / "in", scratch / "s.h5", {"--strict", "image_lost,notes_lost"});
  for (const char* const wrong : {"`image_lost` is neither", "`notes_lost` is neither"})
    CHECK(word.err.find(wrong) != std::string::npos);
  CHECK(word.exit_code == 2);
  CHECK_THAT(word.err, ContainsSubstring("image_lost") && ContainsSubstring("image_missing"));
  const ProcessResult plain = run_with(scratch / "in", scratch / "s.h5", {"--strict", "image_missing"});
  CHECK(plain.exit_code == 2);
  CHECK_THAT(plain.err, ContainsSubstring("--colors"));
  CHECK(run_with(scratch / "in", scratch / "s.h5", {"--strict", "all"}).exit_code == 0);
}
