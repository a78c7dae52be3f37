// `run --colors` of models with images: every sample against the image at its place, read from the point
// alone.
#include <fmt/format.h>
#include <unistd.h>
#include <webp/encode.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <numbers>
#include <sstream>

#include "io/store/store_reader.h"
#include "support/archive_files.h"
#include "support/catch.h"
#include "support/gltf_files.h"
#include "support/gltf_streams.h"
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
using Point = std::array<double, 3>;
using Light = std::array<double, 3>;

ProcessResult run_textured(const fs::path& input, const fs::path& store, const Words& more = {},
                           const char* samples = "1000") {
  Words arguments = {"run",   input.string(), "-o",         store.string(), "-n",
                     samples, "--colors",     "--progress", "none"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return meander_with(arguments);
}

// The one model in a file or folder.
Row sampled(const fs::path& input, const fs::path& store, const char* samples = "1000") {
  const ProcessResult result = run_textured(input, store, {"--fresh"}, samples);
  INFO(result.out << result.err);
  REQUIRE(result.exit_code == 0);
  return StoreReader(store).read_row(0);
}

Point point_of(const Row& row, std::size_t i) {
  Point p;
  for (std::size_t k = 0; k < 3; ++k)
    p[k] = row.report.loc[k] + row.report.scale * static_cast<double>(row.samples.points[3 * i + k]);
  return p;
}

// The six sides of a box, each with corners a, b, c, d round it; the image's lower left, lower right, upper
// right and upper left corners lie there.
constexpr std::array<std::array<int, 4>, 6> sides = {
    {{3, 2, 1, 0}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}, {4, 5, 6, 7}}};
constexpr Point box = {1, 2, 3};
Point corner(int k) {
  return {k % 4 == 1 || k % 4 == 2 ? box[0] : 0.0, k % 4 >= 2 ? box[1] : 0.0, k >= 4 ? box[2] : 0.0};
}

// Across and up a side, each from 0 to 1, by the place of the point.
std::array<double, 2> place_on(std::size_t side, const Point& p) {
  const Point a = corner(sides[side][0]), b = corner(sides[side][1]), d = corner(sides[side][3]);
  std::array<double, 2> place{};
  for (std::size_t axis = 0; axis < 2; ++axis) {
    const Point& to = axis == 0 ? b : d;
    double along = 0, length = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      along += (p[k] - a[k]) * (to[k] - a[k]);
      length += (to[k] - a[k]) * (to[k] - a[k]);
    }
    place[axis] = along / length;
  }
  return place;
}

enum class Edge { repeat, mirror, clamp };

int wrapped(int pixel, int size, Edge edge) {
  if (edge == Edge::clamp) return std::clamp(pixel, 0, size - 1);
  const int period = edge == Edge::mirror ? 2 * size : size;
  const int in = ((pixel % period) + period) % period;
  return in < size ? in : period - 1 - in;
}

double light_of(double displayed) {
  return displayed <= 0.04045 ? displayed / 12.92 : std::pow((displayed + 0.055) / 1.055, 2.4);
}
double displayed_of(double light) {
  return light <= 0.0031308 ? 12.92 * light : 1.055 * std::pow(light, 1 / 2.4) - 0.055;
}

struct Lookup {
  const TestImage& image;
  Edge edge_u = Edge::repeat, edge_v = Edge::repeat;
  bool linear = false;
  Light factor = {1, 1, 1};

  double pixel(int x, int y, std::size_t c) const {
    const auto column = static_cast<std::size_t>(wrapped(x, static_cast<int>(image.width), edge_u)),
               row = static_cast<std::size_t>(wrapped(y, static_cast<int>(image.height), edge_v));
    const double value = image.rgb[3 * (row * image.width + column) + c] / 255.0;
    return linear ? light_of(value) : value;
  }
  double stored(double value, std::size_t c) const {
    value = std::clamp(value * factor[c], 0.0, 1.0);
    return 255 * (linear ? displayed_of(value) : value);
  }
  // u to the right, v down, of the image.
  Light bilinear(double u, double v) const {
    const double x = u * image.width - .5, y = v * image.height - .5;
    const int x0 = static_cast<int>(std::floor(x)), y0 = static_cast<int>(std::floor(y));
    Light color;
    for (std::size_t c = 0; c < 3; ++c)
      color[c] =
          stored((1 - y + y0) * ((1 - x + x0) * pixel(x0, y0, c) + (x - x0) * pixel(x0 + 1, y0, c)) +
                     (y - y0) * ((1 - x + x0) * pixel(x0, y0 + 1, c) + (x - x0) * pixel(x0 + 1, y0 + 1, c)),
                 c);
    return color;
  }
  Light nearest(double u, double v) const {
    Light color;
    for (std::size_t c = 0; c < 3; ++c)
      color[c] = stored(pixel(static_cast<int>(std::floor(u * image.width)),
                              static_cast<int>(std::floor(v * image.height)), c),
                        c);
    return color;
  }
};

double difference(const Row& row, std::size_t i, const Light& expected) {
  double most = 0;
  for (std::size_t c = 0; c < 3; ++c)
    most = std::max(most, std::abs(row.samples.rgb[3 * i + c] - expected[c]));
  return most;
}

