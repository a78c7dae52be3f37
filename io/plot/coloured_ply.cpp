#include "io/plot/coloured_ply.h"

#include <fmt/format.h>

#include <stdexcept>

#include "io/mesh/append_numbers.h"

namespace meander {

namespace {

void append_colour(std::string& data, PlyColour colour) {
  for (const std::uint8_t part : colour) data += static_cast<char>(part);
}

constexpr const char* beginning = "ply\nformat binary_little_endian 1.0\n";
constexpr const char* position_properties = "property double x\nproperty double y\nproperty double z\n";
constexpr const char* colour_properties = "property uchar red\nproperty uchar green\nproperty uchar blue\n";

}  // namespace

std::string coloured_mesh_ply(std::span<const double> positions, std::span<const std::uint32_t> faces,
                              std::span<const PlyColour> face_colours) {
  const std::size_t vertices = positions.size() / 3, count = faces.size() / 3;
  if (positions.size() % 3 != 0 || faces.size() % 3 != 0 || face_colours.size() != count)
    throw std::invalid_argument("positions, faces and colours do not fit together");
  if (vertices >= std::size_t{1} << 31) throw std::invalid_argument("too many vertices");
  std::string data = fmt::format(
      "{}element vertex {}\n{}element face {}\nproperty list uchar int vertex_indices\n{}end_header\n",
      beginning, vertices, position_properties, count, colour_properties);
  data.reserve(data.size() + 24 * vertices + 16 * count);
  for (const double p : positions) append_little_endian(data, p);
  for (std::size_t f = 0; f < count; ++f) {
    data += '\3';
    for (std::size_t k = 0; k < 3; ++k)
      append_little_endian(data, static_cast<std::int32_t>(faces[3 * f + k]));
    append_colour(data, face_colours[f]);
  }
  return data;
}

std::string coloured_points_ply(const PlyPoints& points) {
  const std::size_t count = points.positions.size() / 3, columns = points.value_names.size();
  const auto fits = [count](std::size_t length, std::size_t width) {
    return length == 0 || length == width * count;
  };
  if (points.positions.size() % 3 != 0 || !fits(points.normals.size(), 3) ||
      !fits(points.colours.size(), 1) || !fits(points.vectors.size(), 3) ||
      points.values.size() != columns * count)
    throw std::invalid_argument("the arrays of the points do not fit together");
  std::string data = fmt::format("{}element vertex {}\n{}", beginning, count, position_properties);
  if (!points.normals.empty()) data += "property float nx\nproperty float ny\nproperty float nz\n";
  if (!points.colours.empty()) data += colour_properties;
  if (!points.vectors.empty())
    data += "property float direction_x\nproperty float direction_y\nproperty float direction_z\n";
  for (const std::string& name : points.value_names) data += "property float " + name + "\n";
  data += "end_header\n";
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t k = 0; k < 3; ++k) append_little_endian(data, points.positions[3 * i + k]);
    if (!points.normals.empty())
      for (std::size_t k = 0; k < 3; ++k) append_little_endian(data, points.normals[3 * i + k]);
    if (!points.colours.empty()) append_colour(data, points.colours[i]);
    if (!points.vectors.empty())
      for (std::size_t k = 0; k < 3; ++k) append_little_endian(data, points.vectors[3 * i + k]);
    for (std::size_t k = 0; k < columns; ++k) append_little_endian(data, points.values[columns * i + k]);
  }
  return data;
}

}  // namespace meander
