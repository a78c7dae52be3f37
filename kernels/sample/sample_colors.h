// Colors of samples from those of the mesh.
#pragma once

#include <cstdint>
#include <vector>

#include "kernels/core/cancel.h"
#include "kernels/data/samples.h"
#include "kernels/mesh/polygon_mesh.h"

namespace meander {

// What a sample without a color gets: a light gray, as viewers show a mesh without colors.
inline constexpr std::uint8_t color_fill = 204;

struct SampleColors {
  std::vector<std::uint8_t> rgb;  // N x 3, 0 .. 255 as displayed (sRGB)
  ColorSource source = ColorSource::none;
  std::uint32_t fills = 0;  // samples that have the fill
};

// The color of the mesh at each sample, which `face`, `corners` and `barycentric` name. Colors of vertices
// are interpolated linearly between the three corners, which are the file's own: two vertices at one place
// keep their two colors. Where a corner has none, the color of the polygon stands in.
// Display colors (SurfaceColors::linear false) are interpolated as stored, as PLY and OBJ viewers do. Linear
// ones of vertex and face are multiplied, a missing one being white, and put through the transfer function of
// sRGB (IEC 61966-2-1). Values are clamped to [0, 1] and
// rounded to the nearest of 256. A sample with neither has color_fill thrice.
// On a polygon with a texture (see SampleTextures) the color of the image goes first, times that of the
// polygon and, of colors in linear light, of the vertices. Where the image or its coordinates are lost, the
// sample has color_fill, but for colors of vertices as displayed, which are colors of their own.
// Throws RunCanceled and ItemError(timeout) by `cancel`. O(N).
SampleColors sample_colors(const PolygonMesh& mesh, const Samples& samples, const CancelToken& cancel = {});

}  // namespace meander
