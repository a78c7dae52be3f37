#include "io/mesh/polygon_parts.h"

#include <algorithm>
#include <limits>
#include <string>
#include <utility>

#include "kernels/core/parallel.h"

namespace meander {

std::uint32_t saturated(std::uint64_t count) {
  return static_cast<std::uint32_t>(
      std::min<std::uint64_t>(count, std::numeric_limits<std::uint32_t>::max()));
}

void join_polygons(std::vector<PolygonPart>& parts, PolygonMesh& mesh) {
  std::uint64_t polygons = 0, corners = 0;
  for (const PolygonPart& part : parts) {
    polygons += part.count();
    corners += part.corners.size();
  }
  check_count(polygons, "polygons");
  check_count(corners, "corners");
  if (polygons == 0) {
    mesh.polygon_begin.clear();
    mesh.corners.clear();
    return;
  }
  if (parts.size() == 1) {
    mesh.polygon_begin = std::move(parts[0].begin);
    mesh.corners = std::move(parts[0].corners);
    return;
  }
  mesh.polygon_begin.clear();
  mesh.polygon_begin.reserve(polygons + 1);
  mesh.polygon_begin.push_back(0);
  mesh.corners.clear();
  mesh.corners.reserve(corners);
  for (PolygonPart& part : parts) {
    const auto base = static_cast<std::uint32_t>(mesh.corners.size());
    for (std::size_t p = 1; p < part.begin.size(); ++p) mesh.polygon_begin.push_back(base + part.begin[p]);
    mesh.corners.insert(mesh.corners.end(), part.corners.begin(), part.corners.end());
    part = PolygonPart{};
  }
}

void number_triangles(std::size_t triangles, PolygonMesh& mesh) {
  check_count(3 * std::uint64_t{triangles}, "corners");
  mesh.polygon_begin.resize(triangles + 1);
  mesh.corners.resize(3 * triangles);
  parallel_blocks(triangles, parallel_threshold, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t)
      mesh.polygon_begin[t + 1] = static_cast<std::uint32_t>(3 * t + 3);
    for (std::size_t c = 3 * begin; c < 3 * end; ++c) mesh.corners[c] = static_cast<std::uint32_t>(c);
  });
}

}  // namespace meander
