// What of a glTF file is drawn at rest: instances, morph targets, nodes that are named more than once.
#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <filesystem>

#include "gltf_reading.h"
#include "io/file/file_bytes.h"
#include "support/catch.h"

using namespace meander;
using namespace meander::test;
using Catch::Matchers::ContainsSubstring;

namespace {

const std::string in_one_scene = R"(,"scenes":[{"nodes":[0]}])";

// The cube, and behind its two accessors those of what places it.
GltfFile instanced_file() {
  GltfFile file = cube_file();
  file.add_points({0, 0, 0, 10, 0, 0, 0, 20, 0});                               // 2
  file.add_points({1, 1, 1, 2, 2, 2, 1, 1, -3});                                // 3
  const auto turn = static_cast<float>(std::sqrt(0.5));                         // a quarter turn about z
  const std::vector<float> turns = {0, 0, 0, 1, 0, 0, turn, turn, 0, 0, 0, 1};  // 4
  file.add_accessor(file.add_view(turns), 5126, 3, "VEC4");
  const std::vector<std::int8_t> bytes = {0, 0, 0, 127, 0, 0, 90, 90, 0, 0, 0, 127};
  file.add_accessor(file.add_view(bytes), 5120, 3, "VEC4", ",\"normalized\":true");  // 5
  const std::vector<std::int16_t> words = {0, 0, 0, 32767, 0, 0, 23170, 23170, 0, 0, 0, 32767};
  file.add_accessor(file.add_view(words), 5122, 3, "VEC4", ",\"normalized\":true");  // 6
  file.add_points({0, 0, 0, 1, 0, 0});                                               // 7: two of them
  return file;
}

std::string instanced(const std::string& attributes, const std::string& node = {},
                      const std::string& rest = {}) {
  return instanced_file().glb("," + cube_mesh + R"(,"nodes":[{"mesh":0)" + node +
                              R"(,"extensions":{"EXT_mesh_gpu_instancing":{"attributes":{)" + attributes +
                              "}}}}]" + in_one_scene + rest);
}

// Levels of two nodes that have both nodes of the next level as children; the cube below the last.
std::string doubled(int levels) {
  std::string nodes = R"({"children":[1,2]})";
  for (int level = 0; level < levels; ++level) {
    const int next = 3 + 2 * level;
    const std::string children =
        level + 1 == levels ? fmt::format("[{}]", next) : fmt::format("[{},{}]", next, next + 1);
    for (int k = 0; k < 2; ++k) nodes += R"(,{"children":)" + children + "}";
  }
  return cube_with_nodes("\"nodes\":[" + nodes + R"(,{"mesh":0}])" + in_one_scene);
}

double seconds_of(const std::function<void()>& work) {
  const auto begin = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

}  // namespace

TEST_CASE("glTF: instances are applied whether or not the extension is listed or required") {
  for (const char* listed : {"", R"(,"extensionsUsed":["EXT_mesh_gpu_instancing"])",
                             R"(,"extensionsRequired":["EXT_mesh_gpu_instancing"])"}) {
    const PolygonMesh mesh = read_gltf_file(instanced(R"("TRANSLATION":2,"SCALE":3)", "", listed));
    check_consistent(mesh);
    REQUIRE(mesh.polygon_count() == 36);
    CHECK(area_of(mesh) == Approx(6 + 24 + 2 + 4 * 3));
    CHECK(box_of(mesh) == Box{0, 12, 0, 21, -3, 2});
    CHECK(signed_volume(mesh) == Approx(1 + 8 + 3));  // the third is mirrored, its outside stays outside
    CHECK(mesh.face_attributes[0].values[0] == 0);
    CHECK(mesh.face_attributes[0].values[35] == 2);
    CHECK_FALSE(mesh.notes.any());
  }
}

TEST_CASE(
    "glTF: translation, rotation and scale of instances are optional, and rotations may be normalized "
    "integers") {
  CHECK(box_of(read_gltf_file(instanced(R"("TRANSLATION":2)"))) == Box{0, 11, 0, 21, 0, 1});
  CHECK(box_of(read_gltf_file(instanced(R"("SCALE":3)"))) == Box{0, 2, 0, 2, -3, 2});
  for (const int turns : {4, 5, 6}) {
    INFO(turns);
    const Box box = box_of(
        read_gltf_file(instanced(fmt::format(R"("TRANSLATION":2,"ROTATION":{},"SCALE":3,"_ID":7)", turns))));
    const Box expected = {0, 10, 0, 21, -3, 2};  // of the second, two wide, x turns to y and y to -x
    for (std::size_t k = 0; k < 6; ++k) CHECK(box[k] == Approx(expected[k]).margin(1e-6));
    CHECK(signed_volume(read_gltf_file(instanced(fmt::format(R"("ROTATION":{})", turns)))) == Approx(3));
  }
  // None of the three: copies in one place are one.
  CHECK(read_gltf_file(instanced(R"("_ID":7)")).polygon_count() == 12);
  CHECK(read_gltf_file(instanced("")).polygon_count() == 12);
}

TEST_CASE("glTF: instances are relative to their node, which may mirror, and its parents") {
  const PolygonMesh mesh = read_gltf_file(instanced(R"("TRANSLATION":2,"SCALE":3)", R"(,"scale":[-1,1,1])"));
  CHECK(box_of(mesh) == Box{-12, 0, 0, 21, -3, 2});
  CHECK(signed_volume(mesh) == Approx(12));
  // A node without a mesh has no instances to draw.
  const PolygonMesh below = read_gltf_file(instanced_file().glb(
      "," + cube_mesh +
      R"(,"nodes":[{"children":[1],"scale":[2,2,2],"extensions":{"EXT_mesh_gpu_instancing":{"attributes":{"TRANSLATION":2}}}},)"
      R"({"mesh":0,"translation":[1,0,0],"extensions":{"EXT_mesh_gpu_instancing":{"attributes":{"TRANSLATION":7}}}}])" +
      in_one_scene));
  CHECK(below.polygon_count() == 24);
  CHECK(box_of(below) == Box{2, 6, 0, 2, 0, 2});
}

TEST_CASE("glTF: instance accessors that differ in count or kind make a file unreadable") {
  CHECK_THAT(gltf_outcome(instanced(R"("TRANSLATION":2,"SCALE":7)")),
             ContainsSubstring("unreadable: nodes[0]: its instances are 3 by one accessor and 2 by another"));
  CHECK_THAT(gltf_outcome(instanced(R"("ROTATION":3)")),
             ContainsSubstring("unreadable: accessors[3]: of instances 4 numbers each are needed"));
  CHECK_THAT(gltf_outcome(instanced(R"("TRANSLATION":70)")),
             ContainsSubstring("unreadable: the accessor 70 of instances"));
  CHECK_THAT(gltf_outcome(instanced(R"("TRANSLATION":"x")")),
             ContainsSubstring("`TRANSLATION` is not the number"));
  // No instances, nothing drawn.
  GltfFile file = cube_file();
  file.add_accessor(-1, 5126, 0, "VEC3");
  CHECK_THAT(
      gltf_outcome(file.glb(
          "," + cube_mesh +
          R"(,"nodes":[{"mesh":0,"extensions":{"EXT_mesh_gpu_instancing":{"attributes":{"TRANSLATION":2}}}}])")),
      ContainsSubstring("empty: the scene holds no triangles"));
}

TEST_CASE("glTF: copies and instances are counted before memory or time is spent on them") {
  const auto stated_of = [](const std::string& content) {
    MeshEstimate stated;
    const MeshSurroundings around{{}, [&](const MeshEstimate& needs) {
                                    stated = needs;
                                    throw ItemError(Status::too_large, "enough");
                                  }};
    CHECK_THROWS_WITH(read_gltf_file(content, around), "enough");
    const MeshEstimate peeked = peek_mesh(MemorySource(content), MeshFormat::gltf);
    CHECK(peeked.vertices == stated.vertices);
    CHECK(peeked.triangles == stated.triangles);
    return stated;
  };
  const auto zeros = [](std::uint64_t count, const std::string& more = {}) {
    GltfFile file = cube_file();
    file.add_accessor(-1, 5126, count, "VEC3");
    return file.glb("," + cube_mesh +
                    R"(,"nodes":[{"mesh":0,"extensions":{"EXT_mesh_gpu_instancing":{"attributes":)" +
                    R"({"TRANSLATION":2}}}}])" + more);
  };
  CHECK(seconds_of([&] {
          CHECK(stated_of(zeros(10000000)).triangles == 120000000);
          CHECK(stated_of(zeros(10000000)).decoding_bytes >= 10000000 * 80ull);
          CHECK(stated_of(doubled(20)).triangles == 12u << 20);
          CHECK_THAT(gltf_outcome(zeros(1000000000)),
                     ContainsSubstring("unsupported_format: more than 16777216 parts"));
          CHECK_THAT(gltf_outcome(doubled(30)),
                     ContainsSubstring("unsupported_format: more than 16777216 copies"));
          CHECK(peek_mesh(MemorySource(zeros(1000000000)), MeshFormat::gltf).triangles == 0);
          CHECK(peek_mesh(MemorySource(doubled(30)), MeshFormat::gltf).triangles == 0);
        }) < 5);
  // Where there is nothing to draw, a billion copies of it are nothing.
  std::string nothing = doubled(30);
  nothing.replace(nothing.find(R"({"mesh":0})"), 10, R"({"mess":0})");
  CHECK(seconds_of([&] {
          CHECK_THAT(gltf_outcome(nothing), ContainsSubstring("empty: the scene holds no triangles"));
        }) < 5);
  // Doubled in one list, they are in one place, and drawn once.
  std::string nodes;
  for (int level = 1; level <= 30; ++level) nodes += fmt::format(R"({{"children":[{0},{0}]}},)", level);
  const PolygonMesh once =
      read_gltf_file(cube_with_nodes("\"nodes\":[" + nodes + R"({"mesh":0}])" + in_one_scene));
  CHECK(once.polygon_count() == 12);
  CHECK(once.notes[Note::node_repeated] == 30);
}

TEST_CASE("glTF: a node with two parents is drawn below each, and noted") {
  const PolygonMesh mesh = read_gltf_file(
      cube_with_nodes(R"("nodes":[{"children":[2]},{"children":[2],"translation":[5,0,0],"scale":[-1,2,1]},)"
                      R"({"mesh":0,"children":[3]},{"mesh":0,"translation":[0,0,3]}])"));
  CHECK(mesh.polygon_count() == 48);
  CHECK(box_of(mesh) == Box{0, 5, 0, 2, 0, 4});
  CHECK(signed_volume(mesh) == Approx(2 + 4));
  CHECK(mesh.notes[Note::node_repeated] == 1);
  CHECK(mesh.notes.examples[static_cast<std::size_t>(Note::node_repeated)] ==
        "node 2 is named more than once");
  CHECK(mesh.face_attributes[0].values[47] == 3);
  for (std::size_t p = 0; p < 48; ++p)
    CHECK(mesh.face_attributes[0].values[p] == static_cast<double>(p / 12));
  CHECK_FALSE(read_gltf_file(cube_with_nodes(R"("nodes":[{"children":[1]},{"mesh":0}])")).notes.any());
}

TEST_CASE("glTF: a node listed twice by the scene or a parent is drawn once, and noted") {
  for (const char* nodes : {R"("scenes":[{"nodes":[1,1]}],"nodes":[{},{"mesh":0}])",
                            R"("scenes":[{"nodes":[0]}],"nodes":[{"children":[1,1]},{"mesh":0}])",
                            // Programs list all nodes, not the roots alone.
                            R"("scenes":[{"nodes":[0,1]}],"nodes":[{"children":[1]},{"mesh":0}])",
                            R"("scenes":[{"nodes":[1,0]}],"nodes":[{"children":[1]},{"mesh":0}])"}) {
    INFO(nodes);
    const PolygonMesh mesh = read_gltf_file(cube_with_nodes(nodes));
    CHECK(mesh.polygon_count() == 12);
    CHECK(mesh.notes[Note::node_repeated] == 1);
  }
  CHECK(box_of(read_gltf_file(cube_with_nodes(
            R"("scenes":[{"nodes":[1,0]}],"nodes":[{"children":[1],"translation":[7,0,0]},{"mesh":0}])"))) ==
        Box{7, 8, 0, 1, 0, 1});
  // A scene may show what another node has as a child, too.
  CHECK_FALSE(
      read_gltf_file(cube_with_nodes(R"("scenes":[{"nodes":[1]}],"nodes":[{"children":[1]},{"mesh":0}])"))
          .notes.any());
}

TEST_CASE("glTF: hidden nodes and their descendants are not drawn") {
  const auto faces = [](const std::string& visible) {
    return read_gltf_file(
               cube_with_nodes(
                   R"("nodes":[{"mesh":0},{"mesh":0,"children":[2],"extensions":{"KHR_node_visibility":)" +
                   visible + R"(}},{"mesh":0,"extensions":{"KHR_node_visibility":{"visible":true}}}])"))
        .polygon_count();
  };
  CHECK(faces(R"({"visible":false})") == 12);
  CHECK(faces(R"({"visible":true})") == 36);
  CHECK(faces("{}") == 36);
}

TEST_CASE("glTF: morph targets at rest use the weights of the node, or else of the mesh") {
  GltfFile file = cube_file();
  std::vector<float> up, right;
  for (std::size_t v = 0; v < 8; ++v) {
    up.insert(up.end(), {0, 0, 1});
    right.insert(right.end(), {2 * gltf_cube_points[3 * v], 0, 0});
  }
  file.add_points(up);     // 2
  file.add_points(right);  // 3
  const std::string plain_members = R"({"attributes":{"POSITION":0},"indices":1)";
  const auto box = [&](const std::string& mesh_weights, const std::string& node_weights,
                       const std::string& targets = R"([{"POSITION":2},{"NORMAL":2},{"POSITION":3}])") {
    return box_of(
        read_gltf_file(file.glb(R"(,"meshes":[{"primitives":[)" + plain_members + R"(,"targets":)" + targets +
                                "}]" + mesh_weights + R"(}],"nodes":[{"mesh":0)" + node_weights + "}]")));
  };
  const std::string w = ",\"weights\":";
  CHECK(box("", "") == Box{0, 1, 0, 1, 0, 1});
  CHECK(box(w + "[1,5,0]", "") == Box{0, 1, 0, 1, 1, 2});
  CHECK(box(w + "[1,0,0.5]", "") == Box{0, 2, 0, 1, 1, 2});
  CHECK(box(w + "[1,0,0.5]", w + "[0,0,1]") == Box{0, 3, 0, 1, 0, 1});
  CHECK(box(w + "[1,0,0.5]", w + "[0,0,0]") == Box{0, 1, 0, 1, 0, 1});
  CHECK(box(w + "[-2]", "") == Box{0, 1, 0, 1, -2, -1});
  CHECK(box(w + "[1,1,1,9,9]", w + "[]") == Box{0, 3, 0, 1, 1, 2});
  // What is at 0 is not looked at.
  CHECK(box(w + "[0,1]", "", R"([{"POSITION":77},{"POSITION":2}])") == Box{0, 1, 0, 1, 1, 2});
  CHECK_THAT(gltf_outcome(file.glb(R"(,"meshes":[{"weights":[1],"primitives":[)" + plain_members +
                                   R"(,"targets":[{"POSITION":77}]}]}])")),
             ContainsSubstring("unreadable: accessors[77]: a morph target of other than 8 vertices"));
  // One mesh at two nodes, once as it is.
  CHECK(
      box_of(read_gltf_file(file.glb(
          R"(,"meshes":[{"weights":[1],"primitives":[)" + plain_members +
          R"(,"targets":[{"POSITION":2}]}]}],"nodes":[{"mesh":0},{"mesh":0,"weights":[0],"translation":[4,0,0]}])"))) ==
      Box{0, 5, 0, 1, 0, 2});
  // Primitives that share their positions, but not their targets.
  const PolygonMesh shared = read_gltf_file(file.glb(
      R"(,"meshes":[{"weights":[1],"primitives":[)" + plain_members + R"(,"targets":[{"POSITION":2}]},)" +
      plain_members + R"(,"targets":[{"POSITION":3}]},)" + plain_members + "}]}]"));
  CHECK(shared.vertex_count() == 24);
  CHECK(box_of(shared) == Box{0, 3, 0, 1, 0, 2});
  CHECK(read_gltf_file(file.glb(R"(,"meshes":[{"weights":[0],"primitives":[)" + plain_members +
                                R"(,"targets":[{"POSITION":2}]},)" + plain_members + "}]}]"))
            .vertex_count() == 8);
}

TEST_CASE("glTF: morph targets may be sparse, without a base, and normalized integers") {
  GltfFile file = cube_file();
  const int places = file.add_view(std::vector<std::uint8_t>{4, 5, 6, 7}),
            values = file.add_view(std::vector<float>{0, 0, 3, 0, 0, 3, 0, 0, 3, 0, 0, 3}),
            bytes = file.add_view(
                std::vector<std::int8_t>({0, 0, 0,   0, 0, 0, 0,   0, 0, 0, 0,   0, 0, 0, 0,   0,
                                          0, 0, 127, 0, 0, 0, 127, 0, 0, 0, 127, 0, 0, 0, 127, 0}),
                ",\"byteStride\":4");
  const std::string sparse = fmt::format(
      R"(,"sparse":{{"count":4,"indices":{{"bufferView":{},"componentType":5121}},"values":{{"bufferView":{}}}}})",
      places, values);
  file.add_accessor(-1, 5126, 8, "VEC3", sparse);
  file.add_accessor(bytes, 5120, 8, "VEC3", ",\"normalized\":true");
  const auto volume = [&](int target) {
    return signed_volume(read_gltf_file(file.glb(fmt::format(
        R"(,"meshes":[{{"weights":[0.5],"primitives":[{{"attributes":{{"POSITION":0}},"indices":1,)"
        R"("targets":[{{"POSITION":{}}}]}}]}}])",
        target))));
  };
  CHECK(volume(2) == Approx(2.5));
  CHECK(volume(3) == Approx(1.5));
}

TEST_CASE("glTF: morph targets are applied before skins and instances") {
  // One joint that turns x to y; the target moves along x.
  GltfFile file;
  file.add_points({0, 0, 0, 1, 0, 0, 0, 1, 0});
  file.add_points({3, 0, 0, 3, 0, 0, 3, 0, 0});
  file.add_accessor(file.add_view(std::vector<std::uint8_t>(12, 0)), 5121, 3, "VEC4");
  file.add_accessor(file.add_view(std::vector<float>{1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}), 5126, 3, "VEC4");
  const std::string mesh =
      R"(,"meshes":[{"weights":[1],"primitives":[{"attributes":{"POSITION":0,"JOINTS_0":2,"WEIGHTS_0":3},"targets":[{"POSITION":1}]}]}])";
  const PolygonMesh skinned = read_gltf_file(file.glb(
      mesh +
      R"(,"skins":[{"joints":[1]}],"nodes":[{"mesh":0,"skin":0,"translation":[9,9,9]},{"matrix":[0,1,0,0, -1,0,0,0, 0,0,1,0, 0,0,0,1]}])"));
  CHECK(point(skinned, 0) == Point{0, 3, 0});
  CHECK(point(skinned, 1) == Point{0, 4, 0});
  const int moves = file.add_points({0, 0, 0, 0, 0, 5}), scales = file.add_points({1, 1, 1, 2, 2, 2});
  const PolygonMesh copies = read_gltf_file(file.glb(
      mesh +
      fmt::format(
          R"(,"nodes":[{{"mesh":0,"extensions":{{"EXT_mesh_gpu_instancing":{{"attributes":{{"TRANSLATION":{},"SCALE":{}}}}}}}}}])",
          moves, scales)));
  CHECK(point(copies, 0) == Point{3, 0, 0});
  CHECK(point(copies, 4) == Point{8, 0, 5});
}

TEST_CASE("glTF: strips and fans restart after the max index of their type") {
  const auto faces = [](const std::string& mode, const auto& indices) {
    GltfFile file;
    file.add_points({0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 0, 2, 0});
    file.add_indices(indices);
    const PolygonMesh mesh = read_gltf_file(file.glb(primitive_of(mode + ",\"indices\":1")));
    check_consistent(mesh);
    CHECK(mesh.face_attributes[0].values.size() == mesh.polygon_count());
    return faces_of(mesh);
  };
  const Faces strips = {{0, 1, 2}, {1, 2, 3}, {2, 4, 3}};
  CHECK(faces(",\"mode\":5", std::vector<std::uint8_t>{0, 1, 2, 255, 1, 2, 3, 4}) == strips);
  CHECK(faces(",\"mode\":5", std::vector<std::uint16_t>{0, 1, 2, 65535, 1, 2, 3, 4}) == strips);
  CHECK(faces(",\"mode\":5", std::vector<std::uint32_t>{0, 1, 2, 0xFFFFFFFF, 1, 2, 3, 4}) == strips);
  CHECK(faces(",\"mode\":6", std::vector<std::uint8_t>{255, 0, 1, 2, 255, 255, 4, 3, 255, 4, 3, 2, 1}) ==
        Faces{{1, 2, 0}, {3, 2, 4}, {2, 1, 4}});
  CHECK(faces(",\"mode\":5", std::vector<std::uint16_t>{0, 1, 2, 255}) == Faces{{0, 1, 2}, {1, no_index, 2}});
}

TEST_CASE("glTF: containers and data URIs as common programs write them are read") {
  const GltfFile file = cube_file();
  const PolygonMesh expected = read_gltf_file(file.glb(plain_cube));
  const auto same = [&](const std::string& content) { return same_mesh(read_gltf_file(content), expected); };
  const auto word = [](std::size_t value) {
    std::string bytes;
    for (int k = 0; k < 4; ++k) bytes += static_cast<char>(value >> (8 * k) & 0xFF);
    return bytes;
  };
  const auto chunk = [&](const std::string& kind, const std::string& data) {
    return word(data.size()) + kind + data;
  };
  const auto glb = [&](const std::string& chunks) {
    return "glTF" + word(2) + word(12 + chunks.size()) + chunks;
  };
  const std::string text = file.json(plain_cube), data = chunk(std::string("BIN\0", 4), file.binary);
  const std::string other = chunk("PADD", std::string(16, '\0'));
  CHECK(same(glb(chunk("JSON", text + std::string(8, '\0')) + data)));
  CHECK(same(glb(chunk("JSON", "\xEF\xBB\xBF \n" + text + "\r\n") + data)));
  CHECK(same(glb(chunk("JSON", text) + other + data + other)));
  CHECK(peek_mesh(MemorySource(glb(chunk("JSON", text + std::string(8, '\0')) + data)), MeshFormat::gltf)
            .triangles == 12);
  const std::string encoded = base64(file.binary);
  std::string broken;
  for (std::size_t at = 0; at < encoded.size(); at += 76) broken += encoded.substr(at, 76) + "\\r\\n";
  for (const std::string& uri :
       {"data:application/gltf-buffer;base64," + encoded, "data:;charset=utf-8;base64," + encoded,
        "DATA:Application/Octet-Stream;BASE64," + encoded, "data:;base64," + broken,
        "data:;base64," + encoded + "==\\r\\n"}) {
    INFO(uri.substr(0, 40));
    CHECK(same(file.json(plain_cube, uri)));
  }
}

TEST_CASE("glTF: the shared cases are drawn at rest as expected") {
  const std::filesystem::path cases = std::filesystem::path(MEANDER_SHARED_DATA) / "../cases";
  if (!std::filesystem::exists(cases)) {
    WARN("skipped: there is no " << cases);
    return;
  }
  const auto read = [&](const char* name) {
    const FileBytes file(cases / name);
    return read_mesh(file.bytes(), MeshFormat::gltf);
  };
  CHECK(area_of(read("gltf_instancing/used.glb")) == Approx(6));
  CHECK(box_of(read("gltf_morph/mesh_weights.glb"))[4] == 1);
  CHECK(box_of(read("gltf_morph/mesh_weights.glb"))[5] == 1);
  CHECK(box_of(read("gltf_morph/no_weights.glb"))[5] == 0);
  for (const char* name : {"draco_normalized/cube_s16.glb", "draco_normalized/cube_s16_draco.glb"}) {
    CHECK(area_of(read(name)) == Approx(96));
    CHECK(box_of(read(name)) == Box{-2, 2, -2, 2, -2, 2});
  }
}
