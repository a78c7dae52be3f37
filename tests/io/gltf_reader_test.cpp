// Scenes, accessors, buffers and skins. Compressed and damaged files: gltf_streams_test.cpp.
#include <fmt/format.h>

#include <cmath>
#include <filesystem>

#include "gltf_reading.h"
#include "io/archive/model_bytes.h"
#include "support/catch.h"
#include "support/mesh_files.h"

using namespace meander;
using namespace meander::test;
using Catch::Matchers::ContainsSubstring;

namespace fs = std::filesystem;

TEST_CASE("glTF: nodes place their meshes hierarchically, in scene order") {
  // A quarter turn about z, then along x, of a cube that is twice as long: x to [-1, 0] + 10.
  const std::string turned = fmt::format(
      R"({{"mesh":0,"rotation":[0,0,{0},{0}],"translation":[10,0,0],"scale":[2,1,1],"children":[2]}})",
      std::sqrt(0.5));
  const PolygonMesh mesh = read_gltf_file(cube_with_nodes(
      R"("scene":1,"scenes":[{"nodes":[0]},{"nodes":[3,1]}],"nodes":[{"mesh":0},)" + turned +
      R"(,{"mesh":0,"matrix":[1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,5,1]},{"mesh":0,"translation":[0,-3,0]}])"));
  check_consistent(mesh);
  REQUIRE(mesh.vertex_count() == 24);
  REQUIRE(mesh.polygon_count() == 36);
  CHECK(point(mesh, 7) == Point{1, -2, 1});
  const std::vector<std::vector<double>> expected = {{9, 2, 1}, {9, 2, 6}};
  for (std::size_t copy = 0; copy < 2; ++copy)
    for (std::size_t k = 0; k < 3; ++k)
      CHECK(point(mesh, 15 + 8 * copy)[k] == Approx(expected[copy][k]).margin(1e-14));
  CHECK(signed_volume(mesh) == Approx(5));
  REQUIRE(mesh.face_attributes.size() == 1);
  CHECK(mesh.face_attributes[0].name == "part");
  for (std::size_t p = 0; p < 36; ++p)
    CHECK(mesh.face_attributes[0].values[p] == static_cast<double>(p / 12));
  // Without a scene all roots by their numbers, without nodes all meshes, without `scene` the first.
  CHECK(
      box_of(read_gltf_file(cube_with_nodes(
          R"("nodes":[{"translation":[1,0,0],"children":[2]},{"mesh":0,"translation":[0,9,0]},{"mesh":0}])"))) ==
      Box{0, 2, 0, 10, 0, 1});
  CHECK(read_gltf_file(cube_file().glb("," + cube_mesh)).polygon_count() == 12);
  CHECK(box_of(read_gltf_file(cube_with_nodes(
            R"("scenes":[{"nodes":[1]},{"nodes":[0]}],"nodes":[{"mesh":0},{"mesh":0,"scale":[3,1,1]}])"))) ==
        Box{0, 3, 0, 1, 0, 1});
}

TEST_CASE("glTF: mirroring transforms keep outside and inside") {
  for (const char* scale : {"[-1,1,1]", "[1,-2,1]", "[-1,-1,-1]", "[-1,-1,1]", "[1,1,1]"}) {
    INFO(scale);
    CHECK(signed_volume(read_gltf_file(
              cube_with_nodes(R"("nodes":[{"mesh":0,"scale":)" + std::string(scale) + "}]"))) > 0.9);
  }
  CHECK(signed_volume(read_gltf_file(cube_with_nodes(
            R"("nodes":[{"scale":[-1,1,1],"children":[1]},{"mesh":0,"scale":[1,1,-1]}])"))) == Approx(1));
}

