// A picture of a mesh with marks painted on its surface: ellipses, lines and dots.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "kernels/core/vector3.h"
#include "kernels/data/rgb_image.h"
#include "kernels/render/default_view.h"

namespace meander {

// Positions in the units of the mesh. Marks cover the visible part of the surface that lies within them, so
// that they follow its curvature and those behind it are hidden.
struct SurfaceEllipse {
  Vector3 center, first, second;  // half-axes, orthogonal, not zero: in the tangent plane
  SrgbColor color{};
};
struct SurfaceLine {
  Vector3 from, to;
  double width = 2;  // pixels
  SrgbColor color{};
};
struct SurfaceDot {
  Vector3 center;
  double radius = 6;  // pixels, with its white rim
  SrgbColor color{};
};

// Later layers cover earlier ones: faces, ellipses (of two that overlap each keeps what lies nearer to its
// own center, counted in its half-axes), lines (later ones on top), dots.
struct SurfaceScene {
  std::span<const double> positions;     // 3 V
  std::span<const std::uint32_t> faces;  // 3 T
  std::vector<SrgbColor> face_colors;    // T, or empty: pale gray
  std::vector<SurfaceEllipse> ellipses{};
  std::vector<SurfaceLine> lines{};
  std::vector<SurfaceDot> dots{};
};

struct SurfacePictureParameters {
  std::uint32_t size = 800;  // pixels, width and height; 16..4096
  double margin = 0.03;      // empty border, share of the size
  // Corners whose face normal and mean vertex normal have at least this cosine are shaded smoothly.
  double crease = 0.87;
  Vector3 view = default_view;  // from the model towards the eye; not along `up`
  Vector3 up = {0, 1, 0};       // this direction of the model points up in the picture
};

// Orthographic view of the mesh, lit from both sides like splat_picture, hollows darkened; white background;
// 3 x 3 supersampling, 100 MB at size 800. Faces of no area and marks that are not finite are left out; no
// faces give a white picture. Throws std::invalid_argument when a face names a vertex that is not there or
// the number of colors does not fit. O(T + covered pixels). Pure, deterministic.
RgbImage surface_picture(const SurfaceScene& scene, const SurfacePictureParameters& parameters = {});

}  // namespace meander