TestImage colorful(std::uint32_t width, std::uint32_t height) {
  return {width, height, [](std::uint32_t x, std::uint32_t y) {
            return std::vector<int>{static_cast<int>((x * 97 + y * 31) % 256),
                                    static_cast<int>((x * 13 + y * 71) % 256),
                                    static_cast<int>((x * y * 7 + 40) % 256)};
          }};
}

// A box whose sides all show the image of the material `paint`.
std::string box_obj(const std::string& library = "paint.mtl", const std::string& material = "paint") {
  std::string text = "mtllib " + library + "\n";
  for (int k = 0; k < 8; ++k) text += fmt::format("v {} {} {}\n", corner(k)[0], corner(k)[1], corner(k)[2]);
  text += "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nusemtl " + material + "\n";
  for (const auto& side : sides)
    text += fmt::format("f {}/1 {}/2 {}/3 {}/4\n", side[0] + 1, side[1] + 1, side[2] + 1, side[3] + 1);
  return text;
}

// The same as triangles 2 s and 2 s + 1 of side s, with coordinates from `low` to `high` across and up it.
GltfFile box_gltf(double low, double high) {
  GltfFile file;
  std::vector<float> points, coordinates;
  std::vector<std::uint16_t> indices;
  for (std::uint16_t s = 0; s < 6; ++s) {
    for (std::size_t k = 0; k < 4; ++k) {
      for (const double x : corner(sides[s][k])) points.push_back(static_cast<float>(x));
      coordinates.push_back(static_cast<float>(k == 1 || k == 2 ? high : low));
      coordinates.push_back(static_cast<float>(k >= 2 ? low : high));  // v points down
    }
    for (const int k : {0, 1, 2, 0, 2, 3}) indices.push_back(static_cast<std::uint16_t>(4 * s + k));
  }
  file.add_points(points);
  file.add_indices(indices);
  file.add_accessor(file.add_view(coordinates), 5126, coordinates.size() / 2, "VEC2");
  return file;
}

// Members behind the buffers: one mesh, one material. `image`, `sampler`, `material`: JSON.
std::string textured(
    const std::string& image, const std::string& sampler,
    const std::string& material = R"({"pbrMetallicRoughness":{"baseColorTexture":{"index":0}}})") {
  return R"(,"meshes":[{"primitives":[{"attributes":{"POSITION":0,"TEXCOORD_0":2},"indices":1,"material":0}]}],)"
         R"("nodes":[{"mesh":0}],"materials":[)" +
         material + R"(],"textures":[{"source":0,"sampler":0}],"images":[)" + image + R"(],"samplers":[)" +
         sampler + "]";
}

std::string image_in_view(GltfFile& file, const std::string& bytes, const char* mime) {
  return fmt::format(R"({{"bufferView":{},"mimeType":"{}"}})", file.add_view(bytes), mime);
}

// Largest difference over the samples of a glTF box.
double most_difference(const Row& row, const Lookup& lookup, double low, double high, bool nearest) {
  REQUIRE(row.report.color_source == ColorSource::texture);
  REQUIRE(row.report.color_fills == 0);
  double most = 0;
  for (std::size_t i = 0; i < row.samples.count(); ++i) {
    const auto place = place_on(row.samples.face[i] / 2, point_of(row, i));
    const double u = low + (high - low) * place[0], v = low + (high - low) * (1 - place[1]);
    if (nearest) {  // points are float32: at the edge of a pixel it may be either
      const double x = u * lookup.image.width, y = v * lookup.image.height;
      if (std::abs(x - std::round(x)) < 1e-4 || std::abs(y - std::round(y)) < 1e-4) continue;
    }
    most = std::max(most, difference(row, i, nearest ? lookup.nearest(u, v) : lookup.bilinear(u, v)));
  }
  return most;
}

}  // namespace

TEST_CASE("run --colors: every sample of an OBJ, MTL and PNG box has the color of its image") {
  const ScratchFolder scratch;
  fs::create_directories(scratch / "in/maps");
  const TestImage image = colorful(7, 5);
  write_file(scratch / "in/maps/image.png", png_bytes(image));
  write_file(scratch / "in/box.obj", box_obj("maps/paint.mtl"));
  const auto check = [&](const std::string& options, const std::string& color, const Lookup& lookup,
                         double scale_u, double scale_v, double move_u, double move_v) {
    write_file(scratch / "in/maps/paint.mtl", "newmtl paint\n" + color + "map_Kd " + options + "image.png\n");
    const Row row = sampled(scratch / "in", scratch / "s.h5");
    CHECK(row.report.color_source == ColorSource::texture);
    CHECK(row.report.color_fills == 0);
    for (std::size_t i = 0; i < row.samples.count(); ++i) {
      const auto place = place_on(row.samples.face[i], point_of(row, i));
      const Light expected = lookup.bilinear(scale_u * place[0] + move_u, 1 - (scale_v * place[1] + move_v));
      REQUIRE(difference(row, i, expected) < 0.6);
    }
  };
  check("", "", {image}, 1, 1, 0, 0);
  check("", "Kd 0.5 1 0.25\n", {image, Edge::repeat, Edge::repeat, false, {.5, 1, .25}}, 1, 1, 0, 0);
  check("", "Kd 0 0 0\n", {image}, 1, 1, 0, 0);
  check("-s 2 3 1 -o 0.25 -0.5 0 ", "", {image}, 2, 3, .25, -.5);
  check("-blendu on -clamp on -s 2 2 ", "Kd 1 1 1\n", {image, Edge::clamp, Edge::clamp, false, {1, 1, 1}}, 2,
        2, 0, 0);
  check("-mm 0 0.5 ", "", {image, Edge::repeat, Edge::repeat, false, {.5, .5, .5}}, 1, 1, 0, 0);
}