TEST_CASE("glTF: triangles, strips and fans, with indices of every width and without") {
  const auto faces = [](const std::string& members, const std::vector<std::uint32_t>& indices) {
    GltfFile file;
    file.add_points({0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 0, 2, 0});
    if (!indices.empty()) file.add_indices(indices);
    return faces_of(read_gltf_file(file.glb(primitive_of(members))));
  };
  CHECK(faces(",\"mode\":5", {}) == Faces{{0, 1, 2}, {1, 3, 2}, {2, 3, 4}});
  CHECK(faces(",\"mode\":6", {}) == Faces{{1, 2, 0}, {2, 3, 0}, {3, 4, 0}});
  CHECK(faces("", {}) == Faces{{0, 1, 2}});  // two vertices are left over
  CHECK(faces(",\"mode\":5,\"indices\":1", {4, 3, 2, 1}) == Faces{{4, 3, 2}, {3, 1, 2}});
  CHECK(faces(",\"mode\":6,\"indices\":1", {4, 3, 2, 1}) == Faces{{3, 2, 4}, {2, 1, 4}});
  CHECK(faces(",\"indices\":1", {4, 3, 7, 0, 1, 2}) == Faces{{4, 3, no_index}, {0, 1, 2}});
  GltfFile file;
  file.add_points(gltf_cube_points);
  file.add_indices(std::vector<std::uint8_t>(gltf_cube_indices.begin(), gltf_cube_indices.end()));
  file.add_indices(gltf_cube_indices);
  file.add_indices(std::vector<std::uint32_t>(gltf_cube_indices.begin(), gltf_cube_indices.end()));
  for (int accessor = 1; accessor <= 3; ++accessor) {
    const PolygonMesh mesh = read_gltf_file(file.glb(primitive_of(fmt::format(",\"indices\":{}", accessor))));
    CHECK(std::vector<std::uint16_t>(mesh.corners.begin(), mesh.corners.end()) == gltf_cube_indices);
  }
}

TEST_CASE("glTF: points and lines are skipped and counted, primitives of a mesh share their vertices") {
  const std::string primitives =
      R"(,"meshes":[{"primitives":[{"attributes":{"POSITION":0},"mode":0},{"attributes":{"POSITION":0},"indices":1},
      {"attributes":{"POSITION":0},"mode":1},{"attributes":{},"indices":1},
      {"attributes":{"POSITION":0},"indices":1}]}],"nodes":[{"mesh":0}])";
  const PolygonMesh mesh = read_gltf_file(cube_file().glb(primitives));
  CHECK(mesh.vertex_count() == 8);
  CHECK(mesh.polygon_count() == 24);
  CHECK(mesh.repairs[Repair::short_faces] == 12);
  CHECK(mesh.face_attributes[0].values.front() == 1);
  CHECK(mesh.face_attributes[0].values.back() == 4);
  CHECK_THAT(gltf_outcome(cube_file().glb(primitive_of(",\"mode\":0"))),
             ContainsSubstring("empty: the scene holds no triangles, but 8 points and lines"));
  CHECK_THAT(gltf_outcome(cube_file().glb(R"(,"scenes":[{}],"nodes":[{"mesh":0}],)" + cube_mesh)),
             ContainsSubstring("empty: the scene holds no triangles"));
}

TEST_CASE("glTF: sparse, interleaved and quantized accessors are read") {
  SECTION("sparse, over values and over zeros") {
    GltfFile file;
    const int points = file.add_view(gltf_cube_points),
              places = file.add_view(std::vector<std::uint8_t>{1, 7}),
              values = file.add_view(std::vector<float>{5, 0, 0, 6, 6, 6});
    const std::string sparse = fmt::format(
        R"(,"sparse":{{"count":2,"indices":{{"bufferView":{},"componentType":5121}},"values":{{"bufferView":{}}}}})",
        places, values);
    const std::string zeros_first =
        fmt::format(",\"meshes\":[{{\"primitives\":[{{\"attributes\":{{\"POSITION\":{}}}}}]}}]", 0);
    file.add_accessor(points, 5126, 8, "VEC3", sparse);
    file.add_accessor(-1, 5126, 8, "VEC3", sparse);
    const PolygonMesh mesh = read_gltf_file(file.glb(zeros_first));
    CHECK(point(mesh, 1) == Point{5, 0, 0});
    CHECK(point(mesh, 2) == Point{0, 1, 0});
    CHECK(point(mesh, 7) == Point{6, 6, 6});
    const PolygonMesh zeros =
        read_gltf_file(file.glb(R"(,"meshes":[{"primitives":[{"attributes":{"POSITION":1}}]}])"));
    CHECK(point(zeros, 1) == Point{5, 0, 0});
    CHECK(point(zeros, 2) == Point{0, 0, 0});
    file.accessors.replace(file.accessors.find("\"count\":8"), 9, "\"count\":7");
    CHECK_THAT(gltf_outcome(file.glb(zeros_first)),
               ContainsSubstring("the sparse element 7 is none of its 7"));
  }
  SECTION("interleaved with normals") {
    std::vector<float> values;
    for (std::size_t v = 0; v < 8; ++v)
      for (std::size_t k = 0; k < 6; ++k) values.push_back(k < 3 ? 77 : gltf_cube_points[3 * v + k - 3]);
    GltfFile file;
    file.add_accessor(file.add_view(values, ",\"byteStride\":24"), 5126, 8, "VEC3", ",\"byteOffset\":12");
    file.add_indices(gltf_cube_indices);
    const PolygonMesh mesh = read_gltf_file(file.glb(plain_cube));
    CHECK(signed_volume(mesh) == Approx(1));
    CHECK(box_of(mesh) == Box{0, 1, 0, 1, 0, 1});
  }
  SECTION("8 and 16 bits, with and without a sign, as fractions and as they are") {
    const auto box = [](const auto& values, int component, bool normalized) {
      GltfFile file;
      file.add_accessor(file.add_view(values), component, 3, "VEC3",
                        normalized ? ",\"normalized\":true" : "");
      return box_of(
          read_gltf_file(file.glb(primitive_of("") + R"(,"extensionsRequired":["KHR_mesh_quantization"])")));
    };
    CHECK(box(std::vector<std::int8_t>{-128, 0, 0, 127, 0, 0, 0, 64, 0}, 5120, true) ==
          Box{-1, 1, 0, 64 / 127.0, 0, 0});
    CHECK(box(std::vector<std::uint8_t>{0, 0, 0, 255, 0, 0, 0, 51, 0}, 5121, true) ==
          Box{0, 1, 0, 0.2, 0, 0});
    CHECK(box(std::vector<std::int16_t>{-32768, 0, 0, 7, 0, 0, 0, 9, 0}, 5122, false) ==
          Box{-32768, 7, 0, 9, 0, 0});
    CHECK(box(std::vector<std::uint16_t>{0, 0, 0, 65535, 0, 0, 0, 13107, 0}, 5123, true) ==
          Box{0, 1, 0, 0.2, 0, 0});
  }
}

