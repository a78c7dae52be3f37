// Reading glTF files that the tests make.
#pragma once

#include <algorithm>
#include <array>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "kernels/core/vector3.h"
#include "reading.h"
#include "support/catch.h"
#include "support/gltf_files.h"

namespace meander::test {

inline PolygonMesh read_gltf_file(std::string_view content, const MeshSurroundings& around = {}) {
  return read_mesh(std::as_bytes(std::span(content.data(), content.size())), MeshFormat::gltf, {}, around);
}

inline std::string gltf_outcome(std::string_view content) { return outcome(content, MeshFormat::gltf); }

inline double signed_volume(const PolygonMesh& m) {
  double sum = 0;
  for (std::size_t c = 0; c + 2 < m.corners.size(); c += 3) {
    const std::uint32_t a = m.corners[c], b = m.corners[c + 1], d = m.corners[c + 2];
    sum += m.x[a] * (m.y[b] * m.z[d] - m.z[b] * m.y[d]) - m.y[a] * (m.x[b] * m.z[d] - m.z[b] * m.x[d]) +
           m.z[a] * (m.x[b] * m.y[d] - m.y[b] * m.x[d]);
  }
  return sum / 6;
}

inline double area_of(const PolygonMesh& mesh) {
  double area = 0;
  for (std::size_t c = 0; c + 2 < mesh.corners.size(); c += 3) {
    const auto at = [&](std::size_t k) {
      const std::uint32_t v = mesh.corners[c + k];
      return Vector3{mesh.x[v], mesh.y[v], mesh.z[v]};
    };
    area += 0.5 * norm(cross(at(1) - at(0), at(2) - at(0)));
  }
  return area;
}

using Point = std::array<double, 3>;
inline Point point(const PolygonMesh& mesh, std::size_t v) { return {mesh.x[v], mesh.y[v], mesh.z[v]}; }

using Box = std::vector<double>;
inline Box box_of(const PolygonMesh& m) {
  const auto [x0, x1] = std::minmax_element(m.x.begin(), m.x.end());
  const auto [y0, y1] = std::minmax_element(m.y.begin(), m.y.end());
  const auto [z0, z1] = std::minmax_element(m.z.begin(), m.z.end());
  return {*x0, *x1, *y0, *y1, *z0, *z1};
}

inline GltfFile cube_file() {
  GltfFile file;
  file.add_points(gltf_cube_points);
  file.add_indices(gltf_cube_indices);
  return file;
}

inline const std::string cube_mesh =
    R"("meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}])";
inline const std::string plain_cube =
    "," + cube_mesh + R"(,"nodes":[{"mesh":0}],"scenes":[{"nodes":[0]}],"scene":0)";

inline std::string cube_with_nodes(const std::string& rest) {
  return cube_file().glb("," + cube_mesh + "," + rest);
}

}  // namespace meander::test
