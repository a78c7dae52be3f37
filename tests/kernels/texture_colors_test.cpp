// Images on surfaces: single pixels, wrap modes, filters, and the corners of polygons.
#include "kernels/mesh/texture_colors.h"

#include <cmath>

#include "kernels/sample/sample_colors.h"
#include "support/catch.h"

using namespace meander;

namespace {

// Columns red 0, 80, 160, 240, rows green 10, 110, 210; no blue.
SurfaceTextures four_by_three() {
  SurfaceTextures textures;
  ColorImage image;
  image.width = 4;
  image.height = 3;
  for (int y = 0; y < 3; ++y)
    for (int x = 0; x < 4; ++x)
      for (const int value : {80 * x, 10 + 100 * y, 0}) image.rgb.push_back(static_cast<std::uint8_t>(value));
  textures.images.push_back(std::move(image));
  return textures;
}

Texture texture_of(TextureWrap wrap, bool nearest) {
  Texture texture;
  texture.image = 0;
  texture.wrap_u = texture.wrap_v = wrap;
  texture.nearest = nearest;
  return texture;
}

double red(const SurfaceTextures& textures, const Texture& texture, double u) {
  return 255 * texture_color(textures, texture, u, .5, false)[0];
}

}  // namespace

TEST_CASE("texture_color: the nearest pixel, inside and beyond the edges") {
  const SurfaceTextures textures = four_by_three();
  const auto column = [&](TextureWrap wrap, double u) {
    return static_cast<int>(std::lround(red(textures, texture_of(wrap, true), u) / 80));
  };
  for (int k = -40; k < 40; ++k) {
    const double u = (k + .3) / 4;
    INFO(k);
    CHECK(column(TextureWrap::repeat, u) == ((k % 4) + 4) % 4);
    CHECK(column(TextureWrap::clamp, u) == std::clamp(k, 0, 3));
    const int m = ((k % 8) + 8) % 8;
    CHECK(column(TextureWrap::mirror, u) == (m < 4 ? m : 7 - m));
  }
  for (const TextureWrap wrap : {TextureWrap::repeat, TextureWrap::mirror, TextureWrap::clamp})
    for (const double u : {0., 1., -1e-300, 2., 1e300, -1e300, 4e9, -4e9, std::nextafter(1., 0.), -1.}) {
      const int found = column(wrap, u);
      CHECK((found >= 0 && found <= 3));
    }
  const Texture nearest = texture_of(TextureWrap::repeat, true);
  const auto at = texture_color(textures, nearest, .6, .9, false);
  CHECK(255 * at[0] == Approx(160));
  CHECK(255 * at[1] == Approx(210));
}

TEST_CASE("texture_color: bilinear between pixel centers, and across the edge by wrap mode") {
  const SurfaceTextures textures = four_by_three();
  for (const TextureWrap wrap : {TextureWrap::repeat, TextureWrap::mirror, TextureWrap::clamp}) {
    const Texture texture = texture_of(wrap, false);
    CHECK(red(textures, texture, .125) == Approx(0).margin(1e-9));
    CHECK(red(textures, texture, .375) == Approx(80));
    CHECK(red(textures, texture, .4375) == Approx(100));
    CHECK(red(textures, texture, .875) == Approx(240));
    CHECK(255 * texture_color(textures, texture, .5, .5, false)[1] == Approx(110));
    CHECK(255 * texture_color(textures, texture, .5, .25, false)[1] == Approx(35));
  }
  CHECK(red(textures, texture_of(TextureWrap::repeat, false), 0) == Approx(120));
  CHECK(red(textures, texture_of(TextureWrap::repeat, false), 1) == Approx(120));
  CHECK(red(textures, texture_of(TextureWrap::repeat, false), 7.9375) == Approx(180));
  CHECK(red(textures, texture_of(TextureWrap::mirror, false), 1) == Approx(240));
  CHECK(red(textures, texture_of(TextureWrap::mirror, false), 2) == Approx(0).margin(1e-9));
  CHECK(red(textures, texture_of(TextureWrap::mirror, false), 1.3125) == Approx(180));
  CHECK(red(textures, texture_of(TextureWrap::clamp, false), 1.3) == Approx(240));
  CHECK(red(textures, texture_of(TextureWrap::clamp, false), -9) == Approx(0).margin(1e-9));
}

TEST_CASE("texture_color: a texture transform, a value range, and an image of one pixel") {
  SurfaceTextures textures = four_by_three();
  Texture texture = texture_of(TextureWrap::repeat, true);
  texture.placement = {0, 1, .25, -1, 0, 1};  // u' = v + 1/4, v' = 1 - u
  const auto at = texture_color(textures, texture, .1, .4, false);
  CHECK(255 * at[0] == Approx(160));
  CHECK(255 * at[1] == Approx(210));
  texture.base = .5;
  texture.gain = .25;
  CHECK(texture_color(textures, texture, .1, .4, false)[0] == Approx(.5 + .25 * 160 / 255));
  textures.images[0] = {1, 1, {9, 8, 7}, {}};
  for (const bool nearest : {true, false})
    for (const TextureWrap wrap : {TextureWrap::repeat, TextureWrap::mirror, TextureWrap::clamp})
      CHECK(red(textures, texture_of(wrap, nearest), 3.7) == Approx(9));
}

