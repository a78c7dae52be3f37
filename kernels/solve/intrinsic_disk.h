// A surface known by its edge lengths alone, for the flattening solvers (a disk) and the heat geodesics (any
// component).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "kernels/mesh/prepared_mesh.h"

namespace meander {

// T triangles over V vertices. The flattening solvers and boundary_half_edges need one boundary loop;
// lengths, corner geometry and make_intrinsic_delaunay take any orientable surface, closed or not. Lengths
// are positive and agree on both sides of an edge; the triangle inequality holds strictly after mollify(). A
// pair of vertices may be joined by more than one edge, and an edge may end where it began (intrinsic
// triangulations).
struct IntrinsicDisk {
  std::vector<std::uint32_t> triangles;  // 3 T
  std::vector<std::uint32_t> opposite;   // 3 T, no_index on the boundary
  std::vector<double> length;            // 3 T, by half-edge
  std::uint32_t vertex_count = 0;
  // Only for speed: vertices in a fill-reducing order, from which boundary vertices are skipped. Where it is
  // empty, the solver finds one.
  std::vector<std::uint32_t> elimination;

  std::size_t triangle_count() const { return triangles.size() / 3; }
};
// The same for surfaces that are not disks.
using IntrinsicSurface = IntrinsicDisk;

// Adds the smallest uniform length to all edges such that every triangle inequality holds with a margin of
// 1e-9 mean lengths (and 1e-12 of the triangle's longest edge), so that cotangents are finite. A mesh without
// degenerate triangles does not change. Returns the added length. O(T). Sharp and Crane 2020, "A Laplacian
// for nonmanifold triangle meshes".
double mollify(std::span<double> length);

// Angle and half cotangent per corner, from lengths. The angles of a triangle sum to pi. O(T).
struct CornerGeometry {
  std::vector<double> angle;           // 3 T, radians, of corner h
  std::vector<double> half_cotangent;  // 3 T, of the corner opposite half-edge h
};
CornerGeometry corner_geometry(std::span<const double> length);

// Calls body(a, b, weight) for every edge between two vertices, in the order of its smaller half-edge; weight
// is the sum of `half` over the half-edges of the edge. Edges that end where they began are left out.
template <class Body>
void for_each_edge(const IntrinsicDisk& disk, std::span<const double> half, const Body& body) {
  for (std::uint32_t h = 0; h < disk.opposite.size(); ++h) {
    const std::uint32_t other = disk.opposite[h];
    if (other != no_index && other < h) continue;
    const std::uint32_t a = disk.triangles[h], b = disk.triangles[next_half_edge(h)];
    if (a != b) body(a, b, half[h] + (other == no_index ? 0.0 : half[other]));
  }
}

// Boundary half-edges in order around the disk, starting with the smallest index. O(T).
std::vector<std::uint32_t> boundary_half_edges(std::span<const std::uint32_t> triangles,
                                               std::span<const std::uint32_t> opposite,
                                               std::uint32_t vertex_count);

}  // namespace meander
