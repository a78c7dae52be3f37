#include <draco/compression/expert_encode.h>
#include <draco/mesh/triangle_soup_mesh_builder.h>
#include <fmt/format.h>
#include <meshoptimizer.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <map>
#include <set>

#include "io/archive/model_bytes.h"
#include "kernels/core/random.h"
#include "reading.h"
#include "support/gltf_files.h"
#include "support/mesh_files.h"

using namespace meander;
using namespace meander::test;
using Catch::Matchers::Contains;

namespace {

namespace fs = std::filesystem;

PolygonMesh read_gltf_file(std::string_view content, const MeshSurroundings& around = {}) {
  return read_mesh(std::as_bytes(std::span(content.data(), content.size())), MeshFormat::gltf, {}, around);
}

std::string gltf_outcome(std::string_view content) { return outcome(content, MeshFormat::gltf); }

double signed_volume(const PolygonMesh& m) {
  double sum = 0;
  for (std::size_t c = 0; c + 2 < m.corners.size(); c += 3) {
    const std::uint32_t a = m.corners[c], b = m.corners[c + 1], d = m.corners[c + 2];
    sum += m.x[a] * (m.y[b] * m.z[d] - m.z[b] * m.y[d]) - m.y[a] * (m.x[b] * m.z[d] - m.z[b] * m.x[d]) +
           m.z[a] * (m.x[b] * m.y[d] - m.y[b] * m.x[d]);
  }
  return sum / 6;
}

std::vector<double> point(const PolygonMesh& mesh, std::size_t v) {
  return {mesh.x[v], mesh.y[v], mesh.z[v]};
}

using Box = std::vector<double>;
Box box_of(const PolygonMesh& m) {
  const auto [x0, x1] = std::minmax_element(m.x.begin(), m.x.end());
  const auto [y0, y1] = std::minmax_element(m.y.begin(), m.y.end());
  const auto [z0, z1] = std::minmax_element(m.z.begin(), m.z.end());
  return {*x0, *x1, *y0, *y1, *z0, *z1};
}

GltfFile cube_file() {
  GltfFile file;
  file.add_points(gltf_cube_points);
  file.add_indices(gltf_cube_indices);
  return file;
}

const std::string cube_mesh = R"("meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}])";
const std::string plain_cube =
    "," + cube_mesh + R"(,"nodes":[{"mesh":0}],"scenes":[{"nodes":[0]}],"scene":0)";

std::string cube_with_nodes(const std::string& rest) { return cube_file().glb("," + cube_mesh + "," + rest); }

std::string primitive_of(const std::string& members) {
  return R"(,"meshes":[{"primitives":[{"attributes":{"POSITION":0})" + members +
         R"(}]}],"nodes":[{"mesh":0}])";
}

// A grid of n x n vertices that is bent, so that no coordinate is constant.
struct Grid {
  std::vector<float> points;
  std::vector<std::uint32_t> indices;
  explicit Grid(std::uint32_t n) {
    for (std::uint32_t i = 0; i < n * n; ++i) {
      const auto x = static_cast<float>(i % n), y = static_cast<float>(i / n);
      points.insert(points.end(), {x, y, std::round(8 * std::sin(x + 2 * y)) / 8 + 0.0F});
    }
    for (std::uint32_t i = 0; i + n + 1 < n * n; ++i)
      if (i % n + 1 < n) indices.insert(indices.end(), {i, i + 1, i + n, i + 1, i + n + 1, i + n});
  }
};

// Triangles as positions, in an order of their own.
std::multiset<std::vector<double>> triangle_set(const PolygonMesh& m) {
  std::multiset<std::vector<double>> set;
  for (std::size_t c = 0; c + 2 < m.corners.size(); c += 3) {
    std::size_t first = 0;
    for (std::size_t k = 1; k < 3; ++k)
      if (point(m, m.corners[c + k]) < point(m, m.corners[c + first])) first = k;
    std::vector<double> values;
    for (std::size_t k = 0; k < 3; ++k)
      for (const double value : point(m, m.corners[c + (first + k) % 3])) values.push_back(value);
    set.insert(values);
  }
  return set;
}

