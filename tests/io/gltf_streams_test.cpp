// Compressed geometry, and files that are damaged, hostile or of others.
#include <draco/compression/expert_encode.h>
#include <fmt/format.h>
#include <meshoptimizer.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>
#include <map>
#include <memory>
#include <set>

#include "gltf_reading.h"
#include "io/archive/model_bytes.h"
#include "kernels/core/random.h"
#include "kernels/core/vector3.h"
#include "kernels/mesh/surface_textures.h"
#include "support/catch.h"
#include "support/gltf_streams.h"

using namespace meander;
using namespace meander::test;
using Catch::Matchers::ContainsSubstring;

namespace {

namespace fs = std::filesystem;

// Triangles as positions, in an order of their own.
std::multiset<std::array<double, 9>> triangle_set(const PolygonMesh& m) {
  std::multiset<std::array<double, 9>> set;
  for (std::size_t c = 0; c + 2 < m.corners.size(); c += 3) {
    std::size_t first = 0;
    for (std::size_t k = 1; k < 3; ++k)
      if (point(m, m.corners[c + k]) < point(m, m.corners[c + first])) first = k;
    std::array<double, 9> values{};
    for (std::size_t k = 0; k < 3; ++k)
      std::ranges::copy(point(m, m.corners[c + (first + k) % 3]), values.begin() + 3 * k);
    set.insert(values);
  }
  return set;
}

PolygonMesh plain_grid(const BentGrid& grid) {
  GltfFile file;
  file.add_points(grid.points);
  file.add_indices(grid.indices);
  return read_gltf_file(file.glb(primitive_of(",\"indices\":1")));
}

// Whatever becomes of it: a mesh that holds together, or a status with a sentence.
void check_answer(const std::string& content) {
  try {
    check_consistent(read_gltf_file(content));
  } catch (const ItemError& error) {
    const bool is_known = error.status() == Status::unreadable || error.status() == Status::empty ||
                          error.status() == Status::unsupported_format;
    INFO(error.what());
    REQUIRE(is_known);
    REQUIRE(std::strlen(error.what()) > 5);
  }
}

void check_cuts_and_flips(const std::string& content) {
  // What claims more than this is refused before memory is taken.
  for (std::size_t bytes = 0; bytes < content.size(); ++bytes) {
    const std::optional<ItemError> error =
        failure(std::string_view(content).substr(0, bytes), MeshFormat::gltf);
    REQUIRE(error);
    REQUIRE((error->status() == Status::unreadable || error->status() == Status::empty));
  }
  const MeshSurroundings around{{}, [](const MeshEstimate& needs) {
                                  if (needs.vertices + needs.triangles + needs.decoding_bytes > (1 << 24))
                                    throw ItemError(Status::unreadable, "more than there is room for");
                                }};
  for (std::size_t at = 0; at < content.size(); ++at)
    for (const int flip : {0x01, 0x80, 0xFF}) {
      std::string damaged = content;
      damaged[at] = static_cast<char>(damaged[at] ^ flip);
      try {
        check_consistent(read_gltf_file(damaged, around));
      } catch (const ItemError& error) {
        if (std::strlen(error.what()) < 6) FAIL("byte " << at << ": no sentence");
      }
    }
}

using Case = std::pair<std::string, std::string>;  // a file, and what is said of it

std::vector<Case> odd_documents() {
  const auto glb = [](const std::string& rest) { return cube_file().glb(rest); };
  const std::string deep = std::string(100000, '[') + std::string(100000, ']');
  return {
      {glb(plain_cube + R"(,"extensionsRequired":["KHR_texture_transform","ACME_curves","ACME_wheels"])"),
       "unsupported_format: it requires extensions that are not read: ACME_curves, ACME_wheels"},
      {R"({"asset":{"version":"1.0"}})", "unsupported_format: glTF 1.0"},
      {R"({"asset":{"version":"3.1"}})", "unsupported_format: glTF 3.1"},
      {R"({"accessors":{}})", "unsupported_format: glTF 1.0"},
      {std::string("glTF\1\0\0\0", 8) + std::string(12, '\0'),
       "unsupported_format: binary glTF of version 1"},
      {R"({})", "unreadable: not a glTF file: it lacks `asset`"},
      {"[1,2]", "unreadable: by its name this is a glTF file"},
      {"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", "by its content it is an OFF file"},
      {" \n ", "empty: the file holds nothing but blanks"},
      {R"({"asset":{"version":"2.0"},"extras":)" + deep + "}", "nests deeper than 200 levels"},
      {R"({"asset":{"version":"2.0"},"x":1e999})", "unreadable: not valid JSON"},
      {glb("," + cube_mesh + R"(,"nodes":[{"mesh":0,"children":[1]},{"children":[0]}])"),
       "nodes[0]: it is below itself"},
      {glb("," + cube_mesh + R"(,"nodes":[{"children":[0]}])"), "nodes[0]: it is below itself"},
      {glb("," + cube_mesh + R"(,"nodes":[{"children":[1]},{"children":[2]},{"mesh":0,"children":[1]}])"),
       "nodes[1]: it is below itself"},
      {glb("," + cube_mesh + R"(,"nodes":[{"mesh":0,"weights":["a"]}])"),
       "nodes[0]: `weights` is not a list of numbers"},
      {glb("," + cube_mesh + R"(,"nodes":[{"children":[7]}])"), "nodes[7]: there is no such node"},
      {glb("," + cube_mesh + R"(,"nodes":[{"mesh":3}])"), "nodes[0]: there is no mesh 3"},
      {glb("," + cube_mesh + R"(,"nodes":[{"mesh":-1}])"), "nodes[0]: `mesh` is not the number of an entry"},
      {glb("," + cube_mesh + R"(,"nodes":[{"mesh":0,"matrix":[1,2]}])"),
       "`matrix` is not a list of 16 numbers"},
      {glb("," + cube_mesh + R"(,"nodes":[{"mesh":0}],"scene":4)"), "`scene` is 4, and there are 0 scenes"},
      {glb(plain_cube + R"(,"skins":7)"), "`skins` is not a list"}};
}

std::vector<Case> odd_buffers() {
  const auto views = [](const std::string& view, const std::string& accessor) {
    return GltfFile::glb_of(R"({"asset":{"version":"2.0"},"buffers":[{"byteLength":64}],"bufferViews":[)" +
                                view + R"(],"accessors":[)" + accessor +
                                R"(],"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}]})",
                            std::string(64, '\0'));
  };
  const std::string vec3 = R"({"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"})";
  return {
      {views(R"({"buffer":0,"byteLength":65})", vec3), "bytes 0 to 65 of a buffer that has 64"},
      {views(R"({"buffer":0,"byteOffset":9007199254740992,"byteLength":64})", vec3),
       "of a buffer that has 64"},
      {views(R"({"buffer":4,"byteLength":64})", vec3), "there is no buffer 4"},
      {views(R"({"buffer":0,"byteLength":1e300})", vec3), "`byteLength` is not a whole number"},
      {views(R"({"buffer":0,"byteLength":64,"byteStride":70000})", vec3), "a `byteStride` of 70000 is none"},
      {views(R"({"buffer":0,"byteLength":64,"byteStride":40})", vec3), "3 elements of 12 bytes, 40 apart"},
      {views(R"({"buffer":0,"byteLength":64})",
             R"({"bufferView":0,"componentType":5126,"count":4294967290,"type":"VEC3"})"),
       "4294967290 elements"},
      {views(R"({"buffer":0,"byteLength":64})",
             R"({"bufferView":0,"componentType":5126,"count":9007199254740992,"type":"VEC3"})"),
       "unsupported_format: 9007199254740992 elements of an accessor are more than 32 bits can number"},
      {views(R"({"buffer":0,"byteLength":64})",
             R"({"bufferView":0,"byteOffset":60,"componentType":5126,"count":1,"type":"VEC3"})"),
       "from byte 60"},
      {views(R"({"buffer":0,"byteLength":64})",
             R"({"bufferView":9,"componentType":5126,"count":3,"type":"VEC3"})"),
       "there is no buffer view 9"},
      {views(R"({"buffer":0,"byteLength":64})",
             R"({"bufferView":0,"componentType":5130,"count":3,"type":"VEC3"})"),
       "`componentType` is 5130, which is no type"},
      {views(R"({"buffer":0,"byteLength":64})",
             R"({"bufferView":0,"componentType":5126,"count":3,"type":"VEC2"})"),
       "positions are three numbers"},
      {views(
           R"({"buffer":0,"byteLength":64,"extensions":{"EXT_meshopt_compression":{"buffer":0,"byteLength":64,"byteStride":256,"count":4000000000,"mode":"ATTRIBUTES"}}})",
           vec3),
       "64 bytes cannot unpack to 1024000000000"},
      {views(
           R"({"buffer":0,"byteLength":64,"extensions":{"EXT_meshopt_compression":{"buffer":0,"byteLength":64,"byteStride":12,"count":3,"mode":"ATTRIBUTES"}}})",
           vec3),
       "its compressed data are damaged"},
  };
}

}  // namespace

