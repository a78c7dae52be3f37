// Reading meshes from strings.
#pragma once

#include <cstring>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "io/mesh/format_readers.h"
#include "support/catch.h"

namespace meander::test {

inline PolygonMesh read(std::string_view content, MeshFormat format, const BlockRule& rule = {}) {
  return read_mesh_in_blocks(std::as_bytes(std::span(content.data(), content.size())), format, {}, rule);
}

// How reading fails; nothing when it does not.
inline std::optional<ItemError> failure(std::string_view content, MeshFormat format) {
  try {
    read(content, format);
  } catch (const ItemError& error) {
    return error;
  }
  return std::nullopt;
}

// "unreadable: line 3: ..." for comparisons with readable messages.
inline std::string outcome(std::string_view content, MeshFormat format) {
  const std::optional<ItemError> error = failure(content, format);
  return error ? std::string(name_of(error->status())) + ": " + error->what() : "ok";
}

inline std::vector<std::vector<std::uint32_t>> faces_of(const PolygonMesh& mesh) {
  std::vector<std::vector<std::uint32_t>> faces;
  for (std::size_t p = 0; p < mesh.polygon_count(); ++p)
    faces.emplace_back(mesh.corners.begin() + mesh.polygon_begin[p],
                       mesh.corners.begin() + mesh.polygon_begin[p + 1]);
  return faces;
}

using Faces = std::vector<std::vector<std::uint32_t>>;

// The same bits everywhere: NaN equals itself.
template <class T>
bool same_bits(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}

inline bool same_attributes(const std::vector<ScalarAttribute>& a, const std::vector<ScalarAttribute>& b) {
  if (a.size() != b.size()) return false;
  for (std::size_t k = 0; k < a.size(); ++k)
    if (a[k].name != b[k].name || !same_bits(a[k].values, b[k].values)) return false;
  return true;
}

inline bool same_mesh(const PolygonMesh& a, const PolygonMesh& b) {
  return same_bits(a.x, b.x) && same_bits(a.y, b.y) && same_bits(a.z, b.z) &&
         a.polygon_begin == b.polygon_begin && a.corners == b.corners && same_bits(a.normals, b.normals) &&
         a.corner_normals == b.corner_normals && same_attributes(a.vertex_attributes, b.vertex_attributes) &&
         same_attributes(a.face_attributes, b.face_attributes) && a.repairs.counts == b.repairs.counts;
}

// What every mesh that a reader returns satisfies.
inline void check_consistent(const PolygonMesh& mesh) {
  const std::size_t vertices = mesh.vertex_count(), polygons = mesh.polygon_count();
  REQUIRE(mesh.y.size() == vertices);
  REQUIRE(mesh.z.size() == vertices);
  REQUIRE(polygons > 0);
  REQUIRE(mesh.polygon_begin.front() == 0);
  REQUIRE(mesh.polygon_begin.back() == mesh.corners.size());
  bool ascending = true;
  for (std::size_t p = 0; p < polygons; ++p)
    ascending = ascending && mesh.polygon_begin[p] <= mesh.polygon_begin[p + 1];
  REQUIRE(ascending);
  REQUIRE(mesh.normals.size() % 3 == 0);
  if (mesh.corner_normals.empty())
    REQUIRE((mesh.normals.empty() || mesh.normals.size() == 3 * vertices));
  else
    REQUIRE(mesh.corner_normals.size() == mesh.corners.size());
  for (const ScalarAttribute& attribute : mesh.vertex_attributes)
    REQUIRE(attribute.values.size() == vertices);
  for (const ScalarAttribute& attribute : mesh.face_attributes) REQUIRE(attribute.values.size() == polygons);
}

}  // namespace meander::test