TEST_CASE("run --colors: a GLB box, nearest and bilinear, in every wrap mode, in linear light") {
  const ScratchFolder scratch;
  const TestImage image = colorful(6, 4);
  const std::array<std::pair<Edge, int>, 3> edges = {
      {{Edge::repeat, 10497}, {Edge::mirror, 33648}, {Edge::clamp, 33071}}};
  for (const auto& [edge_u, mode_u] : edges)
    for (const auto& [edge_v, mode_v] : edges)
      for (const bool nearest : {false, true}) {
        GltfFile file = box_gltf(-1.5, 2.25);
        const std::string sampler =
            fmt::format(R"({{"magFilter":{},"wrapS":{},"wrapT":{}}})", nearest ? 9728 : 9729, mode_u, mode_v);
        const std::string embedded = image_in_view(file, png_bytes(image), "image/png");
        write_file(scratch / "box.glb", file.glb(textured(embedded, sampler)));
        const Row row = sampled(scratch / "box.glb", scratch / "s.h5");
        INFO(sampler);
        // Points are float32, and the image is six pixels: what the rounding of the point moves.
        CHECK(most_difference(row, {image, edge_u, edge_v, true, {1, 1, 1}}, -1.5, 2.25, nearest) <
              (nearest ? 0.51 : 0.6));
      }
}

TEST_CASE("run --colors: glTF images in a buffer view, a data URI, a file, and a JPEG") {
  const ScratchFolder scratch;
  const TestImage image(16, 16, [](std::uint32_t x, std::uint32_t y) {
    return std::vector<int>{static_cast<int>(20 + 10 * x), static_cast<int>(220 - 9 * y),
                            static_cast<int>(50 + 4 * (x + y))};
  });
  const std::string png = png_bytes(image), jpeg = jpeg_bytes(image, {true, false, false});
  const std::string factor =
      R"({"pbrMetallicRoughness":{"baseColorFactor":[0.5,1,0.25,1],"baseColorTexture":{"index":0,"texCoord":0}}})";
  const Lookup lookup{image, Edge::clamp, Edge::clamp, true, {.5, 1, .25}};
  const std::string sampler = R"({"wrapS":33071,"wrapT":33071})";
  const auto most = [&](const fs::path& path) {
    return most_difference(sampled(path, scratch / "s.h5"), lookup, 0, 1, false);
  };
  GltfFile in_view = box_gltf(0, 1);
  const std::string view = image_in_view(in_view, jpeg, "image/jpeg");
  write_file(scratch / "jpeg.glb", in_view.glb(textured(view, sampler, factor)));
  CHECK(most(scratch / "jpeg.glb") <= 4);  // what JPEG changes
  const GltfFile plain = box_gltf(0, 1);
  write_file(scratch / "uri.gltf",
             plain.with_data_uri(
                 textured(R"({"uri":"data:image/png;base64,)" + base64(png) + "\"}", sampler, factor)));
  CHECK(most(scratch / "uri.gltf") < .6);
  fs::create_directories(scratch / "maps");
  write_file(scratch / "maps/a b.PNG", png);
  write_file(scratch / "file.gltf",
             plain.with_data_uri(textured(R"({"uri":"maps/a%20b.png"})", sampler, factor)));
  CHECK(most(scratch / "file.gltf") < .6);
  // KHR_texture_transform: a quarter turn. (u, v) becomes (v, 1 - u).
  const std::string turned =
      R"({"pbrMetallicRoughness":{"baseColorTexture":{"index":0,"extensions":{"KHR_texture_transform":)"
      R"({"rotation":1.5707963267948966,"offset":[0,1]}}}}})";
  write_file(scratch / "turned.gltf",
             plain.with_data_uri(textured(R"({"uri":"maps/a%20b.PNG"})", sampler, turned)));
  const Row row = sampled(scratch / "turned.gltf", scratch / "s.h5");
  const Lookup bare{image, Edge::clamp, Edge::clamp, true, {1, 1, 1}};
  for (std::size_t i = 0; i < row.samples.count(); ++i) {
    const auto place = place_on(row.samples.face[i] / 2, point_of(row, i));
    REQUIRE(difference(row, i, bare.bilinear(1 - place[1], 1 - place[0])) < .6);
  }
}

