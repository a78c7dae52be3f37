// PLY files with colours, for mesh viewers: what the stages of sampling made.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>

namespace meander {

using PlyColour = std::array<std::uint8_t, 3>;  // sRGB

// V x 3 positions and T x 3 vertex numbers (int, as most viewers want them), and one colour per face. Binary
// little-endian: vertex x y z (double), face vertex_indices red green blue. Throws std::invalid_argument when
// the lengths disagree or there are 2^31 vertices or more.
std::string coloured_mesh_ply(std::span<const double> positions, std::span<const std::uint32_t> faces,
                              std::span<const PlyColour> face_colours);

// What stands at N points. `normals` and `vectors` are 3 N, `values` N times as many as `value_names`; each
// may be empty. `vectors` become the properties direction_x direction_y direction_z.
struct PlyPoints {
  std::span<const double> positions;  // 3 N
  std::span<const float> normals{};
  std::span<const PlyColour> colours{};
  std::span<const float> vectors{};
  std::span<const std::string> value_names{};
  std::span<const float> values{};
};
std::string coloured_points_ply(const PlyPoints& points);

}  // namespace meander