TEST_CASE("glTF: Draco streams decode to the mesh that was encoded") {
  const BentGrid grid(9);
  const std::size_t vertices = grid.points.size() / 3, indices = grid.indices.size();
  const auto expected = triangle_set(plain_grid(grid));
  for (const int method : {draco::MESH_SEQUENTIAL_ENCODING, draco::MESH_EDGEBREAKER_ENCODING}) {
    const std::string stream = draco_stream(grid, method);
    const PolygonMesh mesh = read_gltf_file(draco_file(stream, vertices, indices));
    check_consistent(mesh);
    CHECK(triangle_set(mesh) == expected);
    CHECK_THAT(gltf_outcome(draco_file(stream, vertices - 1, indices)),
               ContainsSubstring("unreadable: the Draco stream"));
    CHECK_THAT(gltf_outcome(draco_file(stream, vertices, indices - 3)),
               ContainsSubstring("triangles, its accessors"));
    CHECK_THAT(gltf_outcome(draco_file(stream, vertices, indices, 7)),
               ContainsSubstring("it has no attribute 7"));
    check_cuts_and_flips(draco_file(stream, vertices, indices));
  }
  CHECK_THAT(gltf_outcome(draco_file("DRACO", vertices, indices)),
             ContainsSubstring("has no header of Draco"));
  CHECK_THAT(gltf_outcome(draco_file("DRACO", 1 << 30, 3 << 20)),
             ContainsSubstring("5 bytes of Draco cannot hold"));
}