TEST_CASE("glTF: buffers are read from the file, from data URIs and from other files") {
  const GltfFile file = cube_file();
  const PolygonMesh expected = read_gltf_file(file.glb(plain_cube));
  CHECK(same_mesh(read_gltf_file(file.with_data_uri(plain_cube)), expected));
  CHECK(same_mesh(read_gltf_file("\xEF\xBB\xBF\n" + file.with_data_uri(plain_cube)), expected));
  std::string percent;
  for (const char c : file.binary) percent += fmt::format("%{:02X}", static_cast<unsigned char>(c));
  CHECK(same_mesh(read_gltf_file(file.json(plain_cube, "data:," + percent)), expected));
  CHECK_THAT(gltf_outcome(file.json(plain_cube, "data:;base64,AA*A")),
             ContainsSubstring("unreadable: a data URI"));
  CHECK_THAT(gltf_outcome(file.json(plain_cube)), ContainsSubstring("neither a file nor a binary chunk"));
  const ScratchFolder scratch;
  fs::create_directories(scratch / "in/b c");
  write_file(scratch / "out.bin", file.binary);
  const auto outcome_beside = [&](const std::string& uri) -> std::string {
    write_file(scratch / "in/m.gltf", file.json(plain_cube, uri));
    try {
      const PolygonMesh mesh = ModelBytes({scratch / "in/m.gltf", {}, MeshFormat::gltf, 0}).mesh();
      return same_mesh(mesh, expected) ? "ok" : "another mesh";
    } catch (const ItemError& error) {
      return std::string(name_of(error.status())) + ": " + error.what();
    }
  };
  for (const char* name : {"b c/d.bin", "a%b.bin", "e%20f.bin", "\xC3\xA4.bin"})
    write_file(scratch / (std::string("in/") + name), file.binary);
  for (const char* uri :
       {"b%20c/d.bin", "b c/./d.bin", "b%20c%2Fd.bin", "a%b.bin", "a%25b.bin", "e%2520f.bin", "%C3%A4.bin",
        "\xC3\xA4.bin", "./b c//d.bin", "b c\\\\d.bin", ".\\\\b c\\\\d.bin", "b c%5Cd.bin",
        "b c/../b c/d.bin", "none/../b c/d.bin", "x\\\\y\\\\..\\\\../b c/d.bin"}) {
    INFO(uri);
    CHECK(outcome_beside(uri) == "ok");
  }
  for (const char* uri : {"../out.bin", "%2e%2e/out.bin", "b c/../../out.bin", "..%2Fout.bin", "/etc/passwd",
                          "%2Fetc/passwd", "..\\\\out.bin", "b c/d.bin%00", "b c/..",
                          "b c\\\\..\\\\..\\\\out.bin", "x/../../in/b c/d.bin", "\\\\\\\\host\\\\a.bin"}) {
    INFO(uri);
    CHECK_THAT(outcome_beside(uri), ContainsSubstring("unreadable: buffers[0]") &&
                                        (ContainsSubstring("leads out of what was given as input") ||
                                         ContainsSubstring("is not a path from the model's folder")));
  }
  for (const char* uri : {"file:///etc/passwd", "http://x.org/a.bin", "C:/a.bin"})
    CHECK_THAT(outcome_beside(uri), ContainsSubstring("is not a file of the model's folder"));
  CHECK_THAT(outcome_beside("missing.bin"), ContainsSubstring("`missing.bin` is not there"));
  CHECK_THAT(outcome_beside("b c"), ContainsSubstring("not a regular file"));
}

