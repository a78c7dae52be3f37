#include "io/mesh/gltf_draco.h"

#include <draco/compression/mesh/mesh_edgebreaker_decoder.h>
#include <draco/compression/mesh/mesh_sequential_decoder.h>
#include <draco/core/varint_decoding.h>
#include <draco/mesh/mesh.h>
#include <fmt/format.h>

#include <array>
#include <string>

#include "kernels/core/status.h"

namespace meander {

namespace {

// The attributes of a vertex may take this while they are decoded; positions, normals, colors and texture
// coordinates with joints and weights take about 100.
constexpr std::uint64_t most_bytes_per_vertex = 512;

struct DracoBounds {
  std::uint64_t vertices = 0, triangles = 0;
  std::string problem;

  bool refuse(std::string what) {
    problem = std::move(what);
    return false;
  }
};

// Draco takes memory for the numbers that a stream states before it has seen data for them, so these are
// looked at first.
template <class Decoder>
class BoundedDecoder final : public Decoder {
 public:
  explicit BoundedDecoder(DracoBounds& bounds) : bounds_(bounds) {}

 protected:
  bool DecodeConnectivity() override {
    constexpr bool is_sequential = std::is_same_v<Decoder, draco::MeshSequentialDecoder>;
    draco::DecoderBuffer ahead = *this->buffer();
    std::uint32_t first = 0, second = 0;
    if (!draco::DecodeVarint(&first, &ahead) || !draco::DecodeVarint(&second, &ahead))
      return bounds_.refuse("it is cut");
    const std::uint32_t triangles = is_sequential ? first : second, vertices = is_sequential ? second : first;
    if (triangles > bounds_.triangles || vertices > bounds_.vertices)
      return bounds_.refuse(fmt::format("it states {} vertices and {} triangles, its accessors {} and {}",
                                        vertices, triangles, bounds_.vertices, bounds_.triangles));
    return Decoder::DecodeConnectivity();
  }

  bool DecodeAllAttributes() override {
    const draco::PointCloud& cloud = *this->point_cloud();
    if (cloud.num_points() > bounds_.vertices)
      return bounds_.refuse(
          fmt::format("it has {} vertices, its accessors {}", cloud.num_points(), bounds_.vertices));
    std::uint64_t bytes = 0;
    for (int a = 0; a < cloud.num_attributes(); ++a) {
      const draco::PointAttribute& attribute = *cloud.attribute(a);
      // The values, the same as integers, the number of the value of each vertex.
      bytes += static_cast<std::uint64_t>(attribute.byte_stride()) +
               4 * static_cast<std::uint64_t>(attribute.num_components()) + 4;
    }
    if (bytes > most_bytes_per_vertex)
      return bounds_.refuse(fmt::format("its attributes would take {} bytes a vertex", bytes));
    return Decoder::DecodeAllAttributes();
  }