TEST_CASE("glTF: Draco colors may be floats or bytes, and invalid colors do not fail the model") {
  const BentGrid grid(9);
  const std::size_t vertices = grid.points.size() / 3, indices = grid.indices.size();
  const auto read = [&](const std::string& stream, const char* type, int component, const char* ids) {
    GltfFile file;
    file.add_view(stream);
    file.add_accessor(-1, 5126, vertices, "VEC3");
    file.add_accessor(-1, 5125, indices, "SCALAR");
    file.add_accessor(-1, component, vertices, type, component == 5126 ? "" : ",\"normalized\":true");
    const std::string bytes = file.glb(
        R"(,"meshes":[{"primitives":[{"attributes":{"POSITION":0,"COLOR_0":2},"indices":1,"extensions":)"
        R"({"KHR_draco_mesh_compression":{"bufferView":0,"attributes":)" +
        std::string(ids) +
        R"(}}}]}],"nodes":[{"mesh":0}],"extensionsRequired":["KHR_draco_mesh_compression"])");
    MeshSurroundings around;
    around.colors = true;
    return read_mesh(std::as_bytes(std::span(bytes)), MeshFormat::gltf, {}, around);
  };
  const char* const both = R"({"POSITION":0,"COLOR_0":1})";
  for (const int method : {draco::MESH_SEQUENTIAL_ENCODING, draco::MESH_EDGEBREAKER_ENCODING})
    for (const auto& [bytes, normalized] : {std::pair{false, false}, {true, false}, {true, true}}) {
      const std::string stream = colored_draco_stream(grid, method, bytes, normalized);
      const PolygonMesh mesh = read(stream, "VEC4", bytes ? 5121 : 5126, both);
      INFO(method << " " << bytes << " " << normalized);
      CHECK(mesh.colors.linear);
      REQUIRE(mesh.colors.vertex.size() == 3 * mesh.vertex_count());
      double worst = 0;
      for (std::size_t v = 0; v < mesh.vertex_count(); ++v)
        for (const double difference :
             {mesh.colors.vertex[3 * v] - mesh.x[v] / 16, mesh.colors.vertex[3 * v + 1] - mesh.y[v] / 16,
              mesh.colors.vertex[3 * v + 2] - 1.0})
          worst = std::max(worst, std::abs(difference));
      CHECK(worst < 0.003);
      // Another width, an id that is not there, and none.
      for (const PolygonMesh& without : {read(stream, "VEC3", 5126, both), read(stream, "VEC2", 5126, both),
                                         read(stream, "VEC4", 5126, R"({"POSITION":0,"COLOR_0":7})"),
                                         read(stream, "VEC4", 5126, R"({"POSITION":0,"COLOR_0":"x"})"),
                                         read(stream, "VEC4", 5126, R"({"POSITION":0})")}) {
        CHECK(without.x == mesh.x);
        CHECK(std::all_of(without.colors.vertex.begin(), without.colors.vertex.end(),
                          [](float value) { return std::isnan(value); }));
      }
    }
}

