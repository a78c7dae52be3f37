// The adaptive tree of sample_surface: patches on which the surface was evaluated, and the leaves below them.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "kernels/core/cancel.h"
#include "kernels/curve/curve_frames.h"
#include "kernels/curve/curve_tree.h"
#include "kernels/surface/surface_measure.h"

namespace meander {

// A biquadratic polynomial, sum of c[3 i + j] s^i t^j, over a patch's own square [0, 1]^2: mass per unit of
// it.
using PatchPolynomial = std::array<double, 9>;

// A node inside a patch, in the patch's own square.
struct PatchNode {
  double s = 0, t = 0, side = 1;
  double mass = 0;
  std::uint8_t depth = 0, frame = 0;  // in the whole tree
};

class PatchTree {
 public:
  PatchTree(const SurfaceMeasure& measure, const SurfaceSampleParameters& parameters,
            const CancelToken& cancel);

  const CurveTree& patches() const { return patches_; }
  // P + 1 ascending sums of the patches' masses; the last is the measure of the surface.
  const std::vector<double>& cumulative() const { return cumulative_; }
  double total() const { return cumulative_.back(); }
  double area() const { return area_; }
  std::uint64_t unresolved() const { return unresolved_; }

  PatchNode root(std::size_t patch) const;
  // Whether the node is a leaf: light enough, at the maximum depth, or in a patch that no polynomial fits.
  bool is_leaf(std::size_t patch, const PatchNode& node) const;
  // Sets the children in curve order; their masses sum to that of the node. Returns their number.
  std::size_t children(std::size_t patch, const PatchNode& node, std::array<PatchNode, 9>& result) const;
  // The leaf that holds the position `rest` (0 <= rest < mass of the patch) along the curve.
  PatchNode find_leaf(std::size_t patch, double rest) const;
  // An upper bound of the measure per unit of the curve's square in the node (of the polynomial; for a whole
  // patch also of every value seen).
  double bound(std::size_t patch, const PatchNode& node) const;

  // Calls visit(node) for the leaves of a patch in curve order.
  template <class Visit>
  void visit_leaves(std::size_t patch, const Visit& visit) const {
    visit_below(patch, root(patch), visit);
  }
  // The number of leaves below every patch. O(leaves).
  std::vector<std::uint64_t> count_leaves() const;

 private:
  struct Record {
    double mass = 0, area = 0, peak = 0;  // peak: maximum value seen, per unit of the curve's square
    PatchPolynomial polynomial{};
    bool divisible = true;  // the polynomial fits well enough for a tree below the patch
  };
  struct LevelErrors;

  void evaluate_level(const SurfaceMeasure& measure, const CurveTree& nodes, std::vector<Record>& records,
                      LevelErrors& errors, const CancelToken& cancel) const;

  template <class Visit>
  void visit_below(std::size_t patch, const PatchNode& node, const Visit& visit) const {
    if (is_leaf(patch, node)) {
      visit(node);
      return;
    }
    std::array<PatchNode, 9> below;
    const std::size_t count = children(patch, node, below);
    for (std::size_t k = 0; k < count; ++k) visit_below(patch, below[k], visit);
  }

  const FrameTable& table_;
  int deepest_ = 0;
  double leaf_mass_ = 0;
  CurveTree patches_;
  std::vector<Record> records_;
  std::vector<double> cumulative_;
  double area_ = 0;
  std::uint64_t unresolved_ = 0;
};

}  // namespace meander
