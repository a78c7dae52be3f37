// Point sets on the unit sphere by the methods that samplings are compared with (docs/METHODS.md 14).
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

#include "kernels/pointset/plain_points.h"

namespace meander {

enum class SphereMethod : std::uint8_t {
  random,              // independent
  fibonacci,           // angle i / golden ratio, z = 1 - (2 i + 1) / N; deterministic
  spiral,              // generalized spiral (Saff and Kuijlaars 1997), pole to pole; deterministic
  hammersley,          // the planar set lifted (lift_to_sphere); deterministic
  hilbert_stratified,  // lifted
  hilbert_shifted,     // lifted
};
inline constexpr std::array<std::string_view, 6> sphere_method_names = {
    "random", "fibonacci", "spiral", "hammersley", "hilbert-stratified", "hilbert-shifted"};
constexpr std::string_view name_of(SphereMethod method) {
  return sphere_method_names[static_cast<std::size_t>(method)];
}
std::optional<SphereMethod> sphere_method(std::string_view name);
bool is_deterministic(SphereMethod method);

// Pure in (method, count, seed). 20 - 200 ns a point.
SpherePoints sphere_points(SphereMethod method, std::uint32_t count, std::uint64_t seed);

// Lambert's equal-area cylinder map: angle 2 pi x, height 1 - 2 y. Any planar set becomes one on the sphere.
SpherePoints lift_to_sphere(const PlanarPoints& points);

}  // namespace meander