TEST_CASE("glTF: the content hash of a model covers the files it references") {
  const ScratchFolder scratch;
  const GltfFile file = cube_file();
  const auto digest = [&](const char* name) {
    return ModelBytes({scratch / name, {}, MeshFormat::gltf}).content_sha256();
  };
  write_file(scratch / "m.gltf", file.json(plain_cube, "m.bin"));
  const auto without = digest("m.gltf");
  write_file(scratch / "m.bin", file.binary);
  const auto first = digest("m.gltf");
  CHECK(first != without);
  std::string other = file.binary;
  other[4] = 'x';
  write_file(scratch / "m.bin", other);
  CHECK(digest("m.gltf") != first);
  write_file(scratch / "m.bin", file.binary);
  CHECK(digest("m.gltf") == first);
  CHECK(peek_model({scratch / "m.gltf", {}, MeshFormat::gltf}).file_bytes ==
        ModelBytes({scratch / "m.gltf", {}, MeshFormat::gltf}).file_bytes());
}

TEST_CASE("glTF: a number of joint sets whose search would be quadratic is refused") {
  std::string attributes = R"("POSITION":0)";
  for (int set = 0; set < 65; ++set)
    attributes += ",\"JOINTS_" + std::to_string(set) + "\":0,\"WEIGHTS_" + std::to_string(set) + "\":0";
  const std::string text = R"({"asset":{"version":"2.0"},"meshes":[{"primitives":[{"attributes":{)" +
                           attributes +
                           R"(}}]}],"nodes":[{"mesh":0}],"scenes":[{"nodes":[0]}],"accessors":[]})";
  CHECK_THROWS_WITH(read_mesh(std::as_bytes(std::span(text)), MeshFormat::gltf),
                    Catch::Matchers::ContainsSubstring("more than 64 sets of joints"));
}

TEST_CASE("glTF: skins are applied in rest pose") {
  // Two bones, the second 2 higher and, at rest, 5 to the right; vertices below, above and in between.
  GltfFile file;
  file.add_points({0, 0, 0, 1, 2, 0, 0, 1, 0});
  file.add_accessor(file.add_view(std::vector<std::uint8_t>{0, 0, 0, 0, 1, 9, 0, 0, 0, 1, 0, 0}), 5121, 3,
                    "VEC4");
  file.add_accessor(file.add_view(std::vector<float>{2, 0, 0, 0, 1, 0, 0, 0, .5F, .5F, 0, 0}), 5126, 3,
                    "VEC4");
  file.add_accessor(file.add_view(std::vector<float>{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0,  0, 1,
                                                     1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, -2, 0, 1}),
                    5126, 2, "MAT4");
  const auto skinned = [&](const char* more, const char* joints = "[1,2]") {
    return file.glb(fmt::format(
        R"(,"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,"JOINTS_0":1,"WEIGHTS_0":2}}}}]}}],
        "skins":[{{"inverseBindMatrices":3,"joints":{}}}],
        "nodes":[{{"mesh":0,"skin":0,"translation":[100,0,0]}},{{"children":[2]{}}},{{"translation":[5,2,0]}}])",
        joints, more));
  };
  const PolygonMesh mesh = read_gltf_file(skinned(""));
  CHECK(point(mesh, 0) == Point{0, 0, 0});
  CHECK(point(mesh, 1) == Point{6, 2, 0});
  CHECK(point(mesh, 2) == Point{2.5, 1, 0});
  CHECK(faces_of(mesh) == Faces{{0, 1, 2}});
  const PolygonMesh mirrored = read_gltf_file(skinned(R"(,"scale":[-1,1,1])"));
  CHECK(point(mirrored, 1) == Point{-6, 2, 0});
  CHECK(faces_of(mirrored) == Faces{{0, 2, 1}});
  CHECK_THAT(gltf_outcome(skinned("", "[1]")),
             ContainsSubstring("unreadable: vertex 1: its skin has no joint 1"));
  CHECK_THAT(gltf_outcome(skinned("", "[1,2,1]")), ContainsSubstring("2 matrices for 3 joints"));
}
