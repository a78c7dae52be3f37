#include "kernels/sample/sample_colors.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "kernels/mesh/texture_colors.h"

namespace meander {

namespace {

constexpr std::size_t samples_between_checks = 65536;

using Color = std::array<double, 3>;
constexpr double nothing = std::numeric_limits<double>::quiet_NaN();
constexpr Color no_color = {nothing, nothing, nothing};

bool is_color(const Color& color) {
  return std::isfinite(color[0]) && std::isfinite(color[1]) && std::isfinite(color[2]);
}

Color color_at(const std::vector<float>& values, std::size_t number) {
  const std::size_t at = 3 * number;
  if (at + 3 > values.size()) return no_color;
  return {values[at], values[at + 1], values[at + 2]};
}

// Not a number unless all three corners have one.
Color vertex_color(const SurfaceColors& colors, const Samples& samples, std::size_t i) {
  if (colors.vertex.empty()) return no_color;
  const double b1 = samples.barycentric[2 * i], b2 = samples.barycentric[2 * i + 1];
  const std::array<double, 3> weights = {1 - b1 - b2, b1, b2};
  Color sum{};
  for (std::size_t k = 0; k < 3; ++k) {
    const Color corner = color_at(colors.vertex, samples.corners[3 * i + k]);
    for (std::size_t c = 0; c < 3; ++c) sum[c] += weights[k] * corner[c];
  }
  return sum;
}

// The cube root of x in [0.001, 1], by Newton's iteration from above. Not the C library's, whose last bits
// differ between
// processors.
double cube_root(double x) {
  double root = 1;
  for (int i = 0; i < 12; ++i) root -= (root - x / (root * root)) / 3;
  return root;
}

// The transfer function of sRGB; x^(1/2.4) = x^(1/4) x^(1/6).
double displayed(double linear) {
  if (linear <= 0.0031308) return 12.92 * linear;
  return 1.055 * std::sqrt(std::sqrt(linear)) * std::sqrt(cube_root(linear)) - 0.055;
}

std::uint8_t stored(double value) {
  return static_cast<std::uint8_t>(std::lround(255 * std::clamp(value, 0.0, 1.0)));
}

}  // namespace

SampleColors sample_colors(const PolygonMesh& mesh, const Samples& samples, const CancelToken& cancel) {
  const SurfaceColors& colors = mesh.colors;
  const ColorSource of_face = colors.of_materials ? ColorSource::material : ColorSource::face;
  SampleTextures textures(mesh);
  SampleColors made;
  made.rgb.resize(3 * samples.count(), color_fill);
  for (std::size_t i = 0; i < samples.count(); ++i) {
    if (i % samples_between_checks == 0) cancel.check();
    const bool textured = textures.has(samples, i);
    const Color texture = textured ? textures.color(samples, i) : no_color;
    const Color vertex = vertex_color(colors, samples, i), face = color_at(colors.face, samples.face[i]);
    const bool of_texture = is_color(texture), of_vertices = is_color(vertex), has_face = is_color(face);
    // What stands in for a lost image would hide that it is lost, unless it is a color of its own.
    const bool has_color = textured ? of_texture || (of_vertices && !colors.linear) : of_vertices || has_face;
    if (!has_color) {
      ++made.fills;
      continue;
    }
    made.source = std::max(made.source, of_texture    ? ColorSource::texture
                                        : of_vertices ? ColorSource::vertex
                                                      : of_face);
    for (std::size_t c = 0; c < 3; ++c) {
      double value = of_texture ? texture[c] : of_vertices ? vertex[c] : face[c];
      if (of_texture && has_face) value *= face[c];
      if (colors.linear) {
        if (of_texture && of_vertices) value *= vertex[c];
        if (!of_texture && of_vertices && has_face) value *= face[c];
        value = displayed(std::clamp(value, 0.0, 1.0));
      }
      made.rgb[3 * i + c] = stored(value);
    }
  }
  return made;
}

}  // namespace meander
