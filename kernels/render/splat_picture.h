// A picture of a sampled model: every sample a bead on the surface.
#pragma once

#include <cstdint>
#include <span>

#include "kernels/core/vector3.h"
#include "kernels/data/rgb_image.h"
#include "kernels/render/default_view.h"

namespace meander {

struct SplatParameters {
  std::uint32_t size = 320;   // pixels, width and height of the picture; 16..8192
  double bead_radius = 0.33;  // of a sample, in units of sqrt(area / N); 0.05..0.6. 0.5: beads touch
  // The radius of the pale disc below it, in the same unit, that represents the surface and hides parts
  // behind; 0.6 covers a plane once, lower values show gaps; 0..2.
  double disc_radius = 1.0;
  double margin = 0.04;         // empty border, share of the size
  Vector3 view = default_view;  // from the model towards the eye; not vertical
  Vector3 up = {0, 1, 0};       // this direction of the model points up in the picture
};

// Orthographic view of points as depth-tested round beads on pale discs perpendicular to the normals, lit
// from both sides (normals may point in or out), hollows darkened by unsharp masking the depth buffer (Luft,
// Colditz, Deussen 2006), colored by depth; white background; 3 x 3 supersampling. points, normals: 3 n
// floats, any units; area: of the surface in those units squared (an error in it changes only the size of the
// beads; 0 or less, or few samples: a radius from the size of the model). Points that are not finite are left
// out; no point gives a white picture. colors: n of the beads, one for all, or none: by depth. O(n r^2 +
// size^2). Pure, deterministic. Throws std::invalid_argument when the colors do not fit.
RgbImage splat_picture(std::span<const float> points, std::span<const float> normals, double area,
                       const SplatParameters& parameters = {}, std::span<const SrgbColor> colors = {});

}  // namespace meander