TEST_CASE("run --colors: a two-colored sphere with a seam has no third color") {
  const ScratchFolder scratch;
  constexpr int columns = 32, rows = 16;
  const TestImage halves(64, 1, [](std::uint32_t x, std::uint32_t) {
    return x < 32 ? std::vector<int>{250, 10, 20} : std::vector<int>{0, 60, 240};
  });
  write_file(scratch / "halves.png", png_bytes(halves));
  write_file(scratch / "m.mtl", "newmtl m\nmap_Kd -clamp on halves.png\n");
  // Vertices are shared over the seam; coordinates are not: those of the last column end at 1.
  std::string text = "mtllib m.mtl\nusemtl m\n";
  for (int r = 0; r <= rows; ++r)
    for (int c = 0; c < columns; ++c) {
      const double down = std::numbers::pi * (r + .5) / (rows + 1),
                   round = 2 * std::numbers::pi * c / columns;
      text += fmt::format("v {} {} {}\n", std::sin(down) * std::cos(round), std::sin(down) * std::sin(round),
                          std::cos(down));
    }
  for (int r = 0; r <= rows; ++r)
    for (int c = 0; c <= columns; ++c)
      text += fmt::format("vt {} {}\n", double(c) / columns, 1 - double(r) / rows);
  for (int r = 0; r < rows; ++r)
    for (int c = 0; c < columns; ++c) {
      const auto vertex = [&](int row, int column) { return row * columns + column % columns + 1; };
      const auto place = [&](int row, int column) { return row * (columns + 1) + column + 1; };
      text += fmt::format("f {}/{} {}/{} {}/{} {}/{}\n", vertex(r, c), place(r, c), vertex(r + 1, c),
                          place(r + 1, c), vertex(r + 1, c + 1), place(r + 1, c + 1), vertex(r, c + 1),
                          place(r, c + 1));
    }
  write_file(scratch / "sphere.obj", text);
  const Row row = sampled(scratch / "sphere.obj", scratch / "s.h5", "10000");
  CHECK(row.report.color_fills == 0);
  std::array<int, 2> found{};
  for (std::size_t i = 0; i < row.samples.count(); ++i) {
    const std::uint32_t column = row.samples.face[i] % columns;
    if (column == columns / 2 - 1 || column == columns / 2) continue;  // where the halves meet in the image
    const bool first = column < columns / 2;
    ++found[first ? 0 : 1];
    REQUIRE(difference(row, i, first ? Light{250, 10, 20} : Light{0, 60, 240}) == 0);
  }
  CHECK(found[0] > 4000);
  CHECK(found[1] > 4000);
}

TEST_CASE("run --colors: the mean of 10,000 samples is that of the image over the surface") {
  const ScratchFolder scratch;
  const TestImage image = colorful(24, 17);
  write_file(scratch / "image.png", png_bytes(image));
  write_file(scratch / "paint.mtl", "newmtl paint\nmap_Kd image.png\n");
  write_file(scratch / "box.obj", box_obj());
  const Row row = sampled(scratch / "box.obj", scratch / "s.h5", "10000");
  // Bilinear with repetition keeps the mean of the pixels. Independent samples would have a standard error of
  // .74 (255 / sqrt(12) / 100).
  for (std::size_t c = 0; c < 3; ++c) {
    double mean = 0, expected = 0;
    for (std::size_t i = c; i < row.samples.rgb.size(); i += 3) mean += row.samples.rgb[i] / 10000.0;
    for (std::size_t k = c; k < image.rgb.size(); k += 3) expected += image.rgb[k] / (24.0 * 17);
    CHECK(std::abs(mean - expected) < 2.5);
  }
}

TEST_CASE("run --colors: missing, damaged, too large and outside images are counted as fills") {
  const ScratchFolder scratch;
  fs::create_directories(scratch / "in/model");
  const std::string png = png_bytes(colorful(5, 5));
  write_file(scratch / "in/model/Good.PNG", png);
  write_file(scratch / "outside.png", png);
  write_file(scratch / "in/model/cut.png", png.substr(0, png.size() / 2));
  std::string huge = png;
  huge.replace(16, 8, std::string("\x7F\xFF\xFF\xFF\x7F\xFF\xFF\xFF", 8));
  write_file(scratch / "in/model/huge.png", huge);
  write_file(scratch / "in/model/paint.mtl",
             "newmtl good\nmap_Kd .\\good.png\nnewmtl moved\nmap_Kd C:\\Users\\someone\\My Maps\\good.png\n"
             "newmtl missing\nKd 1 0 0\nmap_Kd nowhere.png\nnewmtl cut\nmap_Kd cut.png\n"
             "newmtl huge\nmap_Kd huge.png\nnewmtl outside\nmap_Kd ../../outside.png\n");
  const std::array<const char*, 6> materials = {"good", "moved", "missing", "cut", "huge", "outside"};
  std::string text = "mtllib paint.mtl\n";
  for (int k = 0; k < 8; ++k) text += fmt::format("v {} {} {}\n", corner(k)[0], corner(k)[1], corner(k)[2]);
  text += "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n";
  for (std::size_t s = 0; s < 6; ++s)
    text += fmt::format("usemtl {}\nf {}/-4 {}/-3 {}/-2 {}/-1\n", materials[s], sides[s][0] + 1,
                        sides[s][1] + 1, sides[s][2] + 1, sides[s][3] + 1);
  write_file(scratch / "in/model/box.obj", text);
  const ProcessResult result = run_textured(scratch / "in", scratch / "s.h5");
  INFO(result.out << result.err);
  REQUIRE(result.exit_code == 0);
  CHECK_THAT(result.out, ContainsSubstring("colors: texture") && ContainsSubstring("color fills"));
  const Row row = row_of(scratch / "s.h5", "model/box.obj");
  CHECK(row.report.color_source == ColorSource::texture);
  const TestImage image = colorful(5, 5);
  const Lookup lookup{image};
  std::uint32_t fills = 0;
  for (std::size_t i = 0; i < row.samples.count(); ++i) {
    const std::uint32_t side = row.samples.face[i];
    const auto place = place_on(side, point_of(row, i));
    const Light expected = side < 2 ? lookup.bilinear(place[0], 1 - place[1]) : Light{204, 204, 204};
    fills += side < 2 ? 0 : 1;
    REQUIRE(difference(row, i, expected) < .6);
  }
  CHECK(row.report.color_fills == fills);
  CHECK(fills > 0);
}

