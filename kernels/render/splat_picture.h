// A picture of a sampled model: every sample a small disc on the surface.
#pragma once

#include <cstdint>
#include <span>

#include "kernels/core/vector3.h"
#include "kernels/render/rgb_image.h"

namespace meander {

struct SplatParameters {
  std::uint32_t size = 320;        // pixels, width and height of the picture; 16..8192
  double disc_radius = 0.62;       // of a sample's share of the surface: radius = this x sqrt(area / N). 0.56
                                   // covers a plane once; lower shows gaps and clumps, 0.1..2
  double margin = 0.04;            // empty border, share of the size
  Vector3 view = {0.55, 0.42, 1};  // from the model towards the eye; not vertical
  Vector3 up = {0, 1, 0};          // this direction of the model points up in the picture
};

// Orthographic view of points with depth-tested round discs perpendicular to the normals, lit from both sides
// (normals may point in or out), shaded like flat beads so that each sample can be told from the next, with
// hollows darkened by unsharp masking the depth buffer (Luft, Colditz, Deussen 2006) and fading with depth;
// white background; 3 x 3 supersampling. points, normals: 3 n floats, any units; area: of the surface in
// those units squared (what it is wrong by changes only the size of the discs; 0 or less: a radius from the
// size of the picture). Points that are not finite are left out; no point gives a white picture. O(n r^2 +
// size^2). Pure, deterministic.
RgbImage splat_picture(std::span<const float> points, std::span<const float> normals, double area,
                       const SplatParameters& parameters = {});

}  // namespace meander
