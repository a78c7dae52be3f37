// Generalized winding numbers (Jacobson, Kavan, Sorkine-Hornung 2013, "Robust inside-outside segmentation
// using generalized winding numbers"): how often a surface winds around points; the sum of the solid angles
// of its triangles over 4 pi. Of closed surfaces it is a whole number: 1 inside one that is wound outward.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "kernels/core/cancel.h"
#include "kernels/core/instruction_set.h"
#include "kernels/query/curve_order.h"
#include "kernels/query/triangle_tree.h"

namespace meander {

// The slow way: all triangles in turn. x, y, z: positions; triangles: 3 T vertex numbers, counter-clockwise
// seen from outside. A triangle counts nothing for points in its plane. Error about 1e-16 T, except that a
// point within 1e-16 of the surface may be on either side. O(T), some 40 ns a triangle.
double exact_winding_number(std::span<const double> x, std::span<const double> y, std::span<const double> z,
                            std::span<const std::uint32_t> triangles, Vector3 point);
// Adds up the same angles with one arc tangent for all triangles; differs by rounding.
double short_winding_number(std::span<const double> x, std::span<const double> y, std::span<const double> z,
                            std::span<const std::uint32_t> triangles, Vector3 point);

// What the triangles below the nodes of a TriangleTree amount to from afar.
struct WindingTree {
  static constexpr std::size_t fan = TriangleTree::fan, terms = 19;
  // Of each child: the middle, from which squared distance on the expansion stands for its triangles by the
  // two bounds, and the
  // dipole (3 numbers), quadrupole (6) and octupole (10) around it.
  struct alignas(64) Node {
    std::array<std::array<float, fan>, 3> center;
    std::array<float, fan> from, strictly_from;
    std::array<std::array<float, fan>, terms> term;
  };
  // Corners of the triangles of a leaf; 0 where there is none.
  struct alignas(64) Leaf {
    std::array<std::array<double, fan>, 9> corner;
  };
  const TriangleTree* tree = nullptr;  // must live as long
  std::vector<Node> nodes;             // as those of the tree
  std::vector<Leaf> leaves;
  double bound = 0, strict_bound = 0;
};

// Prepares a tree for winding numbers, after Barill, Dickson, Schmidt, Levin, Jacobson 2018, "Fast winding
// numbers for soups and clouds": nodes that are far away stand for their triangles, expanded to second order.
// flipped: a byte for each triangle that is to be turned over where it is not 0, or nothing. bound: the
// largest error of a winding number, above 0 (else std::invalid_argument). It holds with certainty: the rest
// of an expansion is that of solid harmonics of degree 4 and more, whose gradients are largest on their axes,
// so that a node of area a and radius r at the distance R contributes at most a / (4 pi R^2) sum_{k >= 3} (k
// + 1) (r / R)^k; each node is granted the share of the bound that it has of the area. Rounding to float adds
// at most 2e-5. strict_bound: that of numbers that are asked for strictly; none: the same. About 0.5 us a
// triangle. The same for every thread count and machine.
WindingTree build_winding_tree(const TriangleTree& tree, std::span<const std::uint8_t> flipped, double bound,
                               std::optional<double> strict_bound = std::nullopt);

// Upper bound of the bytes that it takes beside the tree of triangles, while it is made.
constexpr double winding_tree_bytes(double triangles) {
  // A third of a leaf and of a node, with their moments.
  constexpr double bytes_per_triangle = 600, least = 4096;
  return triangles * bytes_per_triangle + least;
}

// The winding number of one point, by the strict bound if it is asked for.
double winding_number(const WindingTree& winding, Vector3 point, bool strictly = false);

// Winding numbers of 3 n coordinates in those of the tree, finite (else std::invalid_argument). Parallel; the
// same for every order of the points, thread count and instruction set. A search ends, as it takes nodes and
// triangles once each at most. Throws timeout / RunCanceled from `cancel`.
std::vector<double> winding_numbers(const WindingTree& winding, std::span<const double> points,
                                    const CancelToken& cancel = {},
                                    InstructionSet set = InstructionSet::automatic);

// Upper bound of the bytes that they take beside the points, sorting included.
constexpr double winding_numbers_bytes(double points) { return points * (8 + curve_order_bytes); }

}  // namespace meander
