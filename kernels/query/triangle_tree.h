// A tree of boxes over the triangles of a mesh, eight children a node, for queries by distance.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "kernels/core/vector3.h"

namespace meander {

// T triangles in positions of the tree's own order. The children of a node lie side by side, so that one
// vector holds a number of each. Float values are bounds: what they say of a query holds in double too, where
// the query allows for float_slack.
struct TriangleTree {
  static constexpr std::size_t fan = 8;
  // child[k]: a node; with leaf_bit a leaf; no_child, which comes after all others, in an infinite box.
  struct alignas(64) Node {
    std::array<std::array<float, fan>, 3> low, high;
    std::array<std::uint32_t, fan> child;
  };
  // What bounds the distance to each triangle of a leaf from below. Four planes: its own, and those through
  // its edges at right angles to it, outwards; zero where rounding leaves the normal uncertain, or an edge
  // has no length. And the smallest ball around it.
  struct alignas(64) Leaf {
    std::array<std::array<std::array<float, fan>, 4>, 4> plane;  // plane, component or offset, triangle
    std::array<std::array<float, fan>, 3> center;
    std::array<float, fan> radius;
  };
  static constexpr std::uint32_t leaf_bit = 0x80000000u, no_child = 0xFFFFFFFFu;
  // Nodes wait in a stack while a query descends; never more than these.
  static constexpr std::size_t max_waiting = 320;

  std::vector<Node> nodes;  // the root first, children after their parents
  std::vector<Leaf> leaves;
  std::vector<std::uint32_t> leaf_begin;  // leaves + 1 positions
  std::vector<std::uint32_t> order;       // T: the triangle at a position
  std::vector<double> corners;            // 9 T: by position

  std::size_t count() const { return order.size(); }
  Vector3 corner(std::size_t position, std::size_t k) const {
    const double* const at = corners.data() + 9 * position + 3 * k;
    return {at[0], at[1], at[2]};
  }
};

// By how much rounding to float can move distances from a point whose largest coordinate is `extent`, boxes
// and planes being those of coordinates in [-1, 1].
constexpr double float_slack(double extent) { return 2e-6 * (1 + extent); }

// Builds the tree by the surface area heuristic in bins (Wald 2007, "On fast construction of SAH-based
// bounding volume hierarchies"). x, y, z: positions in [-1, 1], as the working coordinates of PreparedMesh;
// triangles: 3 T vertex numbers, T >= 1. Throws std::invalid_argument for other arguments. About 0.5 us a
// triangle and 250 bytes (triangle_tree_bytes); large meshes in parallel. The same tree on every machine.
TriangleTree build_triangle_tree(std::span<const double> x, std::span<const double> y,
                                 std::span<const double> z, std::span<const std::uint32_t> triangles);

// Upper bound of the bytes that the tree takes while it is made, and later.
constexpr double triangle_tree_bytes(double triangles) {
  // A third of a leaf and of a node, which is copied, and the corners; or boxes instead of leaves and
  // corners.
  constexpr double bytes_per_triangle = 600, least = 4096;
  return triangles * bytes_per_triangle + least;
}

}  // namespace meander