TEST_CASE("run --colors: a changed image is detected, and archives give the bytes of the folder") {
  const ScratchFolder scratch;
  fs::create_directories(scratch / "folder/set/maps");
  write_file(scratch / "folder/set/maps/image.png", png_bytes(colorful(9, 9)));
  write_file(scratch / "folder/set/maps/paint.mtl", "newmtl paint\nmap_Kd image.png\n");
  write_file(scratch / "folder/set/box.obj", box_obj("maps/paint.mtl"));
  write_file(scratch / "folder/set/box.gltf",
             box_gltf(0, 1).with_data_uri(textured(R"({"uri":"maps/image.png"})", "{}")));
  REQUIRE(run_textured(scratch / "folder/set", scratch / "folder.h5").exit_code == 0);
  const std::string expected = read_file(scratch / "folder.h5");
  const Row before = row_of(scratch / "folder.h5", "box.obj");
  CHECK(before.report.color_source == ColorSource::texture);
  CHECK(row_of(scratch / "folder.h5", "box.gltf").report.color_source == ColorSource::texture);
  fs::create_directories(scratch / "zip");
  write_file(scratch / "zip/set.zip", zip_bytes(entries_of(scratch / "folder/set")));
  REQUIRE(run_textured(scratch / "zip/set.zip", scratch / "zip.h5").exit_code == 0);
  CHECK((read_file(scratch / "zip.h5") == expected));

  write_file(scratch / "folder/set/maps/image.png", png_bytes(colorful(8, 8)));
  const ProcessResult again = run_textured(scratch / "folder/set", scratch / "folder.h5", {"--json"});
  CHECK_THAT(again.out, ContainsSubstring("\"changed\":[\"box.gltf\",\"box.obj\"]"));
  REQUIRE(run_textured(scratch / "folder/set", scratch / "new.h5", {"--reuse", scratch / "folder.h5"})
              .exit_code == 0);
  const Row after = row_of(scratch / "new.h5", "box.obj");
  CHECK(after.report.content_sha256 == before.report.content_sha256);
  CHECK(after.report.color_sha256 != before.report.color_sha256);
  CHECK(after.samples.points == before.samples.points);
  CHECK(after.samples.rgb != before.samples.rgb);
}

TEST_CASE("run --colors: the textured files of assimp-testmodels have the colors of their images") {
  const fs::path models = "/usr/share/assimp/models";
  if (!fs::exists(models)) {
    WARN("skipped: assimp-testmodels is not installed");
    return;
  }
  const ScratchFolder scratch;
  for (const char* name :
       {"glTF2/BoxTextured-glTF/BoxTextured.gltf", "glTF2/BoxTextured-glTF-Embedded/BoxTextured.gltf",
        "glTF2/BoxTextured-glTF-Binary/BoxTextured.glb",
        "glTF2/BoxTextured-glTF-pbrSpecularGlossiness/BoxTextured.gltf",
        "glTF2/textureTransform/TextureTransformTest.gltf", "OBJ/spider.obj"}) {
    if (!fs::exists(models / name)) continue;
    const Row row = sampled(models / name, scratch / "s.h5");
    INFO(name);
    CHECK(row.report.color_source == ColorSource::texture);
    CHECK(row.report.color_fills == 0);
  }
  // One picture in four places gives the same colors.
  std::vector<std::vector<std::uint8_t>> boxes;
  for (const char* name :
       {"glTF2/BoxTextured-glTF/BoxTextured.gltf", "glTF2/BoxTextured-glTF-Binary/BoxTextured.glb"})
    if (fs::exists(models / name)) {
      const Row row = sampled(models / name, scratch / "s.h5", "10000");
      std::array<double, 3> mean{};
      for (std::size_t k = 0; k < row.samples.rgb.size(); ++k) mean[k % 3] += row.samples.rgb[k] / 10000.0;
      boxes.push_back({});
      for (const double value : mean) boxes.back().push_back(static_cast<std::uint8_t>(std::lround(value)));
    }
  for (const auto& mean : boxes)
    for (std::size_t c = 0; c < 3; ++c) CHECK(std::abs(mean[c] - boxes[0][c]) <= 2);
}

