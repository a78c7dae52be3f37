#include "kernels/mesh/texture_colors.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace meander {

namespace {

using TexelColor = std::array<double, 3>;
constexpr double no_light = std::numeric_limits<double>::quiet_NaN();
constexpr TexelColor no_texel = {no_light, no_light, no_light};

// The fifth root of y in [0.005, 1], by Newton's iteration from above. The C library's power would differ in
// its last bits between processors.
double fifth_root(double y) {
  double root = 1;
  for (int i = 0; i < 24; ++i) root -= (root - y / (root * root * root * root)) / 5;
  return root;
}

// Wraps a coordinate of any size into [0, 1], or for a mirrored image into [0, 2].
double wrapped_coordinate(double x, TextureWrap wrap) {
  if (wrap == TextureWrap::clamp) return std::clamp(x, 0.0, 1.0);
  return wrap == TextureWrap::repeat ? x - std::floor(x) : x - 2 * std::floor(x / 2);
}

// Wraps a pixel in [-1, 2 size].
std::uint32_t wrapped_pixel(std::int64_t pixel, std::uint32_t size, TextureWrap wrap) {
  const auto count = static_cast<std::int64_t>(size);
  if (wrap == TextureWrap::clamp)
    return static_cast<std::uint32_t>(std::clamp<std::int64_t>(pixel, 0, count - 1));
  const std::int64_t period = wrap == TextureWrap::mirror ? 2 * count : count;
  pixel = (pixel + period) % period;
  return static_cast<std::uint32_t>(pixel < count ? pixel : period - 1 - pixel);
}

struct TexelReader {
  const ColorImage& image;
  const Texture& texture;
  bool linear;

  TexelColor at(std::int64_t x, std::int64_t y) const {
    const std::size_t column = wrapped_pixel(x, image.width, texture.wrap_u),
                      row = wrapped_pixel(y, image.height, texture.wrap_v);
    const std::uint8_t* const rgb = image.rgb.data() + 3 * (row * image.width + column);
    static const std::array<double, 256> light = [] {
      std::array<double, 256> values{};
      for (std::size_t k = 0; k < values.size(); ++k) values[k] = linear_light(static_cast<double>(k) / 255);
      return values;
    }();
    TexelColor color;
    for (std::size_t c = 0; c < 3; ++c) color[c] = linear ? light[rgb[c]] : rgb[c] / 255.0;
    return color;
  }
};

}  // namespace

// x^2.4 = x^2 (x^2)^(1/5).
double linear_light(double value) {
  if (value <= 0.04045) return value / 12.92;
  const double x = (value + 0.055) / 1.055;
  return x * x * fifth_root(x * x);
}

std::array<double, 3> texture_color(const SurfaceTextures& textures, const Texture& texture, double u,
                                    double v, bool linear) {
  if (texture.image >= textures.images.size() || textures.images[texture.image].is_lost()) return no_texel;
  const std::array<double, 6>& m = texture.placement;
  const double x = m[0] * u + m[1] * v + m[2], y = m[3] * u + m[4] * v + m[5];
  if (!std::isfinite(x) || !std::isfinite(y)) return no_texel;
  const ColorImage& image = textures.images[texture.image];
  const TexelReader texels{image, texture, linear};
  const double column = wrapped_coordinate(x, texture.wrap_u) * image.width,
               row = wrapped_coordinate(y, texture.wrap_v) * image.height;
  TexelColor color;
  if (texture.nearest) {
    color =
        texels.at(static_cast<std::int64_t>(std::floor(column)), static_cast<std::int64_t>(std::floor(row)));
  } else {
    // Pixels have their colors at their centers.
    const double left = std::floor(column - 0.5), above = std::floor(row - 0.5);
    const double right_share = column - 0.5 - left, below_share = row - 0.5 - above;
    const auto c = static_cast<std::int64_t>(left), r = static_cast<std::int64_t>(above);
    const std::array<TexelColor, 4> around = {texels.at(c, r), texels.at(c + 1, r), texels.at(c, r + 1),
                                              texels.at(c + 1, r + 1)};
    for (std::size_t k = 0; k < 3; ++k) {
      const double upper = around[0][k] + right_share * (around[1][k] - around[0][k]);
      const double lower = around[2][k] + right_share * (around[3][k] - around[2][k]);
      color[k] = upper + below_share * (lower - upper);
    }
  }
  for (double& value : color) value = texture.base + texture.gain * value;
  return color;
}

bool SampleTextures::has(const Samples& samples, std::size_t i) const {
  const SurfaceTextures* const textures = mesh_.colors.textures.get();
  if (textures == nullptr) return false;
  const std::uint32_t face = samples.face[i];
  return face < textures->face.size() && textures->face[face] < textures->textures.size();
}

std::uint32_t SampleTextures::coordinate_of(std::uint32_t face, std::uint32_t vertex) {
  const std::uint32_t corner = corners_.find(face, vertex);
  const std::vector<std::uint32_t>& coordinates = mesh_.colors.textures->corner;
  return corner < coordinates.size() ? coordinates[corner] : no_index;
}

std::array<double, 3> SampleTextures::color(const Samples& samples, std::size_t i) {
  const SurfaceTextures& textures = *mesh_.colors.textures;
  const std::uint32_t face = samples.face[i];
  const double b1 = samples.barycentric[2 * i], b2 = samples.barycentric[2 * i + 1];
  const std::array<double, 3> weights = {1 - b1 - b2, b1, b2};
  double u = 0, v = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t at = std::size_t{2} * coordinate_of(face, samples.corners[3 * i + k]);
    if (at + 2 > textures.coordinates.size()) return no_texel;
    u += weights[k] * textures.coordinates[at];
    v += weights[k] * textures.coordinates[at + 1];
  }
  return texture_color(textures, textures.textures[textures.face[face]], u, v, mesh_.colors.linear);
}

}  // namespace meander
