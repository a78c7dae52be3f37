// Internal to kernels/render: the light that all pictures of models share.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "kernels/core/vector3.h"

namespace meander {

inline constexpr float empty_depth = -std::numeric_limits<float>::infinity();  // pixels without a surface

inline Vector3 unit_vector(Vector3 v) { return (1 / norm(v)) * v; }

// Light on a unit normal in the camera's frame (rows run downwards) that faces the eye: a key light from the
// upper left, a weak one from below right, and what the sky gives.
float light_on(Vector3 normal);

// What lies behind its surroundings is darkened (creases, contact), in place, by unsharp masking the depth
// buffer (Luft, Colditz, Deussen 2006). depth, light: height x width; `background`: depth that empty pixels
// count as.
void darken_hollows(const std::vector<float>& depth, std::vector<float>& light, std::int64_t width,
                    std::int64_t height, float background);

// Linear light to an sRGB byte, and back.
std::uint8_t srgb_byte(float linear);
float linear_light(std::uint8_t byte);

}  // namespace meander