TEST_CASE(
    "run --density texture: bright parts of large faces get the samples, of OBJ, GLB, archive and folder") {
  const ScratchFolder scratch;
  fs::create_directories(scratch / "in");
  // Across the image the left half is black.
  const TestImage halves(
      64, 64, [](std::uint32_t x, std::uint32_t) { return std::vector<int>(3, x < 32 ? 0 : 255); });
  write_file(scratch / "in/box.obj", box_obj());
  write_file(scratch / "in/paint.mtl", "newmtl paint\nmap_Kd -clamp on image.png\n");
  write_file(scratch / "in/image.png", png_bytes(halves));
  GltfFile gltf = box_gltf(0, 1);
  const std::string embedded = image_in_view(gltf, png_bytes(halves), "image/png");
  write_file(scratch / "box.glb", gltf.glb(textured(embedded, R"({"wrapS":33071,"wrapT":33071})")));
  std::vector<ArchiveEntry> members;
  for (const char* name : {"box.obj", "paint.mtl", "image.png"}) {
    ArchiveEntry member;
    member.name = name;
    member.content = read_file(scratch / "in" / name);
    members.push_back(member);
  }
  write_file(scratch / "in.zip", zip_bytes(members));
  const auto dark_share = [&](const fs::path& input, const char* density) {
    const ProcessResult result =
        run_textured(input, scratch / "s.h5", {"--fresh", "--density", density}, "20000");
    INFO(result.out << result.err);
    REQUIRE(result.exit_code == 0);
    CHECK(result.out.find("no texture") == std::string::npos);
    const Row row = StoreReader(scratch / "s.h5").read_row(0);
    REQUIRE(row.report.color_source == ColorSource::texture);
    const std::uint32_t per_side = input.extension() == ".glb" ? 2 : 1;
    double dark = 0;
    for (std::size_t i = 0; i < row.samples.count(); ++i)
      dark += place_on(row.samples.face[i] / per_side, point_of(row, i))[0] < .5 ? 1 : 0;
    return dark / static_cast<double>(row.samples.count());
  };
  for (const char* input : {"in", "box.glb", "in.zip"}) {
    INFO(input);
    // Half of the pixel at the edge is a ramp between the two.
    CHECK(dark_share(scratch / input, "texture") == Approx(.02 / 1.02).margin(.01));
    CHECK(dark_share(scratch / input, "texture-inverse") == Approx(1 / 1.02).margin(.01));
  }
}