namespace {

template <class T>
std::vector<T> scaled_cube() {
  std::vector<T> values;
  for (const float value : gltf_cube_points)
    values.push_back(static_cast<T>(value == 0 && std::is_signed_v<T> ? -std::numeric_limits<T>::max()
                                    : value == 0                      ? 0
                                                                      : std::numeric_limits<T>::max()));
  return values;
}

// Two units wide, of positions of type T that are fractions or as they are.
template <class T>
PolygonMesh draco_cube(int component, bool normalized, bool marked, int method) {
  const std::string stream = draco_stream_of(
      {{draco::GeometryAttribute::POSITION, 3, scaled_cube<T>(), marked}}, gltf_cube_indices, method);
  GltfFile file;
  file.add_view(stream);
  file.add_accessor(-1, component, 8, "VEC3", normalized ? ",\"normalized\":true" : "");
  file.add_accessor(-1, 5123, 36, "SCALAR");
  return read_gltf_file(
      file.glb(primitive_of(R"(,"indices":1,"extensions":{"KHR_draco_mesh_compression":)"
                            R"({"bufferView":0,"attributes":{"POSITION":0}}})") +
               R"(,"extensionsRequired":["KHR_draco_mesh_compression","KHR_mesh_quantization"])"));
}

}  // namespace

TEST_CASE("glTF: Draco integers are normalized as their accessor says, whatever the stream says") {
  for (const int method : {draco::MESH_SEQUENTIAL_ENCODING, draco::MESH_EDGEBREAKER_ENCODING})
    for (const bool marked : {false, true}) {
      INFO(method << " " << marked);
      CHECK(area_of(draco_cube<std::int8_t>(5120, true, marked, method)) == Approx(24));
      CHECK(area_of(draco_cube<std::uint8_t>(5121, true, marked, method)) == Approx(6));
      CHECK(area_of(draco_cube<std::int16_t>(5122, true, marked, method)) == Approx(24));
      CHECK(area_of(draco_cube<std::uint16_t>(5123, true, marked, method)) == Approx(6));
      CHECK(area_of(draco_cube<std::int8_t>(5120, false, marked, method)) == Approx(24 * 127 * 127));
      CHECK(area_of(draco_cube<std::uint16_t>(5123, false, marked, method)) == Approx(6.0 * 65535 * 65535));
      CHECK(box_of(draco_cube<std::int16_t>(5122, true, marked, method)) == Box{-1, 1, -1, 1, -1, 1});
    }
}

