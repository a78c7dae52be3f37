// A picture of a solid surface with its samples painted on it.
#pragma once

#include <cstdint>
#include <span>

#include "kernels/data/rgb_image.h"
#include "kernels/render/surface_picture.h"

namespace meander {

struct SampledSurface {
  std::span<const double> positions;     // 3 V vertices
  std::span<const std::uint32_t> faces;  // 3 T
  std::span<const double> points;        // 3 n samples, in the units of the vertices
  std::span<const float> normals;        // 3 n unit vectors
  std::span<const SrgbColor> colors;     // n, or one for all
  std::span<const double> radii;         // n of the discs, in the units of the vertices, or one for all
  std::span<const double> lines{};       // 6 L: ends of lines on the surface, dark blue, above the discs
};

// surface_picture with a disc in the tangent plane of every sample. Samples that are not finite are left out.
// Throws std::invalid_argument when the numbers do not fit, and what surface_picture throws.
RgbImage sampled_surface_picture(const SampledSurface& sampled,
                                 const SurfacePictureParameters& parameters = {});

}  // namespace meander
