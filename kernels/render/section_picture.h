// A picture of the signed distance from a surface on a plane through it.
#pragma once

#include <cstddef>
#include <cstdint>

#include "kernels/core/cancel.h"
#include "kernels/data/rgb_image.h"
#include "kernels/query/surface_sides.h"

namespace meander {

struct SectionParameters {
  std::size_t axis = 2;      // 0 to 2: the plane is at right angles to it
  double at = 0;             // its place on the axis, working units
  std::uint32_t size = 480;  // pixels, width and height; 16..4096
  double margin = 0.06;      // border around the box of the surface, share of the size
};

// What pixels of which kind are painted in, near the surface.
inline constexpr SrgbColor section_inside = {245, 170, 90}, section_outside = {150, 190, 232},
                           section_uncertain = {190, 20, 130}, section_without_side = {205, 205, 205};

struct Section {
  RgbImage picture;
  double inside = 0, uncertain = 0;  // shares of the pixels
};

// Takes the distance and the side of the middle of each pixel, in bands of distance, a fortieth of the
// picture wide, that darken with it: orange inside, blue outside, gray where the rule is none; uncertain ones
// are hatched in magenta. Black lines are where triangles pass through the plane. x or y runs to the right, y
// or z upwards. mesh: with topology; tree, oriented and rule: its own. Throws std::invalid_argument for other
// parameters; timeout / RunCanceled from `cancel`. O(T), and a nearest triangle and a side for each pixel.
Section section_picture(const PreparedMesh& mesh, const TriangleTree& tree, const OrientedSurface& oriented,
                        SignRule rule, const SectionParameters& parameters, const CancelToken& cancel = {});

// Upper bound of the bytes that it takes beside the mesh, its tree and its orientation.
constexpr double section_picture_bytes(double triangles, double size) {
  const double pixels = size * size;
  return label_points_bytes(triangles, pixels) + 31 * pixels;
}

}  // namespace meander