TEST_CASE("glTF: coordinates, weights, colors and attributes are the same with and without Draco") {
  using Kind = draco::GeometryAttribute;
  std::vector<std::uint16_t> coordinates;
  std::vector<std::uint8_t> joints, weights, colors;
  std::vector<std::int16_t> asked;
  for (std::size_t v = 0; v < 8; ++v) {
    coordinates.insert(coordinates.end(), {static_cast<std::uint16_t>(v % 2 * 65535),
                                           static_cast<std::uint16_t>(13107 * (v / 2))});
    const bool upper = v >= 4;
    joints.insert(joints.end(), {0, 1, 0, 0});
    weights.insert(weights.end(), {static_cast<std::uint8_t>(upper ? 51 : 255),
                                   static_cast<std::uint8_t>(upper ? 204 : 0), 0, 0});
    colors.insert(colors.end(), {255, static_cast<std::uint8_t>(51 * v % 255), 0});
    asked.insert(asked.end(), {static_cast<std::int16_t>(v % 2 == 1 ? 32767 : -32767)});
  }
  const char* const share = ",\"normalized\":true";
  const std::string scene =
      R"(}],"skins":[{"joints":[1,2]}],"materials":[{"pbrMetallicRoughness":{"baseColorTexture":{"index":0}}}],)"
      R"("textures":[{}],"nodes":[{"mesh":0,"skin":0},{},{"translation":[0,0,5]}])";
  const std::string attributes =
      R"(,"meshes":[{"primitives":[{"attributes":{"POSITION":0,"TEXCOORD_0":2,"JOINTS_0":3,"WEIGHTS_0":4,"COLOR_0":5,"_Q":6},)"
      R"("indices":1,"material":0)";
  const std::vector<AttributeColumn> columns = {{"_Q", 1}};
  MeshSurroundings around;
  around.colors = true;
  around.extras = {true, columns};
  const auto sorted = [](const PolygonMesh& mesh) {
    std::multiset<std::vector<double>> rows;
    for (std::size_t c = 0; c < mesh.corners.size(); ++c) {
      const std::size_t v = mesh.corners[c], t = mesh.coordinates.corner.at(c),
                        s = mesh.colors.textures->corner.at(c);
      rows.insert({mesh.x[v], mesh.y[v], mesh.z[v], mesh.coordinates.values[2 * t],
                   mesh.coordinates.values[2 * t + 1], mesh.colors.textures->coordinates[2 * s + 1],
                   mesh.colors.vertex[3 * v + 1], mesh.asked_attributes.at(0).values[v]});
    }
    return rows;
  };
  GltfFile plain;
  plain.add_points(gltf_cube_points);
  plain.add_indices(gltf_cube_indices);
  plain.add_accessor(plain.add_view(coordinates), 5123, 8, "VEC2", share);
  plain.add_accessor(plain.add_view(joints), 5121, 8, "VEC4");
  plain.add_accessor(plain.add_view(weights), 5121, 8, "VEC4", share);
  std::string padded_colors, padded_asked;
  for (std::size_t v = 0; v < 8; ++v)
    padded_colors +=
        std::string(reinterpret_cast<const char*>(colors.data() + 3 * v), 3) + std::string(1, '\0');
  plain.add_accessor(plain.add_view(padded_colors, ",\"byteStride\":4"), 5121, 8, "VEC3", share);
  plain.add_accessor(plain.add_view(asked), 5122, 8, "SCALAR", share);
  const PolygonMesh expected = read_gltf_file(plain.glb(attributes + "}]" + scene), around);
  const auto rows = sorted(expected);
  CHECK(box_of(expected)[5] == Approx(5));
  for (const bool marked : {false, true}) {
    GltfFile packed;
    packed.add_view(draco_stream_of({{Kind::POSITION, 3, gltf_cube_points},
                                     {Kind::TEX_COORD, 2, coordinates, marked},
                                     {Kind::GENERIC, 4, joints, marked},
                                     {Kind::GENERIC, 4, weights, marked},
                                     {Kind::COLOR, 3, colors, marked},
                                     {Kind::GENERIC, 1, asked, marked}},
                                    gltf_cube_indices, draco::MESH_SEQUENTIAL_ENCODING));
    packed.add_accessor(-1, 5126, 36, "VEC3");
    packed.add_accessor(-1, 5123, 36, "SCALAR");
    packed.add_accessor(-1, 5123, 36, "VEC2", share);
    packed.add_accessor(-1, 5121, 36, "VEC4");
    packed.add_accessor(-1, 5121, 36, "VEC4", share);
    packed.add_accessor(-1, 5121, 36, "VEC3", share);
    packed.add_accessor(-1, 5122, 36, "SCALAR", share);
    const auto ids = [](const char* list) {
      return std::string(R"(,"extensions":{"KHR_draco_mesh_compression":{"bufferView":0,"attributes":)") +
             list + "}}}]";
    };
    const char* const all = R"({"POSITION":0,"TEXCOORD_0":1,"JOINTS_0":2,"WEIGHTS_0":3,"COLOR_0":4,"_Q":5})";
    INFO(marked);
    CHECK(sorted(read_gltf_file(packed.glb(attributes + ids(all) + scene), around)) == rows);
  }
}

