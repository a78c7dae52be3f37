// Where several holes of a surface at once may have made the side of a point.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "kernels/core/vector3.h"
#include "kernels/mesh/bounds_tree.h"
#include "kernels/query/closing_cones.h"
#include "kernels/query/oriented_surface.h"
#include "kernels/query/triangle_tree.h"
#include "kernels/query/winding_number.h"

namespace meander {

// Near one hole the winding number is a fraction. Near two fractions may add up to a whole number, where
// there is no inside.
class OpenHoles {
 public:
  // A hole may be closed beyond the point as well as on this side of it where its cone has this share of all
  // directions, as seen from the point.
  static constexpr double doubtful_share = 0.15;
  // Of the triangles. A surface with more open edges is not nearly closed, and nothing is looked at.
  static constexpr double max_open_edges = 0.25;

  OpenHoles(const OrientedSurface& oriented, std::size_t triangles);

  // Whether the side that the winding number says stays the same whichever of the doubtful holes around the
  // point are closed beyond it. True where fewer than two may be doubtful: then the number says it all. Some
  // 20 ns there, and up to 2 us for each hole elsewhere.
  bool agree(Vector3 at, double winding) const;

 private:
  struct Own {
    TriangleTree tree;
    WindingTree winding;

    Own(const ClosingCones& cones, std::span<const std::uint32_t> triangles);
    Own(const Own&) = delete;
    Own& operator=(const Own&) = delete;
  };

  std::span<const std::uint32_t> triangles_of(std::size_t h) const;
  Vector3 corner(std::uint32_t v) const { return {cones_.x[v], cones_.y[v], cones_.z[v]}; }
  Vector3 tip(std::size_t h) const { return corner(triangles_of(h)[2]); }
  double reach_of(std::size_t h) const;
  double share_of(std::size_t h, Vector3 at) const;

  ClosingCones cones_;
  std::optional<Own> all_;
  std::vector<std::unique_ptr<Own>> own_;  // of large holes
  std::vector<double> reach_;              // by hole: from farther away it is not doubtful
  BoundsTree near_;                        // of the balls of that radius around the tips
};

// Upper bound of the bytes that it takes, while it is made and later.
constexpr double open_holes_bytes(double triangles) {
  const double cones = OpenHoles::max_open_edges * triangles;
  // All cones, once more those of large holes, each with the least of a tree, and balls.
  constexpr double bytes_per_cone = 500;
  return closing_cones_bytes(cones) + 2 * (triangle_tree_bytes(cones) + winding_tree_bytes(cones)) +
         bytes_per_cone * cones;
}

}  // namespace meander