TEST_CASE("run --density texture: the same for any threads, different for another image, 1 without any") {
  const ScratchFolder scratch;
  fs::create_directories(scratch / "in");
  write_file(scratch / "in/box.obj", box_obj());
  write_file(scratch / "in/paint.mtl", "newmtl paint\nmap_Kd image.png\n");
  write_file(scratch / "in/image.png", png_bytes(colorful(40, 30)));
  const auto rows = [&](const Words& more) {
    Words arguments = {"--fresh", "--density", "texture"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const ProcessResult result = run_textured(scratch / "in", scratch / "s.h5", arguments);
    INFO(result.out << result.err);
    REQUIRE(result.exit_code == 0);
    return std::pair(StoreReader(scratch / "s.h5").read_row(0), result.out);
  };
  const Row one = rows({"--threads", "1"}).first;
  CHECK(rows({"--threads", "4"}).first.samples.points == one.samples.points);
  CHECK(*std::min_element(one.samples.density.begin(), one.samples.density.end()) <
        *std::max_element(one.samples.density.begin(), one.samples.density.end()));
  write_file(scratch / "in/image.png", png_bytes(colorful(41, 30)));
  const Row other = rows({}).first;
  CHECK(other.samples.points != one.samples.points);
  CHECK(other.report.color_sha256 != one.report.color_sha256);
  fs::remove(scratch / "in/image.png");
  const auto [lost, summary] = rows({});
  CHECK(lost.report.measure == lost.report.area);
  CHECK(summary.find("no texture                   1   their density is 1") != std::string::npos);
  const ProcessResult refused =
      run_textured(scratch / "in", scratch / "t.h5", {"--density", "texture", "--method", "anisotropic"});
  CHECK(refused.exit_code == 2);
  CHECK(refused.err.find("`texture` does not go with the method anisotropic") != std::string::npos);
}

TEST_CASE("run --colors: companions in another case are found, the same in folders, zip and tar") {
  const ScratchFolder scratch;
  fs::create_directories(scratch / "in/MAPS");
  write_file(scratch / "in/Box.obj", box_obj("maps/Paint.mtl"));
  write_file(scratch / "in/MAPS/PAINT.MTL", "newmtl paint\nmap_Kd Image.PNG\n");
  write_file(scratch / "in/MAPS/image.png", png_bytes(colorful(9, 6)));
  const auto same_everywhere = [&](const char* source) {
    const std::vector<ArchiveEntry> members = entries_of(scratch / "in");
    write_file(scratch / "in.zip", zip_bytes(members));
    write_file(scratch / "in.tar", tar_bytes(members));
    write_file(scratch / "in.tar.gz", gzip_bytes(tar_bytes(members)));
    const Row folder = sampled(scratch / "in", scratch / "s.h5");
    CHECK(name_of(folder.report.color_source) == std::string(source));
    for (const char* archive : {"in.zip", "in.tar", "in.tar.gz"}) {
      INFO(archive);
      const Row packed = sampled(scratch / archive, scratch / "s.h5");
      CHECK(packed.samples.rgb == folder.samples.rgb);
      CHECK(packed.report.color_sha256 == folder.report.color_sha256);
      CHECK(packed.report.color_source == folder.report.color_source);
    }
    return folder;
  };
  const Row first = same_everywhere("texture");
  // Of several the first by bytes, and what is exact before that, also where it leads through another folder.
  write_file(scratch / "in/MAPS/IMAGE.png", png_bytes(colorful(4, 4)));
  const Row capital = same_everywhere("texture");
  CHECK(capital.samples.rgb != first.samples.rgb);
  write_file(scratch / "in/MAPS/Image.PNG", png_bytes(colorful(9, 6)));
  CHECK(same_everywhere("texture").samples.rgb == first.samples.rgb);
  fs::create_directories(scratch / "in/maps");
  write_file(scratch / "in/maps/other.txt", "");  // leads nowhere
  CHECK(same_everywhere("texture").samples.rgb == first.samples.rgb);
  write_file(scratch / "in/maps/paint.mtl", "newmtl paint\nKd 1 0 0\n");
  CHECK(same_everywhere("material").samples.rgb != first.samples.rgb);
}

namespace {

// Lines of README that read data sets as they are handed out, word by word.
std::vector<Words> commands_of_readme() {
  std::istringstream text(read_file(fs::path(MEANDER_SOURCE_DIR) / "README.md"));
  std::vector<Words> commands;
  for (std::string line; std::getline(text, line);) {
    if (!line.starts_with("    meander run ") || line.find(" # ") == std::string::npos) continue;
    std::istringstream words(line.substr(0, line.find('#')));
    Words command;
    for (std::string word; words >> word;) command.push_back(word);
    command.erase(command.begin());                            // the program
    if (command[1] != "models/") commands.push_back(command);  // of the user's own
  }
  return commands;
}

std::string lossless_webp(const TestImage& image) {
  std::uint8_t* data = nullptr;
  const std::size_t size =
      WebPEncodeLosslessRGB(image.rgb.data(), static_cast<int>(image.width), static_cast<int>(image.height),
                            static_cast<int>(3 * image.width), &data);
  std::string bytes(reinterpret_cast<char*>(data), size);
  WebPFree(data);
  return bytes;
}

void put_modelnet(const fs::path& root) {
  for (const char* const name :
       {"chair/train/chair_0001", "chair/test/chair_0890", "sofa/train/sofa_0001", "sofa/test/sofa_0681"}) {
    fs::create_directories((root / name).parent_path());
    // As the data set has it: the counts behind the keyword without a blank.
    std::string text = "OFF8 6 0\n";
    for (int k = 0; k < 8; ++k) text += fmt::format("{} {} {}\n", corner(k)[0], corner(k)[1], corner(k)[2]);
    for (const auto& side : sides) text += fmt::format("4 {} {} {} {}\n", side[0], side[1], side[2], side[3]);
    write_file(root / (std::string(name) + ".off"), text);
  }
}

// A model of PartNet-Mobility or ShapeNet: images beside the folder of the models.
void put_with_images_beside(const fs::path& folder, const char* models, const char* name,
                            const TestImage& image) {
  fs::create_directories(folder / models);
  fs::create_directories(folder / "images");
  write_file(folder / models / (std::string(name) + ".obj"), box_obj(std::string(name) + ".mtl"));
  write_file(folder / models / (std::string(name) + ".mtl"),
             "newmtl paint\nKd 1 1 1\nmap_Kd ../images/texture0.png\n");
  write_file(folder / "images/texture0.png", png_bytes(image));
}

// The box of box_gltf behind Draco, with its image as WebP alone.
std::string draco_box_with_webp(const TestImage& image) {
  std::vector<float> points, coordinates;
  std::vector<std::uint16_t> indices;
  for (std::uint16_t s = 0; s < 6; ++s) {
    for (std::size_t k = 0; k < 4; ++k) {
      for (const double x : corner(sides[s][k])) points.push_back(static_cast<float>(x));
      coordinates.push_back(k == 1 || k == 2 ? 1.f : 0.f);
      coordinates.push_back(k >= 2 ? 0.f : 1.f);
    }
    for (const int k : {0, 1, 2, 0, 2, 3}) indices.push_back(static_cast<std::uint16_t>(4 * s + k));
  }
  GltfFile file;
  const std::string stream =
      draco_stream_of({DracoValues(draco::GeometryAttribute::POSITION, 3, points),
                       DracoValues(draco::GeometryAttribute::TEX_COORD, 2, coordinates)},
                      indices, draco::MESH_SEQUENTIAL_ENCODING);
  const int view = file.add_view(stream), picture = file.add_view(lossless_webp(image));
  file.add_accessor(-1, 5126, indices.size(), "VEC3");
  file.add_accessor(-1, 5123, indices.size(), "SCALAR");
  file.add_accessor(-1, 5126, indices.size(), "VEC2");
  return file.glb(fmt::format(
      R"(,"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,"TEXCOORD_0":2}},"indices":1,"material":0,)"
      R"("extensions":{{"KHR_draco_mesh_compression":{{"bufferView":{},"attributes":{{"POSITION":0,"TEXCOORD_0":1}}}}}}}}]}}],)"
      R"("nodes":[{{"mesh":0}}],"materials":[{{"pbrMetallicRoughness":{{"baseColorTexture":{{"index":0}}}}}}],)"
      R"("textures":[{{"extensions":{{"EXT_texture_webp":{{"source":0}}}}}}],)"
      R"("images":[{{"bufferView":{},"mimeType":"image/webp"}}],)"
      R"("extensionsRequired":["KHR_draco_mesh_compression","EXT_texture_webp"])",
      view, picture));
}

