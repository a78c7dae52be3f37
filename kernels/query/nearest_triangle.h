// The nearest triangles of a mesh, for many points.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "kernels/core/cancel.h"
#include "kernels/core/instruction_set.h"
#include "kernels/query/triangle_tree.h"

namespace meander {

// Of n points.
struct NearestTriangles {
  std::vector<double> distance;         // n, >= 0
  std::vector<std::uint32_t> triangle;  // n: the lowest number where several are equally near
  std::vector<double> weights;          // 2 n: of corners 1 and 2 at the nearest point, >= 0, sum <= 1
};

// Beyond this distance from the middle of the mesh double does not tell its parts apart.
inline constexpr double farthest_point = 1e12;

// Finds the nearest point of the mesh of `tree` for every point: 3 n coordinates in those of the tree, at
// most farthest_point each (else std::invalid_argument). The answers are those of nearest_on_triangle for all
// triangles in turn, bit for bit: float boxes and planes only leave out what is farther with certainty. The
// error of a distance is about 1e-15 (1 + |p|). Triangles without area are segments or points.
//
// Eight points that follow each other are searched for together, from the triangle of the last one on: they
// should be neighbors (along_curve). Parallel, and the same for every order of the points, thread count and
// instruction set. A search ends, as it takes nodes and triangles once each at most. Throws timeout /
// RunCanceled from `cancel`. On models of 3,000 to 13,000 triangles, one core with AVX2: 0.7 us a point of
// which three fifths are near the surface and the others in its box, tree and order included; more where much
// of the surface is equally far (the center of a sphere: all of it).
NearestTriangles nearest_triangles(const TriangleTree& tree, std::span<const double> points,
                                   const CancelToken& cancel = {},
                                   InstructionSet set = InstructionSet::automatic);

// Upper bound of the bytes that nearest triangles take beside the points and the tree.
constexpr double nearest_triangles_bytes(double points) { return points * 28; }

}  // namespace meander
