// Finding the corner of a polygon that a sample names by its vertex.
#pragma once

#include <cstdint>
#include <unordered_map>
#include <utility>
#include <vector>

#include "kernels/mesh/polygon_mesh.h"

namespace meander {

// Of one mesh. Of polygons with many corners it keeps what it has sorted.
class PolygonCorners {
 public:
  // The mesh must outlive the object.
  explicit PolygonCorners(const PolygonMesh& mesh) : mesh_(mesh) {}

  // The place in PolygonMesh::corners of the first corner of polygon `face` with that vertex; no_index where
  // it has none. O(1), of polygons with many corners once O(corners log corners).
  std::uint32_t find(std::uint32_t face, std::uint32_t vertex);

 private:
  const PolygonMesh& mesh_;
  // Of large polygons: their vertices, ascending, with the place in the corners of the mesh.
  std::unordered_map<std::uint32_t, std::vector<std::pair<std::uint32_t, std::uint32_t>>> sorted_;
};

}  // namespace meander