// The largest difference to the image over the samples of the sides of a box of OBJ.
double largest_difference(const Row& row, const TestImage& image) {
  REQUIRE(row.report.status == Status::ok);
  REQUIRE(row.report.color_source == ColorSource::texture);
  REQUIRE(row.report.color_fills == 0);
  REQUIRE(row.report.note_text.empty());
  const Lookup lookup{image};
  double largest = 0;
  for (std::size_t i = 0; i < row.samples.count(); ++i) {
    const auto place = place_on(row.samples.face[i], point_of(row, i));
    largest = std::max(largest, difference(row, i, lookup.bilinear(place[0], 1 - place[1])));
  }
  return largest;
}

}  // namespace

TEST_CASE("README: its commands for data sets give classes, splits and the color of every sample") {
  const ScratchFolder scratch;
  const TestImage image = colorful(9, 7);
  put_modelnet(scratch / "ModelNet40");
  for (const char* const model :
       {"03001627/1a6f615e8b1b5ae4dbbc9440457e303e", "02691156/10155655850468db78d106ce0a280f87"})
    put_with_images_beside(scratch / "ShapeNetCore.v2" / model, "models", "model_normalized", image);
  write_file(scratch / "ShapeNetCore.v2.zip",
             zip_bytes(entries_of(scratch / "ShapeNetCore.v2", "ShapeNetCore.v2/")));
  fs::remove_all(scratch / "ShapeNetCore.v2");
  const fs::path glbs = scratch / "glbs/000-023";
  fs::create_directories(glbs);
  write_file(glbs / "8476c4170df24cf5bbe6967222d1a42d.glb", draco_box_with_webp(image));
  GltfFile plain = box_gltf(0, 1);
  const std::string view = image_in_view(plain, png_bytes(image), "image/png");
  write_file(glbs / "9476c4170df24cf5bbe6967222d1a42d.glb", plain.glb(textured(view, "{}")));
  const std::vector<Words> commands = commands_of_readme();
  REQUIRE(commands.size() == 3);
  ProcessOptions there;
  const std::string folder = scratch.path().string();
  there.in_child = [&folder] {
    if (::chdir(folder.c_str()) != 0) std::abort();
  };
  for (const Words& command : commands) {
    const ProcessResult result = meander_with(command, there);
    INFO(command[1] << result.out << result.err);
    REQUIRE(result.exit_code == 0);
  }
  const StoreReader modelnet(scratch / "modelnet40.h5");
  REQUIRE(modelnet.rows() == 4);
  CHECK(modelnet.label_names() == std::vector<std::string>{"chair", "sofa"});
  CHECK(modelnet.split(0) == Split::test);
  CHECK(modelnet.split(1) == Split::train);
  CHECK(modelnet.report(0).area == Approx(22));
  const StoreReader shapenet(scratch / "shapenet.h5");
  REQUIRE(shapenet.rows() == 2);
  CHECK(shapenet.label_names() == std::vector<std::string>{"02691156", "03001627"});
  for (std::uint64_t row = 0; row < 2; ++row) CHECK(largest_difference(shapenet.read_row(row), image) < 1.1);
  const StoreReader objaverse(scratch / "objaverse.h5");
  REQUIRE(objaverse.rows() == 2);
  CHECK(objaverse.samples() == 10000);
  Lookup lookup{image};
  lookup.linear = true;
  for (std::uint64_t row = 0; row < 2; ++row) {
    CHECK(objaverse.report(row).note_text.empty());
    CHECK(most_difference(objaverse.read_row(row), lookup, 0, 1, false) < 1.1);
  }
}

TEST_CASE("run --colors: PartNet parts find the images next to the folder of their models") {
  const ScratchFolder scratch;
  const TestImage image = colorful(6, 6);
  put_with_images_beside(scratch / "dataset/100013", "textured_objs", "original-1", image);
  CHECK(largest_difference(sampled(scratch / "dataset", scratch / "s.h5"), image) < 1.1);
  CHECK(largest_difference(sampled(scratch / "dataset/100013", scratch / "s.h5"), image) < 1.1);
}