PolygonMesh plain_grid(const Grid& grid) {
  GltfFile file;
  file.add_points(grid.points);
  file.add_indices(grid.indices);
  return read_gltf_file(file.glb(primitive_of(",\"indices\":1")));
}

std::string draco_stream(const Grid& grid, int method) {
  draco::TriangleSoupMeshBuilder builder;
  const auto faces = static_cast<int>(grid.indices.size() / 3);
  builder.Start(faces);
  const int position = builder.AddAttribute(draco::GeometryAttribute::POSITION, 3, draco::DT_FLOAT32);
  for (int f = 0; f < faces; ++f) {
    const auto at = [&](std::size_t k) {
      return grid.points.data() + 3 * grid.indices[3 * static_cast<std::size_t>(f) + k];
    };
    builder.SetAttributeValuesForFace(position, draco::FaceIndex(static_cast<std::uint32_t>(f)), at(0), at(1),
                                      at(2));
  }
  const std::unique_ptr<draco::Mesh> mesh = builder.Finalize();
  draco::ExpertEncoder encoder(*mesh);
  encoder.SetEncodingMethod(method);
  draco::EncoderBuffer buffer;
  REQUIRE(encoder.EncodeToBuffer(&buffer).ok());
  return {buffer.data(), buffer.size()};
}

std::string draco_file(const std::string& stream, std::size_t vertices, std::size_t indices, int id = 0) {
  GltfFile file;
  file.add_view(stream);
  file.add_accessor(-1, 5126, vertices, "VEC3");
  file.add_accessor(-1, 5125, indices, "SCALAR");
  return file.glb(
      primitive_of(fmt::format(
          R"(,"indices":1,"extensions":{{"KHR_draco_mesh_compression":{{"bufferView":0,"attributes":{{"POSITION":{}}}}}}})",
          id)) +
      R"(,"extensionsRequired":["KHR_draco_mesh_compression"])");
}

// A view that is compressed; the view itself is the fallback, which holds nothing.
int add_packed(GltfFile& file, const std::vector<unsigned char>& stream, std::size_t count,
               std::size_t stride, const std::string& mode, const std::string& filter = "NONE") {
  const int plain = file.add_view(stream);
  const std::size_t offset = file.binary.size() - stream.size();
  file.views += fmt::format(
      R"(,{{"buffer":1,"byteLength":{},"extensions":{{"EXT_meshopt_compression":{{"buffer":0,"byteOffset":{},"byteLength":{},"byteStride":{},"count":{},"mode":"{}","filter":"{}"}}}}}})",
      count * stride, offset, stream.size(), stride, count, mode, filter);
  ++file.view_count;
  return plain + 1;
}

std::vector<unsigned char> packed_vertices(const void* data, std::size_t count, std::size_t stride) {
  std::vector<unsigned char> out(meshopt_encodeVertexBufferBound(count, stride));
  out.resize(meshopt_encodeVertexBuffer(out.data(), out.size(), data, count, stride));
  return out;
}

std::string meshopt_file(const Grid& grid, bool sequence = false, bool exponential = false) {
  GltfFile file;
  const std::size_t count = grid.points.size() / 3;
  std::vector<float> points = grid.points;
  if (exponential) meshopt_encodeFilterExp(points.data(), count, 12, 24, grid.points.data());
  const int vertices = add_packed(file, packed_vertices(points.data(), count, 12), count, 12, "ATTRIBUTES",
                                  exponential ? "EXPONENTIAL" : "NONE");
  std::vector<unsigned char> packed(std::max(meshopt_encodeIndexBufferBound(grid.indices.size(), count),
                                             meshopt_encodeIndexSequenceBound(grid.indices.size(), count)));
  packed.resize(sequence ? meshopt_encodeIndexSequence(packed.data(), packed.size(), grid.indices.data(),
                                                       grid.indices.size())
                         : meshopt_encodeIndexBuffer(packed.data(), packed.size(), grid.indices.data(),
                                                     grid.indices.size()));
  const int indices = add_packed(file, packed, grid.indices.size(), 4, sequence ? "INDICES" : "TRIANGLES");
  file.add_accessor(vertices, 5126, count, "VEC3");
  file.add_accessor(indices, 5125, grid.indices.size(), "SCALAR");
  return file.glb(primitive_of(",\"indices\":1") + R"(,"extensionsRequired":["EXT_meshopt_compression"])");
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

}  // namespace

