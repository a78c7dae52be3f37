// Compressed glTF files as the tests need them: streams of Draco and of meshopt.
#pragma once

#include <draco/compression/expert_encode.h>
#include <draco/mesh/triangle_soup_mesh_builder.h>
#include <fmt/format.h>
#include <meshoptimizer.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "support/gltf_files.h"

namespace meander::test {

// A grid of n x n vertices that is bent, so that no coordinate is constant.
struct BentGrid {
  std::vector<float> points;
  std::vector<std::uint32_t> indices;
  explicit BentGrid(std::uint32_t n) {
    for (std::uint32_t i = 0; i < n * n; ++i) {
      const auto x = static_cast<float>(i % n), y = static_cast<float>(i / n);
      points.insert(points.end(), {x, y, std::round(8 * std::sin(x + 2 * y)) / 8 + 0.0F});
    }
    for (std::uint32_t i = 0; i + n + 1 < n * n; ++i)
      if (i % n + 1 < n) indices.insert(indices.end(), {i, i + 1, i + n, i + 1, i + n + 1, i + n});
  }
};

inline std::string encode_draco(draco::TriangleSoupMeshBuilder& builder, int method) {
  const std::unique_ptr<draco::Mesh> mesh = builder.Finalize();
  draco::ExpertEncoder encoder(*mesh);
  encoder.SetEncodingMethod(method);
  draco::EncoderBuffer buffer;
  if (!encoder.EncodeToBuffer(&buffer).ok()) throw std::runtime_error("Draco does not encode");
  return {buffer.data(), buffer.size()};
}

inline std::string draco_stream(const BentGrid& grid, int method) {
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
  return encode_draco(builder, method);
}

// The same with a color for each corner of four numbers from (x, y) of its vertex: floats, or bytes, which
// the stream says are shares of 255, or does not.
inline std::string colored_draco_stream(const BentGrid& grid, int method, bool bytes, bool normalized) {
  draco::TriangleSoupMeshBuilder builder;
  const auto faces = static_cast<int>(grid.indices.size() / 3);
  builder.Start(faces);
  const int position = builder.AddAttribute(draco::GeometryAttribute::POSITION, 3, draco::DT_FLOAT32);
  const int color = builder.AddAttribute(draco::GeometryAttribute::COLOR, 4,
                                         bytes ? draco::DT_UINT8 : draco::DT_FLOAT32, normalized);
  for (int f = 0; f < faces; ++f) {
    const float* corner[3];
    std::uint8_t shares[3][4];
    float values[3][4];
    for (std::size_t k = 0; k < 3; ++k) {
      corner[k] = grid.points.data() + 3 * grid.indices[3 * static_cast<std::size_t>(f) + k];
      for (std::size_t c = 0; c < 4; ++c) {
        const float value = c == 0 ? corner[k][0] / 16 : c == 1 ? corner[k][1] / 16 : 1;
        shares[k][c] = static_cast<std::uint8_t>(std::lround(255 * value));
        values[k][c] = static_cast<float>(shares[k][c]) / 255;
      }
    }
    const draco::FaceIndex face(static_cast<std::uint32_t>(f));
    builder.SetAttributeValuesForFace(position, face, corner[0], corner[1], corner[2]);
    if (bytes)
      builder.SetAttributeValuesForFace(color, face, shares[0], shares[1], shares[2]);
    else
      builder.SetAttributeValuesForFace(color, face, values[0], values[1], values[2]);
  }
  return encode_draco(builder, method);
}

// Values of one attribute of a Draco stream, `width` of type T for each vertex.
struct DracoValues {
  draco::GeometryAttribute::Type kind = draco::GeometryAttribute::POSITION;
  draco::DataType type = draco::DT_FLOAT32;
  bool normalized = false;
  std::size_t width = 3, bytes = 0;  // of a vertex
  std::string values;

  template <class T>
  DracoValues(draco::GeometryAttribute::Type of, std::size_t numbers, const std::vector<T>& from,
              bool marked = false)
      : kind(of),
        type(std::is_same_v<T, float>           ? draco::DT_FLOAT32
             : std::is_same_v<T, std::int8_t>   ? draco::DT_INT8
             : std::is_same_v<T, std::uint8_t>  ? draco::DT_UINT8
             : std::is_same_v<T, std::int16_t>  ? draco::DT_INT16
             : std::is_same_v<T, std::uint16_t> ? draco::DT_UINT16
                                                : draco::DT_UINT32),
        normalized(marked),
        width(numbers),
        bytes(numbers * sizeof(T)),
        values(reinterpret_cast<const char*>(from.data()), from.size() * sizeof(T)) {}
};

// A stream of these attributes, whose ids are their places in the list.
inline std::string draco_stream_of(const std::vector<DracoValues>& attributes,
                                   const std::vector<std::uint16_t>& indices, int method) {
  draco::TriangleSoupMeshBuilder builder;
  const std::size_t faces = indices.size() / 3;
  builder.Start(static_cast<int>(faces));
  for (const DracoValues& values : attributes) {
    const int id = builder.AddAttribute(values.kind, static_cast<std::int8_t>(values.width), values.type,
                                        values.normalized);
    for (std::size_t f = 0; f < faces; ++f) {
      const auto at = [&](std::size_t k) { return values.values.data() + values.bytes * indices[3 * f + k]; };
      builder.SetAttributeValuesForFace(id, draco::FaceIndex(static_cast<std::uint32_t>(f)), at(0), at(1),
                                        at(2));
    }
  }
  return encode_draco(builder, method);
}

inline std::string draco_file(const std::string& stream, std::size_t vertices, std::size_t indices,
                              int id = 0) {
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
inline int add_packed(GltfFile& file, const std::vector<unsigned char>& stream, std::size_t count,
                      std::size_t stride, const std::string& mode, const std::string& filter = "NONE") {
  const int plain = file.add_view(stream);
  const std::size_t offset = file.binary.size() - stream.size();
  file.views += fmt::format(
      R"(,{{"buffer":1,"byteLength":{},"extensions":{{"EXT_meshopt_compression":{{"buffer":0,"byteOffset":{},"byteLength":{},"byteStride":{},"count":{},"mode":"{}","filter":"{}"}}}}}})",
      count * stride, offset, stream.size(), stride, count, mode, filter);
  ++file.view_count;
  return plain + 1;
}

inline std::vector<unsigned char> packed_vertices(const void* data, std::size_t count, std::size_t stride) {
  std::vector<unsigned char> out(meshopt_encodeVertexBufferBound(count, stride));
  out.resize(meshopt_encodeVertexBuffer(out.data(), out.size(), data, count, stride));
  return out;
}

inline std::string meshopt_file(const BentGrid& grid, bool sequence = false, bool exponential = false) {
  GltfFile file;
  const std::size_t count = grid.points.size() / 3;
  std::vector<float> points = grid.points;
#if MESHOPTIMIZER_VERSION >= 200
  if (exponential)
    meshopt_encodeFilterExp(points.data(), count, 12, 24, grid.points.data(), meshopt_EncodeExpSharedVector);
#else
  if (exponential) meshopt_encodeFilterExp(points.data(), count, 12, 24, grid.points.data());
#endif
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

}  // namespace meander::test
