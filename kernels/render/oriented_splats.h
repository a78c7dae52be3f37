// A picture of oriented splats: ellipses in tangent planes that together look like the surface.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "kernels/core/vector3.h"
#include "kernels/data/rgb_image.h"
#include "kernels/render/picture_camera.h"

namespace meander {

// Orthographic: from the model to pixels, x to the right, y down, z towards the eye, all in pixels.
struct SplatView : PictureAxes {
  Vector3 center{};  // model point in the middle of the picture
  double scale = 1;  // pixels per unit of the model
  std::uint32_t width = 640, height = 480;

  Vector3 point(Vector3 p) const {
    return scale * direction(p - center) + Vector3{0.5 * width, 0.5 * height, 0};
  }
};

// `towards`: from the model to the eye, not along `up`. All finite points lie within the picture less its
// margin (share of the smaller side); no point gives a view of scale 1. points: 3 n.
SplatView fitted_view(std::span<const float> points, Vector3 towards, Vector3 up, std::uint32_t width,
                      std::uint32_t height, double margin = 0.05);
// The same for a camera that goes round the model about `up`: one scale and center for every direction of the
// elevation of `towards`.
SplatView turning_view(std::span<const float> points, Vector3 towards, Vector3 up, std::uint32_t width,
                       std::uint32_t height, double margin = 0.05);

// n ellipses. Those that are not finite or have no area are left out.
struct OrientedSplats {
  std::span<const float> centers;     // 3 n
  std::span<const float> normals;     // 3 n; outwards, if the surface is closed
  std::span<const float> directions;  // 3 n: of the first half-axis, in the tangent plane; empty: any
  std::span<const float> half_axes;   // 2 n: along and across the direction, in the units of the centers
  std::span<const SrgbColor> colors;  // n, or one for all
};

// The half-axes a >= b of an ellipse of `area` with a / b = ratio >= 1: pi a b = area.
struct HalfAxes {
  double along = 0, across = 0;
};
HalfAxes ellipse_axes(double area, double ratio);

struct SplatLook {
  double shown = 1;  // painted share of the half-axes, (0, 1]; all of it hides samples behind
  // Splats at most this many of their mean half-axes behind the foremost are blended with it, >= 0.
  double thickness = 1;
  bool backs = true;   // also splats whose normals point away from the eye; false: for closed surfaces
  double hollows = 1;  // strength of the darkening of hollows, 0..1
};

struct SplatImage {
  RgbImage image;      // on white
  double covered = 0;  // share of the picture
};

// Visibility, then blending (Zwicker, Pfister, van Baar, Gross 2001; Botsch and Kobbelt 2003): the foremost
// splat decides the depth of a pixel, and those about as near give it colors and normals, weighted by (1 -
// r^2)^2 of the distance r from their centers in half-axes; light is computed on the mean normal. Splats are
// widened by a filter of half a pixel, so that none falls between pixels; 3 x 3 supersampling. Hollows are
// darkened as in splat_picture. Tiles of 32 x 32 pixels are drawn in parallel, splats of a tile in their
// order: the same picture for any number of threads. Throws std::invalid_argument when the sizes do not fit,
// or splats so large that they overlap more than 512 times on the mean (which bounds time and memory: 56
// bytes a splat, 4 a splat and tile, 32 a pixel, 300 KB a thread). O(n + covered pixels).
SplatImage draw_splats(const OrientedSplats& splats, const SplatView& view, const SplatLook& look = {});

// Depth of the nearest triangle at the center of every pixel of the view, height x width; minus infinity
// where there is none. positions: 3 V, in the units of the view; faces: 3 T. Throws std::invalid_argument
// when a face names a vertex that does not exist. O(T + covered pixels).
std::vector<float> surface_depth(std::span<const double> positions, std::span<const std::uint32_t> faces,
                                 const SplatView& view);

// The part of the visible surface that no splat covers: pixels whose center is on the surface (`depth`, of
// surface_depth) but not within a splat that lies at most its longer half-axis before or behind it there.
// Splats are used without the filter of draw_splats. O(n + covered pixels).
struct WhiteSpace {
  std::uint64_t pixels = 0, white = 0;  // of the surface, and of these not covered
  double share() const { return pixels > 0 ? static_cast<double>(white) / static_cast<double>(pixels) : 0.0; }
};
WhiteSpace white_space(const OrientedSplats& splats, const SplatView& view, std::span<const float> depth);

}  // namespace meander