TEST_CASE("glTF: nodes place their meshes, one inside the other, in the order of the scene") {
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
  CHECK(point(mesh, 7) == std::vector<double>{1, -2, 1});
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

TEST_CASE("glTF: the outside stays outside under transforms that mirror") {
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

TEST_CASE("glTF: points and lines are left out and counted, primitives of a mesh share their vertices") {
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
             Contains("empty: the scene holds no triangles, but 8 points and lines"));
  CHECK_THAT(gltf_outcome(cube_file().glb(R"(,"scenes":[{}],"nodes":[{"mesh":0}],)" + cube_mesh)),
             Contains("empty: the scene holds no triangles"));
}

TEST_CASE("glTF: sparse, interleaved and quantised accessors") {
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
    CHECK(point(mesh, 1) == std::vector<double>{5, 0, 0});
    CHECK(point(mesh, 2) == std::vector<double>{0, 1, 0});
    CHECK(point(mesh, 7) == std::vector<double>{6, 6, 6});
    const PolygonMesh zeros =
        read_gltf_file(file.glb(R"(,"meshes":[{"primitives":[{"attributes":{"POSITION":1}}]}])"));
    CHECK(point(zeros, 1) == std::vector<double>{5, 0, 0});
    CHECK(point(zeros, 2) == std::vector<double>{0, 0, 0});
    file.accessors.replace(file.accessors.find("\"count\":8"), 9, "\"count\":7");
    CHECK_THAT(gltf_outcome(file.glb(zeros_first)), Contains("the sparse element 7 is none of its 7"));
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

TEST_CASE("glTF: buffers in the file, as data and beside it") {
  const GltfFile file = cube_file();
  const PolygonMesh expected = read_gltf_file(file.glb(plain_cube));
  CHECK(same_mesh(read_gltf_file(file.with_data_uri(plain_cube)), expected));
  CHECK(same_mesh(read_gltf_file("\xEF\xBB\xBF\n" + file.with_data_uri(plain_cube)), expected));
  std::string percent;
  for (const char c : file.binary) percent += fmt::format("%{:02X}", static_cast<unsigned char>(c));
  CHECK(same_mesh(read_gltf_file(file.json(plain_cube, "data:," + percent)), expected));
  CHECK_THAT(gltf_outcome(file.json(plain_cube, "data:;base64,AA*A")), Contains("unreadable: a data URI"));
  CHECK_THAT(gltf_outcome(file.json(plain_cube)), Contains("neither a file nor a binary chunk"));
  const ScratchFolder scratch;
  fs::create_directories(scratch / "in/b c");
  write_file(scratch / "out.bin", file.binary);
  const auto outcome_beside = [&](const std::string& uri) -> std::string {
    write_file(scratch / "in/m.gltf", file.json(plain_cube, uri));
    try {
      const PolygonMesh mesh = ModelBytes(scratch / "in/m.gltf", {}, MeshFormat::gltf).mesh();
      return same_mesh(mesh, expected) ? "ok" : "another mesh";
    } catch (const ItemError& error) {
      return std::string(name_of(error.status())) + ": " + error.what();
    }
  };
  for (const char* name : {"b c/d.bin", "a%b.bin", "e%20f.bin", "\xC3\xA4.bin"})
    write_file(scratch / (std::string("in/") + name), file.binary);
  for (const char* uri : {"b%20c/d.bin", "b c/./d.bin", "b%20c%2Fd.bin", "a%b.bin", "a%25b.bin",
                          "e%2520f.bin", "%C3%A4.bin", "\xC3\xA4.bin", "./b c//d.bin"}) {
    INFO(uri);
    CHECK(outcome_beside(uri) == "ok");
  }
  for (const char* uri : {"../out.bin", "%2e%2e/out.bin", "b c/../../out.bin", "..%2Fout.bin", "/etc/passwd",
                          "%2Fetc/passwd", "..\\\\out.bin", "b c/d.bin%00"}) {
    INFO(uri);
    CHECK_THAT(outcome_beside(uri),
               Contains("unreadable: buffers[0]") && Contains("leads out of the model's folder"));
  }
  for (const char* uri : {"file:///etc/passwd", "http://x.org/a.bin", "C:/a.bin"})
    CHECK_THAT(outcome_beside(uri), Contains("is not a file of the model's folder"));
  CHECK_THAT(outcome_beside("missing.bin"), Contains("`missing.bin`") && Contains("No such file"));
  CHECK_THAT(outcome_beside("b c"), Contains("not a regular file"));
}

TEST_CASE("glTF: the content of a model covers the files that it names") {
  const ScratchFolder scratch;
  const GltfFile file = cube_file();
  const auto digest = [&](const char* name) {
    return ModelBytes(scratch / name, {}, MeshFormat::gltf).content_sha256();
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
  CHECK(peek_model(scratch / "m.gltf", {}, MeshFormat::gltf).file_bytes ==
        ModelBytes(scratch / "m.gltf", {}, MeshFormat::gltf).file_bytes());
}

TEST_CASE("glTF: skins in rest pose") {
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
  CHECK(point(mesh, 0) == std::vector<double>{0, 0, 0});
  CHECK(point(mesh, 1) == std::vector<double>{6, 2, 0});
  CHECK(point(mesh, 2) == std::vector<double>{2.5, 1, 0});
  CHECK(faces_of(mesh) == Faces{{0, 1, 2}});
  const PolygonMesh mirrored = read_gltf_file(skinned(R"(,"scale":[-1,1,1])"));
  CHECK(point(mirrored, 1) == std::vector<double>{-6, 2, 0});
  CHECK(faces_of(mirrored) == Faces{{0, 2, 1}});
  CHECK_THAT(gltf_outcome(skinned("", "[1]")), Contains("unreadable: vertex 1: its skin has no joint 1"));
  CHECK_THAT(gltf_outcome(skinned("", "[1,2,1]")), Contains("2 matrices for 3 joints"));
}

TEST_CASE("glTF: Draco streams") {
  const Grid grid(9);
  const std::size_t vertices = grid.points.size() / 3, indices = grid.indices.size();
  const auto expected = triangle_set(plain_grid(grid));
  for (const int method : {draco::MESH_SEQUENTIAL_ENCODING, draco::MESH_EDGEBREAKER_ENCODING}) {
    const std::string stream = draco_stream(grid, method);
    const PolygonMesh mesh = read_gltf_file(draco_file(stream, vertices, indices));
    check_consistent(mesh);
    CHECK(triangle_set(mesh) == expected);
    CHECK_THAT(gltf_outcome(draco_file(stream, vertices - 1, indices)),
               Contains("unreadable: the Draco stream"));
    CHECK_THAT(gltf_outcome(draco_file(stream, vertices, indices - 3)), Contains("triangles, its accessors"));
    CHECK_THAT(gltf_outcome(draco_file(stream, vertices, indices, 7)), Contains("it has no attribute 7"));
    check_cuts_and_flips(draco_file(stream, vertices, indices));
  }
  CHECK_THAT(gltf_outcome(draco_file("DRACO", vertices, indices)), Contains("has no header of Draco"));
  CHECK_THAT(gltf_outcome(draco_file("DRACO", 1 << 30, 3 << 20)), Contains("5 bytes of Draco cannot hold"));
}

TEST_CASE("glTF: meshopt streams") {
  const Grid grid(9);
  const PolygonMesh expected = plain_grid(grid);
  CHECK(triangle_set(read_gltf_file(meshopt_file(grid))) == triangle_set(expected));
  const PolygonMesh sequence = read_gltf_file(meshopt_file(grid, true));
  CHECK(same_mesh(sequence, expected));
  CHECK(same_mesh(read_gltf_file(meshopt_file(grid, true, true)), expected));
  check_cuts_and_flips(meshopt_file(Grid(4)));
}

TEST_CASE("glTF: cut and damaged files have a status") {
  check_cuts_and_flips(cube_file().glb(plain_cube));
  const std::string text = cube_file().with_data_uri(plain_cube);
  for (std::size_t bytes = 0; bytes < text.size(); ++bytes)
    REQUIRE(failure(text.substr(0, bytes), MeshFormat::gltf));
  // A file with bytes behind its end is whole.
  const PolygonMesh mesh = read_gltf_file(cube_file().glb(plain_cube) + "xyz");
  CHECK(mesh.repairs[Repair::extra_data] == 3);
}

TEST_CASE("glTF: hostile and odd files have a status and a sentence") {
  const auto glb = [](const std::string& rest) { return cube_file().glb(rest); };
  const auto views = [](const std::string& view, const std::string& accessor) {
    return GltfFile::glb_of(R"({"asset":{"version":"2.0"},"buffers":[{"byteLength":64}],"bufferViews":[)" +
                                view + R"(],"accessors":[)" + accessor +
                                R"(],"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}]})",
                            std::string(64, '\0'));
  };
  const std::string vec3 = R"({"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"})";
  const std::string deep = std::string(100000, '[') + std::string(100000, ']');
  const std::pair<std::string, std::string> cases[] = {
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
      {glb("," + cube_mesh + R"(,"nodes":[{"children":[2]},{"children":[2]},{"mesh":0}])"),
       "nodes[2]: it is reached twice"},
      {glb("," + cube_mesh + R"(,"nodes":[{"mesh":0}],"scenes":[{"nodes":[0,0]}])"),
       "nodes[0]: it is reached twice"},
      {glb("," + cube_mesh + R"(,"nodes":[{"children":[7]}])"), "nodes[7]: there is no such node"},
      {glb("," + cube_mesh + R"(,"nodes":[{"mesh":3}])"), "nodes[0]: there is no mesh 3"},
      {glb("," + cube_mesh + R"(,"nodes":[{"mesh":-1}])"), "nodes[0]: `mesh` is not the number of an entry"},
      {glb("," + cube_mesh + R"(,"nodes":[{"mesh":0,"matrix":[1,2]}])"),
       "`matrix` is not a list of 16 numbers"},
      {glb("," + cube_mesh + R"(,"nodes":[{"mesh":0}],"scene":4)"), "`scene` is 4, and there are 0 scenes"},
      {glb(plain_cube + R"(,"skins":7)"), "`skins` is not a list"},
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
  for (const auto& [content, expected] : cases) {
    INFO(content.substr(0, 400));
    CHECK_THAT(gltf_outcome(content), Contains(expected));
    check_answer(content);
  }
}

TEST_CASE("glTF: what is stated is known before memory is taken") {
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
  const Grid grid(9);
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

TEST_CASE("glTF: the models of a distribution package") {
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
      const ModelBytes model(entry.path(), {}, format);
      PolygonMesh mesh = model.mesh();
      check_consistent(mesh);
      const MeshEstimate estimate = peek_model(entry.path(), {}, format);
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
  // The same engine as it is and as Draco has it, quantised.
  const PolygonMesh& plain = meshes.at("glTF2/2CylinderEngine-glTF-Binary/2CylinderEngine.glb");
  const PolygonMesh& packed = meshes.at("glTF2/draco/2CylinderEngine.gltf");
  CHECK(packed.polygon_count() == plain.polygon_count());
  const Box box = box_of(plain), packed_box = box_of(packed);
  for (std::size_t k = 0; k < 6; ++k) CHECK(packed_box[k] == Approx(box[k]).margin(0.2));
}

TEST_CASE("glTF: streams that are damaged at random places", "[slow]") {
  const Grid grid(9);
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
