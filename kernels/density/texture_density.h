// A density from the light of the textures on a surface.
#pragma once

#include <cstddef>

#include "kernels/density/density.h"

namespace meander {

// The most pieces that the triangles of a mesh are divided into, beside one for each: what a texture of
// 512 x 512 pixels has.
inline constexpr std::size_t most_density_pieces = std::size_t{1} << 18;

// The density is floor + (1 - floor) L^exponent, L the luminance (Rec. 709) in linear light of what the
// texture shows times the factor of its material, in [0, 1]; of texture_inverse of 1 - L. What has no
// texture, an image that is lost, or no texture coordinates has density 1.
//
// It is constant on pieces of the triangles, which are bisected as curve elements are (Density::piece_mean):
// into 16 pieces for each pixel of the image that a triangle covers, or as many fewer on all triangles alike
// as most_density_pieces allows. A piece has the mean over 1 lookup (pieces of up to half a pixel), 4 (up to
// four pixels) or 8 at the centroids of its parts.
//
// A mesh without any such texture is uniform (an empty Density). O(T + pieces). Deterministic for every
// thread count. Throws RunCancelled, timeout.
Density make_texture_density(const PolygonMesh& file, const PreparedMesh& mesh,
                             const DensityParameters& parameters, const CancelToken& cancel = {});

// Upper bound of the bytes that it has.
constexpr double texture_density_bytes(double triangles) {
  return sizeof(double) * 2 * (triangles + static_cast<double>(most_density_pieces)) +
         (sizeof(std::size_t) + 1) * (triangles + 1);
}

}  // namespace meander