TEST_CASE("glTF: attributes and morph targets outside a Draco stream are read as usual") {
  GltfFile file;
  file.add_view(draco_stream_of({{draco::GeometryAttribute::POSITION, 3, gltf_cube_points}},
                                gltf_cube_indices, draco::MESH_EDGEBREAKER_ENCODING));
  file.add_accessor(-1, 5126, 8, "VEC3");
  file.add_accessor(-1, 5123, 36, "SCALAR");
  const std::string stream =
      R"("indices":1,"extensions":{"KHR_draco_mesh_compression":{"bufferView":0,"attributes":{"POSITION":0}}})";
  const PolygonMesh base = read_gltf_file(
      file.glb(R"(,"meshes":[{"primitives":[{"attributes":{"POSITION":0},)" + stream + "}]}]"));
  REQUIRE(base.vertex_count() == 8);
  std::vector<float> deltas, colors;
  for (std::size_t v = 0; v < 8; ++v) {
    deltas.insert(deltas.end(), {0, 0, static_cast<float>(2 * base.z[v])});
    colors.insert(colors.end(), {static_cast<float>(base.x[v]), 1, 7});
  }
  file.add_points(deltas);
  file.add_points(colors);
  MeshSurroundings around;
  around.colors = true;
  const PolygonMesh mesh = read_gltf_file(
      file.glb(
          R"(,"meshes":[{"weights":[0.5],"primitives":[{"attributes":{"POSITION":0,"COLOR_0":3},"targets":[{"POSITION":2}],)" +
          stream + "}]}]"),
      around);
  CHECK(box_of(mesh) == Box{0, 1, 0, 1, 0, 2});
  CHECK(signed_volume(mesh) == Approx(2));
  for (std::size_t v = 0; v < 8; ++v) {
    CHECK(mesh.colors.vertex[3 * v] == mesh.x[v]);
    CHECK(mesh.colors.vertex[3 * v + 2] == 1);  // clamped, never taken for one of 255
  }
  CHECK_THAT(
      gltf_outcome(file.glb(
          R"(,"meshes":[{"weights":[1],"primitives":[{"attributes":{"POSITION":0},"targets":[{"POSITION":1}],)" +
          stream + "}]}]")),
      ContainsSubstring("accessors[1]: a morph target of other than 8 vertices"));
  // Positions as well may stand beside the stream of the corners.
  const PolygonMesh swapped = read_gltf_file(
      file.glb(R"(,"meshes":[{"primitives":[{"attributes":{"POSITION":3},"indices":1,"extensions":)"
               R"({"KHR_draco_mesh_compression":{"bufferView":0,"attributes":{"COLOR_0":0}}}}]}])"));
  CHECK(box_of(swapped) == Box{0, 1, 1, 1, 7, 7});
}

