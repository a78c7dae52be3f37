// The corner of a polygon that a sample names by its vertex.
#pragma once

#include <cstdint>
#include <unordered_map>
#include <utility>
#include <vector>

#include "kernels/mesh/polygon_mesh.h"

namespace meander {

// Finds corners of one mesh. It keeps the sorted corners of polygons with many of them.
class PolygonCorners {
 public:
  // The mesh must outlive the object.
  explicit PolygonCorners(const PolygonMesh& mesh) : mesh_(mesh) {}

  // The index in PolygonMesh::corners of the first corner of polygon `face` with that vertex; no_index where
  // there is none. O(1), for polygons with many corners O(log corners) after one O(corners log corners).
  std::uint32_t find(std::uint32_t face, std::uint32_t vertex);

 private:
  const PolygonMesh& mesh_;
  // For large polygons, their vertices, ascending, with the index in the corners of the mesh.
  std::unordered_map<std::uint32_t, std::vector<std::pair<std::uint32_t, std::uint32_t>>> sorted_;
};

}  // namespace meander
