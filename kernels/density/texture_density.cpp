#include "kernels/density/texture_density.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>

#include "kernels/core/parallel.h"
#include "kernels/core/portable_functions.h"
#include "kernels/density/density_pieces.h"
#include "kernels/mesh/surface_textures.h"
#include "kernels/mesh/texture_colors.h"

namespace meander {

namespace {

// The light of a displayed value. linear_light itself is too slow for every pixel of an image.
double light_from_table(double value) {
  constexpr std::size_t steps = 4096;
  static const std::array<double, steps + 2> light = [] {
    std::array<double, steps + 2> values{};
    for (std::size_t k = 0; k < values.size(); ++k)
      values[k] = linear_light(std::min(1.0, static_cast<double>(k) / steps));
    return values;
  }();
  const double at = std::clamp(value, 0.0, 1.0) * steps;
  const auto below = static_cast<std::size_t>(at);
  return light[below] + (at - static_cast<double>(below)) * (light[below + 1] - light[below]);
}

// What one triangle shows.
struct TexturedTriangle {
  const Texture* texture;
  std::array<double, 3> u, v;    // texture coordinates of its corners
  std::array<double, 3> factor;  // of its material
};

class TextureLight {
 public:
  TextureLight(const PolygonMesh& file, const PreparedMesh& mesh, const DensityParameters& parameters)
      : file_(file), mesh_(mesh), parameters_(parameters), textures_(file.colors.textures.get()) {}

  std::optional<TexturedTriangle> find(std::size_t t) const {
    if (textures_ == nullptr || !(mesh_.area[t] > 0)) return std::nullopt;
    const std::uint32_t face = mesh_.polygon[t];
    if (face >= textures_->face.size() || textures_->face[face] >= textures_->textures.size())
      return std::nullopt;
    TexturedTriangle found{&textures_->textures[textures_->face[face]], {}, {}, {1, 1, 1}};
    const std::uint32_t image = found.texture->image;
    if (image >= textures_->images.size() || textures_->images[image].is_lost()) return std::nullopt;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t slot = mesh_.corner_slot[3 * t + k];
      if (slot >= textures_->corner.size()) return std::nullopt;
      const std::size_t at = std::size_t{2} * textures_->corner[slot];
      if (at + 2 > textures_->coordinates.size()) return std::nullopt;
      found.u[k] = textures_->coordinates[at];
      found.v[k] = textures_->coordinates[at + 1];
      if (!std::isfinite(found.u[k]) || !std::isfinite(found.v[k])) return std::nullopt;
    }
    const std::size_t color = std::size_t{3} * face;
    for (std::size_t c = 0; c < 3 && color + 3 <= file_.colors.face.size(); ++c)
      if (std::isfinite(file_.colors.face[color + c])) found.factor[c] = file_.colors.face[color + c];
    return found;
  }

  // How many pixels it covers, at least as many as its longest edge crosses.
  double pixels(const TexturedTriangle& triangle) const {
    const ColorImage& image = textures_->images[triangle.texture->image];
    const std::array<double, 6>& m = triangle.texture->placement;
    std::array<double, 3> x, y;
    for (std::size_t k = 0; k < 3; ++k) {
      x[k] = (m[0] * triangle.u[k] + m[1] * triangle.v[k]) * image.width;
      y[k] = (m[3] * triangle.u[k] + m[4] * triangle.v[k]) * image.height;
    }
    double most = std::abs((x[1] - x[0]) * (y[2] - y[0]) - (x[2] - x[0]) * (y[1] - y[0])) / 2;
    for (std::size_t k = 0; k < 3; ++k)
      most = std::max(most, portable::hypot(x[(k + 1) % 3] - x[k], y[(k + 1) % 3] - y[k]));
    return most;
  }

  double density(const TexturedTriangle& triangle, const std::array<double, 2>& weights) const {
    const auto [b1, b2] = weights;
    const double b0 = 1 - b1 - b2;
    const bool linear = file_.colors.linear;
    const std::array<double, 3> color = texture_color(
        *textures_, *triangle.texture, b0 * triangle.u[0] + b1 * triangle.u[1] + b2 * triangle.u[2],
        b0 * triangle.v[0] + b1 * triangle.v[1] + b2 * triangle.v[2], linear);
    constexpr std::array<double, 3> share = {0.2126, 0.7152, 0.0722};
    double light = 0;
    for (std::size_t c = 0; c < 3; ++c) {
      const double value = color[c] * triangle.factor[c];
      if (!std::isfinite(value)) return 1;  // coordinates that the placement carries out of range
      light += share[c] * (linear ? std::clamp(value, 0.0, 1.0) : light_from_table(value));
    }
    if (parameters_.kind == DensityKind::texture_inverse) light = std::max(0.0, 1 - light);
    if (parameters_.exponent != 1) light = portable::pow(light, parameters_.exponent);
    return parameters_.floor + (1 - parameters_.floor) * std::min(1.0, light);
  }

 private:
  const PolygonMesh& file_;
  const PreparedMesh& mesh_;
  const DensityParameters& parameters_;
  const SurfaceTextures* textures_;
};

}  // namespace

Density make_texture_density(const PolygonMesh& file, const PreparedMesh& mesh,
                             const DensityParameters& parameters, const CancelToken& cancel) {
  const TextureLight light(file, mesh, parameters);
  const std::size_t count = mesh.triangle_count(), block = std::clamp<std::size_t>(count / 64, 1, 4096);
  std::vector<std::uint8_t> level(count, no_pixels);
  parallel_blocks(count, block, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t)
      if (const auto triangle = light.find(t)) level[t] = pixel_level(light.pixels(*triangle));
  });
  const auto values = [&](std::size_t t, std::span<const std::array<double, 2>> weight,
                          std::span<double> value) {
    const auto triangle = light.find(t);
    for (std::size_t k = 0; k < weight.size(); ++k) value[k] = light.density(*triangle, weight[k]);
  };
  Density density = density_in_pieces(mesh, level, values, cancel);
  // As large as any light: what is drawn again does not depend on the brightest pixel.
  for (std::size_t t = 0; t < count && density.in_pieces(); ++t)
    density.piece_mean[density.piece_begin[t]] = 1;
  return density;
}

}  // namespace meander