TEST_CASE("glTF: normalized and sparse meshopt streams give the same fractions as plain accessors") {
  const auto check = [](auto type, int component) {
    using T = decltype(type);
    std::vector<T> rows;  // of four, as views of 8 and 16 bits are padded
    const std::vector<T> cube = scaled_cube<T>();
    for (std::size_t v = 0; v < 8; ++v)
      for (std::size_t k = 0; k < 4; ++k) rows.push_back(k < 3 ? cube[3 * v + k] : T{0});
    const std::size_t stride = 4 * sizeof(T);
    GltfFile file;
    const int packed = add_packed(file, packed_vertices(rows.data(), 8, stride), 8, stride, "ATTRIBUTES");
    const int plain = file.add_view(rows, ",\"byteStride\":" + std::to_string(stride));
    const int places = file.add_view(std::vector<std::uint8_t>{7}),
              changed = file.add_view(std::vector<T>(3, T{0}));
    const std::string sparse = fmt::format(
        R"(,"normalized":true,"sparse":{{"count":1,"indices":{{"bufferView":{},"componentType":5121}},"values":{{"bufferView":{}}}}})",
        places, changed);
    for (const int view : {plain, packed}) {
      file.add_accessor(view, component, 8, "VEC3", ",\"normalized\":true");
      file.add_accessor(view, component, 8, "VEC3", sparse);
    }
    file.add_indices(gltf_cube_indices);
    const auto read = [&](int accessor) {
      return read_gltf_file(file.glb(fmt::format(
          R"(,"meshes":[{{"primitives":[{{"attributes":{{"POSITION":{}}},"indices":4}}]}}])", accessor)));
    };
    CHECK(box_of(read(0))[1] == 1);
    CHECK(box_of(read(0))[0] == (std::is_signed_v<T> ? -1 : 0));
    CHECK(same_mesh(read(0), read(2)));
    CHECK(point(read(1), 7) == Point{0, 0, 0});
    CHECK(same_mesh(read(1), read(3)));
  };
  check(std::int8_t{}, 5120);
  check(std::uint8_t{}, 5121);
  check(std::int16_t{}, 5122);
  check(std::uint16_t{}, 5123);
}

TEST_CASE("glTF: meshopt streams decode to the values that were encoded") {
  const BentGrid grid(9);
  const PolygonMesh expected = plain_grid(grid);
  CHECK(triangle_set(read_gltf_file(meshopt_file(grid))) == triangle_set(expected));
  const PolygonMesh sequence = read_gltf_file(meshopt_file(grid, true));
  CHECK(same_mesh(sequence, expected));
  CHECK(same_mesh(read_gltf_file(meshopt_file(grid, true, true)), expected));
  check_cuts_and_flips(meshopt_file(BentGrid(4)));
}

TEST_CASE("glTF: truncated and damaged files get a status") {
  check_cuts_and_flips(cube_file().glb(plain_cube));
  const std::string text = cube_file().with_data_uri(plain_cube);
  for (std::size_t bytes = 0; bytes < text.size(); ++bytes)
    REQUIRE(failure(text.substr(0, bytes), MeshFormat::gltf));
  // A file with bytes behind its end is whole.
  const PolygonMesh mesh = read_gltf_file(cube_file().glb(plain_cube) + "xyz");
  CHECK(mesh.repairs[Repair::extra_data] == 3);
}

TEST_CASE("glTF: hostile and unusual files get a status and a reason") {
  for (const std::vector<Case>& cases : {odd_documents(), odd_buffers()})
    for (const auto& [content, expected] : cases) {
      INFO(content.substr(0, 400));
      CHECK_THAT(gltf_outcome(content), ContainsSubstring(expected));
      check_answer(content);
    }
}

TEST_CASE("glTF: declared sizes are checked before memory is allocated") {
  // A hundred copies of one mesh of a million zeros, in 5 kB.
  std::string nodes = R"({"mesh":0})";
  for (int i = 1; i < 100; ++i) nodes += R"(,{"mesh":0})";
  GltfFile file;
  file.add_accessor(-1, 5126, 1000000, "VEC3");
  const std::string content = file.glb(
      R"(,"meshes":[{"primitives":[{"attributes":{"POSITION":0},"mode":5}]}],"nodes":[)" + nodes + "]");
  MeshEstimate stated;
  const MeshSurroundings around{{}, [&](const MeshEstimate& needs) {
                                  stated = needs;
                                  throw ItemError(Status::too_large, "enough");
                                }};
  CHECK_THROWS_WITH(read_gltf_file(content, around), "enough");
  CHECK(stated.vertices == 100000000);
  CHECK(stated.triangles == 99999800);
  const MeshEstimate peeked = peek_mesh(MemorySource(content), MeshFormat::gltf);
  CHECK(peeked.vertices == stated.vertices);
  CHECK(peeked.triangles == stated.triangles);
  const BentGrid grid(9);
  const std::string packed = draco_file(draco_stream(grid, draco::MESH_EDGEBREAKER_ENCODING), 81, 384);
  for (const std::string& whole : {cube_file().glb(plain_cube), meshopt_file(grid), packed}) {
    const PolygonMesh mesh = read_gltf_file(whole);
    const MeshEstimate estimate = peek_mesh(MemorySource(whole), MeshFormat::gltf);
    CHECK(estimate.file_bytes == whole.size());
    CHECK(estimate.vertices == mesh.vertex_count());
    CHECK(estimate.triangles == mesh.polygon_count());
    CHECK(estimate.companions.empty());
  }
}