TEST_CASE("texture_color: interpolates in linear light, and pixel values are reproduced") {
  for (int value = 0; value < 256; ++value) {
    const double x = value / 255.0;
    const double expected = x <= 0.04045 ? x / 12.92 : std::pow((x + 0.055) / 1.055, 2.4);
    CHECK(linear_light(x) == Approx(expected).margin(1e-14));
  }
  const SurfaceTextures textures = four_by_three();
  const double between = texture_color(textures, texture_of(TextureWrap::clamp, false), .5, .5, true)[0];
  CHECK(between == Approx(.5 * (linear_light(80 / 255.) + linear_light(160 / 255.))));
}

TEST_CASE("texture_color: lost images and non-finite coordinates have no color") {
  SurfaceTextures textures = four_by_three();
  Texture texture = texture_of(TextureWrap::repeat, false);
  CHECK(std::isnan(texture_color(textures, texture, NAN, 0, false)[0]));
  CHECK(std::isnan(texture_color(textures, texture, 0, INFINITY, true)[0]));
  texture.image = no_index;
  CHECK(std::isnan(texture_color(textures, texture, 0, 0, false)[0]));
  texture.image = 0;
  textures.images[0].rgb.clear();
  CHECK(std::isnan(texture_color(textures, texture, 0, 0, false)[0]));
}

namespace {

// A polygon of n corners, vertex n - 1 - k at corner k, whose coordinates are the angle of the corner.
PolygonMesh fan(std::uint32_t n, bool linear) {
  PolygonMesh mesh;
  mesh.x.resize(n);
  mesh.y.resize(n);
  mesh.z.resize(n);
  mesh.polygon_begin = {0, n};
  auto textures = std::make_shared<SurfaceTextures>(four_by_three());
  textures->textures.push_back(texture_of(TextureWrap::clamp, true));
  textures->face = {0};
  for (std::uint32_t k = 0; k < n; ++k) {
    mesh.corners.push_back(n - 1 - k);
    textures->corner.push_back(k);
    textures->coordinates.insert(textures->coordinates.end(),
                                 {(static_cast<float>(k) + .5f) / static_cast<float>(n), .5f});
  }
  mesh.colors.textures = textures;
  mesh.colors.linear = linear;
  return mesh;
}

Samples sample_at(std::uint32_t a, std::uint32_t b, std::uint32_t c, float b1, float b2) {
  Samples samples;
  samples.points = {0, 0, 0};
  samples.face = {0};
  samples.corners = {a, b, c};
  samples.barycentric = {b1, b2};
  return samples;
}

}  // namespace

TEST_CASE("sample_colors: texture coordinates are those of the polygon's corners, however many it has") {
  for (const std::uint32_t n : {3u, 32u, 33u, 1000u}) {
    const PolygonMesh mesh = fan(n, false);
    for (std::uint32_t v = 0; v < n; v += 1 + n / 100) {
      const double u = (n - 1 - v + .5) / n;
      const SampleColors made = sample_colors(mesh, sample_at(0, v, n - 1, 1, 0));
      INFO(n << " corners, vertex " << v);
      CHECK(made.source == ColorSource::texture);
      CHECK(made.rgb[0] == 80 * static_cast<int>(4 * u));
    }
  }
}

TEST_CASE("sample_colors: factors, vertex colors and lost images beside a texture") {
  PolygonMesh mesh = fan(3, false);
  const Samples middle = sample_at(0, 1, 2, 1, 0);
  mesh.colors.face = {.5f, 1, 1};
  mesh.colors.of_materials = true;
  CHECK(sample_colors(mesh, middle).rgb == std::vector<std::uint8_t>{80, 110, 0});
  mesh.colors.vertex = {0, 0, 1, 0, 0, 1, 0, 0, 1};
  CHECK(sample_colors(mesh, middle).rgb == std::vector<std::uint8_t>{80, 110, 0});

  // In linear light the product of all three.
  PolygonMesh linear = fan(3, true);
  CHECK(sample_colors(linear, middle).rgb == std::vector<std::uint8_t>{160, 110, 0});
  linear.colors.vertex = {1, .5f, 1, 1, .5f, 1, 1, .5f, 1};
  linear.colors.face = {0, 1, 1};
  const SampleColors product = sample_colors(linear, middle);
  CHECK(product.rgb[0] == 0);
  CHECK(linear_light(product.rgb[1] / 255.) == Approx(.5 * linear_light(110 / 255.)).margin(.003));

  // A lost image is not hidden by the factor or, of glTF, by vertices that it is multiplied by.
  auto lost = std::make_shared<SurfaceTextures>(*mesh.colors.textures);
  lost->images[0].rgb.clear();
  mesh.colors.textures = linear.colors.textures = lost;
  const SampleColors vertices = sample_colors(mesh, middle);
  CHECK(vertices.source == ColorSource::vertex);
  CHECK(vertices.rgb == std::vector<std::uint8_t>{0, 0, 255});
  CHECK(sample_colors(linear, middle).fills == 1);
  mesh.colors.vertex.clear();
  CHECK(sample_colors(mesh, middle).fills == 1);
  CHECK(sample_colors(mesh, middle).rgb == std::vector<std::uint8_t>{204, 204, 204});
  // Nor do corners without coordinates show any pixel.
  PolygonMesh bare = fan(3, true);
  auto without = std::make_shared<SurfaceTextures>(*bare.colors.textures);
  without->corner[1] = no_index;
  bare.colors.textures = without;
  CHECK(sample_colors(bare, middle).fills == 1);
}
