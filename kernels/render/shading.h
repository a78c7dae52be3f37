// Internal to kernels/render: the light that all pictures of models share.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "kernels/core/vector3.h"

namespace meander {

inline constexpr float empty_depth = -std::numeric_limits<float>::infinity();  // pixels without a surface

inline Vector3 unit_vector(Vector3 v) { return (1 / norm(v)) * v; }
inline bool finite_vector(Vector3 v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

// Light on a unit normal in the camera's frame (rows run downwards) that faces the eye: a key light from the
// upper left, a weak one from below right, and what the sky gives.
float light_on(Vector3 normal);

// The mean over squares of 2 reach + 1 pixels, in place; the border repeats. values: height rows of width.
// O(pixels), parallel over lines.
void blur(std::vector<float>& values, std::int64_t width, std::int64_t height, std::int64_t reach);

// How far every pixel lies behind its surroundings, 0..1 and 0 where nothing is (creases, contact): the
// unsharp masked depth buffer of Luft, Colditz, Deussen 2006. depth: height rows of width; `background`:
// depth that empty pixels count as.
std::vector<float> hollowness(const std::vector<float>& depth, std::int64_t width, std::int64_t height,
                              float background);

// Darkens light (height x width, as depth) by that, in place.
void darken_hollows(const std::vector<float>& depth, std::vector<float>& light, std::int64_t width,
                    std::int64_t height, float background);

// Linear light to an sRGB byte, and back.
std::uint8_t srgb_byte(float linear);
float linear_light(std::uint8_t byte);

}  // namespace meander
