#include "kernels/render/stroke_media.h"

#include <algorithm>
#include <cmath>

#include "kernels/render/shading.h"

namespace meander {

namespace {

LinearColor linear_color(unsigned rgb) {
  return {linear_light(static_cast<std::uint8_t>(rgb >> 16)),
          linear_light(static_cast<std::uint8_t>(rgb >> 8 & 255)),
          linear_light(static_cast<std::uint8_t>(rgb & 255))};
}

StrokeLayer brush_layer(LayerPurpose purpose, double share, double width, double shortest, double longest) {
  StrokeLayer made;
  made.purpose = purpose;
  made.share = share;
  made.width = width;
  made.shortest = shortest;
  made.longest = longest;
  return made;
}

StrokeLayer hatching_layer(LayerPurpose purpose, double darkest, double width, double shortest,
                           double longest, int ink) {
  StrokeLayer made = brush_layer(purpose, 1, width, shortest, longest);
  made.in_pixels = true;
  made.darkest = darkest;
  made.ink = ink;
  return made;
}

StrokeStyle watercolor() {
  StrokeStyle style;
  style.brush = {.soft = 0.3, .wobble = 0.3, .rim = 0.5, .mottle = 0.35};
  style.paper = PaperKind::cold_press;
  style.paper_color = linear_color(0xfbf8f0);
  style.glaze = true;
  style.granulation = 0.3;
  style.edge = 1.1;
  style.wet = 0.7;
  style.unpainted_light = 0.8;
  style.lift = 0.26;
  StrokeLayer wash = brush_layer(LayerPurpose::underpaint, 0.006, 2.4, 2.4, 4);
  wash.opacity = 0.4;
  StrokeLayer body = brush_layer(LayerPurpose::body, 0.06, 1.5, 2, 5);
  body.opacity = 0.45;
  StrokeLayer detail = brush_layer(LayerPurpose::detail, 0.8, 1.6, 3, 9);
  detail.opacity = 0.6;
  StrokeLayer contour = brush_layer(LayerPurpose::contour, 0.15, 0.6, 4, 8);
  contour.opacity = 0.16;
  style.layers = {wash, body, detail, contour};
  return style;
}

StrokeStyle crayon() {
  StrokeStyle style;
  style.brush = {.bristles = 5,
                 .streak = 0.25,
                 .ragged = 0.06,
                 .taper = 0.06,
                 .soft = 0.5,
                 .wobble = 0.12,
                 .mottle = 0.35};
  style.paper = PaperKind::tooth;
  style.paper_color = linear_color(0xf6f1e6);
  style.grain = 0.62;
  style.sticks = true;
  StrokeLayer ground = brush_layer(LayerPurpose::underpaint, 0.06, 1.1, 3, 6);
  ground.opacity = 0.7;
  StrokeLayer body = brush_layer(LayerPurpose::body, 0.6, 0.9, 4, 11);
  body.opacity = 0.85;
  StrokeLayer contour = brush_layer(LayerPurpose::contour, 0.6, 0.7, 5, 9);
  contour.opacity = 0.75;
  style.layers = {ground, body, contour};
  return style;
}

StrokeStyle pencil(bool many_tones) {
  StrokeStyle style;
  style.brush = {.taper = 0.22, .soft = 0.6, .wobble = 0.15, .mottle = 0.45};
  style.paper = PaperKind::tooth;
  style.paper_color = linear_color(0xf7f4ec);
  style.glaze = true;
  style.grain = 0.6;
  if (many_tones) {
    style.inks = {linear_color(0x8d8d92), linear_color(0x5b5a60), linear_color(0x2b2a2e)};
    style.layers = {hatching_layer(LayerPurpose::body, 0.42, 2.1, 22, 70, 0),
                    hatching_layer(LayerPurpose::cross, 0.4, 2.0, 16, 44, 1),
                    hatching_layer(LayerPurpose::body, 0.6, 1.9, 16, 48, 2),
                    hatching_layer(LayerPurpose::contour, 0, 1.7, 16, 30, 2)};
  } else {
    style.inks = {linear_color(0x4a494e)};
    style.layers = {hatching_layer(LayerPurpose::body, 0.6, 2.3, 20, 64, 0),
                    hatching_layer(LayerPurpose::cross, 0.6, 2.2, 16, 44, 0),
                    hatching_layer(LayerPurpose::contour, 0, 1.7, 16, 30, 0)};
  }
  for (StrokeLayer& each : style.layers) each.opacity = 0.5;  // graphite is gray: darkness is many lines
  return style;
}

StrokeStyle ink(bool many_tones) {
  StrokeStyle style;
  style.brush = {.taper = 0.42, .soft = 0.3, .wobble = 0.2};
  style.paper = PaperKind::smooth;
  style.paper_color = linear_color(0xfaf6ea);
  if (many_tones) {
    style.inks = {linear_color(0x8a6a4c), linear_color(0x4c3a34), linear_color(0x15161c)};
    style.layers = {hatching_layer(LayerPurpose::body, 0.4, 2.0, 16, 52, 0),
                    hatching_layer(LayerPurpose::cross, 0.4, 1.8, 14, 40, 1),
                    hatching_layer(LayerPurpose::body, 0.6, 2.0, 14, 44, 2),
                    hatching_layer(LayerPurpose::contour, 0, 2.4, 18, 34, 2)};
  } else {
    style.inks = {linear_color(0x17181f)};
    style.layers = {hatching_layer(LayerPurpose::body, 0.55, 1.8, 16, 52, 0),
                    hatching_layer(LayerPurpose::cross, 0.6, 1.6, 14, 40, 0),
                    hatching_layer(LayerPurpose::contour, 0, 2.4, 18, 34, 0)};
  }
  for (StrokeLayer& each : style.layers) each.tone_jitter = 0.03;
  return style;
}

StrokeStyle acrylic() {
  StrokeStyle style;
  style.brush = {.bristles = 9,
                 .streak = 0.35,
                 .ragged = 0.12,
                 .taper = 0.03,
                 .soft = 0.1,
                 .wobble = 0.05,
                 .mottle = 0.1,
                 .ridge = 0.5};
  style.paper = PaperKind::canvas;
  style.paper_color = linear_color(0xf1ede4);
  style.impasto = 1.0;
  style.gloss = 0.04;
  style.background = true;
  StrokeLayer ground = brush_layer(LayerPurpose::underpaint, 0.02, 1.8, 2.2, 3.5);
  StrokeLayer body = brush_layer(LayerPurpose::body, 0.12, 1.35, 2, 5);
  body.opacity = 0.95;
  body.tone_jitter = 0.04;
  StrokeLayer detail = brush_layer(LayerPurpose::detail, 0.7, 1.2, 2.5, 6);
  detail.tone_jitter = 0.04;
  StrokeLayer light = brush_layer(LayerPurpose::light, 0.25, 0.9, 2, 4);
  StrokeLayer contour = brush_layer(LayerPurpose::contour, 0.25, 0.5, 4, 7);
  contour.opacity = 0.8;
  style.layers = {ground, body, detail, contour, light};
  return style;
}

StrokeStyle pastel() {
  StrokeStyle style;
  style.brush = {
      .bristles = 4, .streak = 0.2, .ragged = 0.05, .taper = 0.04, .soft = 0.7, .wobble = 0.1, .mottle = 0.3};
  style.paper = PaperKind::tooth;
  style.paper_color = linear_color(0xcdbfa8);
  style.grain = 0.55;
  style.impasto = 0.3;
  style.sticks = true;
  style.background = true;
  StrokeLayer ground = brush_layer(LayerPurpose::underpaint, 0.03, 1.5, 2.5, 5);
  ground.opacity = 0.75;
  StrokeLayer body = brush_layer(LayerPurpose::body, 0.4, 1.0, 2.5, 7);
  body.opacity = 0.8;
  StrokeLayer light = brush_layer(LayerPurpose::light, 0.5, 0.9, 2, 5);
  light.opacity = 0.9;
  StrokeLayer contour = brush_layer(LayerPurpose::contour, 0.4, 0.7, 3, 6);
  contour.opacity = 0.6;
  style.layers = {ground, body, contour, light};
  return style;
}

StrokeStyle oil() {
  StrokeStyle style;
  style.brush = {.bristles = 8,
                 .streak = 0.45,
                 .ragged = 0.16,
                 .taper = 0.05,
                 .soft = 0.14,
                 .wobble = 0.1,
                 .mottle = 0.2,
                 .ridge = 0.7};
  style.paper = PaperKind::canvas;
  style.paper_color = linear_color(0xe6dcc6);
  style.impasto = 2.0;
  style.gloss = 0.10;
  style.background = true;
  StrokeLayer ground = brush_layer(LayerPurpose::underpaint, 0.015, 1.7, 2.2, 4);
  StrokeLayer body = brush_layer(LayerPurpose::body, 0.1, 1.4, 2, 5);
  body.opacity = 0.92;
  body.angle_jitter = 0.12;
  body.tone_jitter = 0.09;
  StrokeLayer detail = brush_layer(LayerPurpose::detail, 0.7, 1.2, 2.2, 6);
  detail.opacity = 0.85;
  detail.tone_jitter = 0.07;
  StrokeLayer light = brush_layer(LayerPurpose::light, 0.3, 1.1, 2, 4);
  StrokeLayer contour = brush_layer(LayerPurpose::contour, 0.25, 0.5, 4, 7);
  contour.opacity = 0.5;
  style.layers = {ground, body, contour, detail, light};
  return style;
}

}  // namespace

bool has_tones(StrokeMedium medium) { return medium == StrokeMedium::pencil || medium == StrokeMedium::ink; }

StrokeStyle stroke_style(StrokeMedium medium, bool many_tones) {
  switch (medium) {
    case StrokeMedium::watercolor:
      return watercolor();
    case StrokeMedium::crayon:
      return crayon();
    case StrokeMedium::pencil:
      return pencil(many_tones);
    case StrokeMedium::ink:
      return ink(many_tones);
    case StrokeMedium::acrylic:
      return acrylic();
    case StrokeMedium::pastel:
      return pastel();
    case StrokeMedium::oil:
      return oil();
  }
  return {};
}

PaletteColors palette_colors(StrokePalette palette) {
  const auto of = [](const std::array<unsigned, 6>& stops, unsigned dark, unsigned light) {
    PaletteColors made;
    for (std::size_t k = 0; k < 6; ++k) made.stops[k] = linear_color(stops[k]);
    made.ground = {linear_color(dark), linear_color(light)};
    return made;
  };
  switch (palette) {
    case StrokePalette::terracotta:
      return of({0x241f3a, 0x54324f, 0x9c4a3c, 0xd07a45, 0xefb878, 0xfdeccb}, 0x4d5a66, 0xa9b5b2);
    case StrokePalette::verdigris:
      return of({0x14213d, 0x1d4a5c, 0x2f7d78, 0x71ab86, 0xc4d69b, 0xfdf3cf}, 0x6b4a3e, 0xd0ac86);
    case StrokePalette::ochre:
      return of({0x2a2438, 0x59433f, 0x8f6a35, 0xc99a41, 0xe9c97c, 0xfff3d2}, 0x39495c, 0x93a6b4);
    case StrokePalette::slate:
      return of({0x191d33, 0x343f63, 0x5f6f8f, 0x98a5b4, 0xd7d5cb, 0xfff6e4}, 0x6e5a48, 0xc9b08d);
  }
  return {};
}

LinearColor palette_color_at(const PaletteColors& palette, double light) {
  const double at = 5 * std::clamp(light, 0.0, 1.0);
  const auto k = std::min<std::size_t>(4, static_cast<std::size_t>(at));
  const auto t = static_cast<float>(at - static_cast<double>(k));
  LinearColor mixed;
  // Even steps to the eye: mixed as square roots of light.
  for (std::size_t c = 0; c < 3; ++c) {
    const float s = (1 - t) * std::sqrt(palette.stops[k][c]) + t * std::sqrt(palette.stops[k + 1][c]);
    mixed[c] = s * s;
  }
  return mixed;
}

}  // namespace meander