TEST_CASE("glTF: the models of a distribution package are read") {
  const fs::path folder = "/usr/share/assimp/models";
  if (!fs::exists(folder / "glTF2")) {
    WARN("skipped: the package assimp-testmodels is not installed");
    return;
  }
  std::map<std::string, Status> expected = {{"glTF2/MissingBin/BoxTextured.gltf", Status::unreadable},
                                            {"glTF2/RecursiveNodes/RecursiveNodes.gltf", Status::unreadable},
                                            {"glTF2/SchemaFailures/sceneWrongType.gltf", Status::unreadable},
                                            {"glTF2/TestNoRootNode/NoScene.gltf", Status::unreadable},
                                            {"glTF2/TestNoRootNode/SceneWithoutNodes.gltf", Status::empty},
                                            {"glTF2/wrongTypes/badArray.gltf", Status::unreadable}};
  for (const char* const lines : {"00", "01", "02", "03", "07", "08", "09", "10"})  // and points
    expected[fmt::format("glTF2/glTF-Asset-Generator/Mesh_PrimitiveMode/Mesh_PrimitiveMode_{}.gltf", lines)] =
        Status::empty;
  std::map<std::string, Status> found;
  std::map<std::string, PolygonMesh> meshes;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    MeshFormat format{};
    if (!mesh_format_of(entry.path(), format) || format != MeshFormat::gltf) continue;
    const std::string name = entry.path().lexically_relative(folder).generic_string();
    if (name.starts_with("glTF/")) expected[name] = Status::unsupported_format;  // glTF 1.0
    try {
      const ModelBytes model({entry.path(), {}, format});
      PolygonMesh mesh = model.mesh();
      check_consistent(mesh);
      const MeshEstimate estimate = peek_model({entry.path(), {}, format});
      CHECK(estimate.file_bytes == model.file_bytes());
      CHECK(estimate.vertices == mesh.vertex_count());
      meshes.emplace(name, std::move(mesh));
    } catch (const ItemError& error) {
      UNSCOPED_INFO(name << " " << name_of(error.status()) << ": " << error.what());
      found.emplace(name, error.status());
    }
  }
  CHECK((found == expected));
  CHECK(meshes.size() >= 20);
  // The same engine as it is and as Draco has it: quantized, and without the triangles that fell together.
  const PolygonMesh& plain = meshes.at("glTF2/2CylinderEngine-glTF-Binary/2CylinderEngine.glb");
  const PolygonMesh& packed = meshes.at("glTF2/draco/2CylinderEngine.gltf");
  CHECK(packed.polygon_count() <= plain.polygon_count());
  CHECK(area_of(packed) == Approx(area_of(plain)).epsilon(0.01));
  const Box box = box_of(plain), packed_box = box_of(packed);
  for (std::size_t k = 0; k < 6; ++k) CHECK(packed_box[k] == Approx(box[k]).margin(0.2));
}

TEST_CASE("glTF: randomly damaged streams give a mesh or a status", "[slow]") {
  const BentGrid grid(9);
  const std::string files[] = {draco_file(draco_stream(grid, draco::MESH_SEQUENTIAL_ENCODING), 81, 384),
                               draco_file(draco_stream(grid, draco::MESH_EDGEBREAKER_ENCODING), 81, 384),
                               meshopt_file(grid), meshopt_file(grid, true, true)};
  for (std::uint32_t round = 0; round < 100000; ++round) {
    std::string damaged = files[round % 4];
    const std::size_t data = damaged.find("BIN") + 4;
    for (std::uint32_t k = 0; k <= round / 4 % 4; ++k) {
      const auto random = philox4x32({round, k, 0, 0}, {7, 8});
      damaged[data + random[0] % (damaged.size() - data)] = static_cast<char>(random[1]);
    }
    check_answer(damaged);
  }
}
