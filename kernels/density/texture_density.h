// A density from the light of the textures on a surface.
#pragma once

#include "kernels/density/density.h"

namespace meander {

// The density is floor + (1 - floor) L^exponent, L the luminance (Rec. 709) in linear light of what the
// texture shows times the factor of its material, in [0, 1]; of texture_inverse of 1 - L. What has no
// texture, an image that is lost, or no texture coordinates has density 1.
//
// It is constant on pieces of the triangles (density_in_pieces), whose pixels are those of the images.
//
// A mesh without any such texture is uniform (an empty Density). O(T + pieces). Deterministic for every
// thread count. Throws RunCanceled, timeout.
Density make_texture_density(const PolygonMesh& file, const PreparedMesh& mesh,
                             const DensityParameters& parameters, const CancelToken& cancel = {});

}  // namespace meander
