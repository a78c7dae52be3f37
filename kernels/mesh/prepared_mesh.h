// A mesh ready for geometry: oriented 2-manifold triangles with boundary, sorted by component.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "kernels/core/status.h"
#include "kernels/core/vector3.h"
#include "kernels/mesh/polygon_mesh.h"

namespace meander {

// Half-edge h = 3 t + k of triangle t runs from corner k to corner (k + 1) % 3.
constexpr std::uint32_t next_half_edge(std::uint32_t h) { return h % 3 == 2 ? h - 2 : h + 1; }
constexpr std::uint32_t previous_half_edge(std::uint32_t h) { return h % 3 == 0 ? h + 2 : h - 1; }

// One connected component: a contiguous range of triangles and of working vertices.
struct Component {
  std::uint32_t triangle_begin = 0, triangle_end = 0;
  std::uint32_t vertex_begin = 0, vertex_end = 0;
  std::uint32_t boundary_loops = 0;
  std::uint32_t genus = 0;
  double area = 0;  // working units squared
};

// T triangles over W working vertices. Working coordinate w and file coordinate p: p = center + unit * w,
// with `unit` a power of two, so that every coordinate lies in [-1, 1] whatever the file's scale or origin.
// Components are ordered by the 3-D Hilbert key of their area centroid (the curve visits them in that order).
struct PreparedMesh {
  Vector3 center;                // file units
  double unit = 1;               // file units per working unit, a power of two
  double diagonal = 0;           // of the bounding box, file units
  std::array<double, 6> bbox{};  // min x, y, z, max x, y, z of all polygons with an area, file units

  std::vector<double> x, y, z;           // W each, working units
  std::vector<std::uint32_t> triangles;  // 3 T working vertices
  // 3 T: the half-edge on the other side, no_index at a boundary; empty without topology (prepare_soup),
  // or once freed (SampleParameters::rows_only).
  std::vector<std::uint32_t> opposite;
  std::vector<std::uint32_t> corner_slot;  // 3 T indices of PolygonMesh::corners
  std::vector<std::uint32_t> polygon;      // T polygon numbers of the file
  std::vector<double> area;                // T, working units squared; 0 for triangles without area
  std::vector<Component> components;
  double total_area = 0;  // working units squared, summed in fixed blocks
  std::uint32_t unreferenced_vertices = 0;
  RepairCounts repairs;  // the reader's counts and those of prepare_mesh

  bool has_topology() const { return !opposite.empty(); }
  std::size_t triangle_count() const { return polygon.size(); }
  std::size_t vertex_count() const { return x.size(); }
  Vector3 position(std::uint32_t vertex) const { return {x[vertex], y[vertex], z[vertex]}; }
  Vector3 centroid(std::size_t triangle) const {
    const std::uint32_t* const corner = &triangles[3 * triangle];
    return (1.0 / 3) * (position(corner[0]) + position(corner[1]) + position(corner[2]));
  }
  double length_in_space(std::uint32_t half_edge) const {
    return distance(position(triangles[half_edge]), position(triangles[next_half_edge(half_edge)]));
  }
};

// The origin of the working coordinates, in working units of the file's axes.
inline Vector3 center_in_units(const PreparedMesh& mesh) {
  return {mesh.center.x / mesh.unit, mesh.center.y / mesh.unit, mesh.center.z / mesh.unit};
}

// Converts an area or a mass from working units to those of the file: infinite or 0 where double overflows or
// underflows.
inline double file_area(const PreparedMesh& mesh, double working) { return working * mesh.unit * mesh.unit; }

}  // namespace meander
