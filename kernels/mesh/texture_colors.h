// Colors of samples from the images on a surface.
#pragma once

#include <array>

#include "kernels/data/samples.h"
#include "kernels/mesh/polygon_corners.h"
#include "kernels/mesh/surface_textures.h"

namespace meander {

// The light of a value as displayed, both in [0, 1]: the inverse transfer function of sRGB (IEC 61966-2-1).
double linear_light(double value);

// The color that a texture shows at coordinates (u, v), as displayed or, with `linear`, in linear light, in
// which it is then interpolated too. NaN where its image is lost or the coordinates are not finite. O(1).
std::array<double, 3> texture_color(const SurfaceTextures& textures, const Texture& texture, double u,
                                    double v, bool linear);

// Colors of the samples of one mesh. It keeps the sorted corners of polygons with many of them.
class SampleTextures {
 public:
  // The mesh must outlive the object.
  explicit SampleTextures(const PolygonMesh& mesh) : mesh_(mesh), corners_(mesh) {}

  // Whether the polygon of sample i has a texture.
  bool has(const Samples& samples, std::size_t i) const;
  // The color of the texture at sample i, which must have one. Texture coordinates are those of the corners
  // of the polygon, interpolated linearly in the triangle of the sample; where several corners share a
  // vertex, the first one counts. NaN where a corner has none, or as texture_color. O(1), for polygons with
  // many corners O(log corners) after one O(corners log corners).
  std::array<double, 3> color(const Samples& samples, std::size_t i);

 private:
  std::uint32_t coordinate_of(std::uint32_t face, std::uint32_t vertex);

  const PolygonMesh& mesh_;
  PolygonCorners corners_;
};

}  // namespace meander