 private:
  DracoBounds& bounds_;
};

template <class Decoder>
bool decode_with(draco::DecoderBuffer& buffer, draco::Mesh& mesh, DracoBounds& bounds) {
  BoundedDecoder<Decoder> decoder(bounds);
  const draco::DecoderOptions options;
  const draco::Status status = decoder.Decode(options, &buffer, &mesh);
  if (!status.ok() && bounds.problem.empty()) bounds.problem = "it is damaged";
  return status.ok();
}

[[noreturn]] void fail(const std::string& what) {
  throw ItemError(Status::unreadable, "the Draco stream: " + what);
}

void decode(std::string_view stream, draco::Mesh& mesh, DracoBounds& bounds) {
  draco::DecoderBuffer buffer, ahead;
  buffer.Init(stream.data(), stream.size());
  ahead.Init(stream.data(), stream.size());
  draco::DracoHeader header;
  if (!draco::PointCloudDecoder::DecodeHeader(&ahead, &header).ok()) fail("it has no header of Draco");
  if (header.version_major != 2 || header.version_minor != 2)
    fail(fmt::format("its version is {}.{}, and that of glTF is 2.2", header.version_major,
                     header.version_minor));
  if (header.encoder_type != draco::TRIANGULAR_MESH) fail("it holds points");
  const bool done = header.encoder_method == draco::MESH_SEQUENTIAL_ENCODING
                        ? decode_with<draco::MeshSequentialDecoder>(buffer, mesh, bounds)
                    : header.encoder_method == draco::MESH_EDGEBREAKER_ENCODING
                        ? decode_with<draco::MeshEdgebreakerDecoder>(buffer, mesh, bounds)
                        : bounds.refuse(fmt::format("its encoding {} is unknown", header.encoder_method));
  if (!done) fail(bounds.problem);
}

// The largest number of a type of integers; 0 of others.
double largest_of(draco::DataType type) {
  switch (type) {
    case draco::DT_INT8:
      return 127;
    case draco::DT_UINT8:
      return 255;
    case draco::DT_INT16:
      return 32767;
    case draco::DT_UINT16:
      return 65535;
    case draco::DT_INT32:
      return 2147483647;
    case draco::DT_UINT32:
      return 4294967295;
    default:
      return 0;
  }
}

// What an integer of the stream is divided by. The accessor decides: the stream's own mark is not kept by all
// programs, and counts where the accessor has floats alone.
double divisor_of(const draco::PointAttribute& attribute, const DracoAttribute& wanted) {
  const double largest = largest_of(attribute.data_type());
  if (largest == 0) return 1;
  if (wanted.component == GltfComponent::float32)
    return wanted.normalized || attribute.normalized() ? largest : 1;
  return wanted.normalized ? largest_of(wanted.component) : 1;
}

bool convert(const draco::PointAttribute& attribute, draco::AttributeValueIndex at, std::uint32_t width,
             double divisor, double* to) {
  const auto numbers = static_cast<std::int8_t>(width);
  if (largest_of(attribute.data_type()) == 0) return attribute.ConvertValue<double>(at, numbers, to);
  // As integers they come as they are, whatever the stream says of them.
  std::array<std::int64_t, 16> values{};
  if (width > values.size() || !attribute.ConvertValue<std::int64_t>(at, numbers, values.data()))
    return false;
  for (std::uint32_t k = 0; k < width; ++k)
    to[k] = divisor == 1 ? static_cast<double>(values[k])
                         : std::max(static_cast<double>(values[k]) / divisor, -1.0);
  return true;
}

std::vector<double> values_of(const draco::Mesh& mesh, const DracoAttribute& wanted) {
  const draco::PointAttribute* const attribute = mesh.GetAttributeByUniqueId(wanted.id);
  if (attribute == nullptr) fail(fmt::format("it has no attribute {}", wanted.id));
  if (static_cast<std::uint32_t>(attribute->num_components()) != wanted.width)
    fail(fmt::format("its attribute {} has {} numbers a vertex instead of {}", wanted.id,
                     attribute->num_components(), wanted.width));
  const double divisor = divisor_of(*attribute, wanted);
  std::vector<double> values(std::size_t{mesh.num_points()} * wanted.width);
  for (draco::PointIndex point(0); point < mesh.num_points(); ++point) {
    const draco::AttributeValueIndex at = attribute->mapped_index(point);
    double* const to = values.data() + std::size_t{point.value()} * wanted.width;
    if (at.value() >= attribute->size() || !convert(*attribute, at, wanted.width, divisor, to))
      fail(fmt::format("its attribute {} is damaged", wanted.id));
  }
  return values;
}

std::vector<double> optional_values_of(const draco::Mesh& mesh, const DracoAttribute& wanted) {
  try {
    return values_of(mesh, wanted);
  } catch (const ItemError&) {
    return {};
  }
}

}  // namespace

DracoMesh decode_draco(std::string_view stream, std::span<const DracoAttribute> attributes,
                       std::uint64_t most_vertices, std::uint64_t most_triangles) {
  draco::Mesh mesh;
  DracoBounds bounds{most_vertices, most_triangles, {}};
  decode(stream, mesh, bounds);
  DracoMesh decoded;
  decoded.vertices = mesh.num_points();
  for (const DracoAttribute& attribute : attributes)
    decoded.values.push_back(attribute.optional ? optional_values_of(mesh, attribute)
                                                : values_of(mesh, attribute));
  decoded.corners.reserve(std::size_t{3} * mesh.num_faces());
  for (draco::FaceIndex face(0); face < mesh.num_faces(); ++face)
    for (const draco::PointIndex& corner : mesh.face(face)) decoded.corners.push_back(corner.value());
  return decoded;
}

}  // namespace meander
