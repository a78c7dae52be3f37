// The visible part of a mesh: the depth of its nearest surface at every pixel.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "kernels/core/vector3.h"
#include "kernels/render/picture_camera.h"

namespace meander {

// Orthographic: from the model to pixels, x to the right, y down, z towards the eye (in pixels, too).
struct PictureView : PictureAxes {
  Vector3 center{};  // of the model, at the middle of the picture
  double scale = 1, middle_x = 0, middle_y = 0;

  Vector3 point(Vector3 p) const { return scale * direction(p - center) + Vector3{middle_x, middle_y, 0}; }
};

// The view along `view` (from the model towards the eye, not along `up`) in which the points fill a
// width x height picture but for `margin` (pixels) on each side. Points that are not finite are left out.
PictureView framed_view(std::span<const double> points, Vector3 view, Vector3 up, std::uint32_t width,
                        std::uint32_t height, double margin);

// width x height, row by row: depth towards the eye, empty_depth (shading.h) where nothing is.
struct DepthPicture {
  std::uint32_t width = 0, height = 0;
  std::vector<float> depth;
  double far = 0;  // the least depth

  bool covered(std::int64_t x, std::int64_t y) const;
};

// Adds a triangle, corners in pixels and z towards the eye, to a depth buffer of height rows of width. The
// middle of a pixel decides; a triangle of no area adds nothing. O(pixels of its box).
void add_triangle_depth(std::span<float> depth, std::uint32_t width, std::uint32_t height, Vector3 a,
                        Vector3 b, Vector3 c);

// positions: 3 V; faces: 3 T, vertices that are there. The middle of a pixel decides. Faces of no area are
// left out. O(T + covered pixels), serial.
DepthPicture depth_picture(const PictureView& view, std::span<const double> positions,
                           std::span<const std::uint32_t> faces, std::uint32_t width, std::uint32_t height);

}  // namespace meander
