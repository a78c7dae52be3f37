#include "kernels/render/sampled_surface.h"

#include <cmath>
#include <stdexcept>
#include <vector>

namespace meander {

RgbImage sampled_surface_picture(const SampledSurface& sampled, const SurfacePictureParameters& parameters) {
  const std::size_t count = sampled.points.size() / 3;
  const auto fits = [&](std::size_t values) { return values == 1 || values == count; };
  if (sampled.normals.size() != 3 * count ||
      (count > 0 && (!fits(sampled.colors.size()) || !fits(sampled.radii.size()))))
    throw std::invalid_argument("normals, colors or radii are not as many as the samples");
  constexpr SrgbColor clay = {226, 224, 219}, ink = {24, 52, 120};
  SurfaceScene scene{sampled.positions, sampled.faces,
                     std::vector<SrgbColor>(sampled.faces.size() / 3, clay)};
  scene.ellipses.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    const Vector3 normal{sampled.normals[3 * i], sampled.normals[3 * i + 1], sampled.normals[3 * i + 2]};
    const Vector3 beside = std::abs(normal.x) < 0.6 ? Vector3{1, 0, 0} : Vector3{0, 1, 0};
    const Vector3 across = cross(normal, beside);
    const double radius = sampled.radii[sampled.radii.size() == 1 ? 0 : i];
    const Vector3 first = radius / norm(across) * across;
    scene.ellipses.push_back({{sampled.points[3 * i], sampled.points[3 * i + 1], sampled.points[3 * i + 2]},
                              first,
                              cross(normal, first),
                              sampled.colors[sampled.colors.size() == 1 ? 0 : i]});
  }
  constexpr double line_width = 2.2;  // pixels
  scene.lines.reserve(sampled.lines.size() / 6);
  for (std::size_t i = 0; i + 5 < sampled.lines.size(); i += 6) {
    const double* const at = sampled.lines.data() + i;
    scene.lines.push_back({{at[0], at[1], at[2]}, {at[3], at[4], at[5]}, line_width, ink});
  }
  return surface_picture(scene, parameters);
}

}  // namespace meander
