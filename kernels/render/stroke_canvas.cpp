#include "kernels/render/stroke_canvas.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "kernels/core/parallel.h"
#include "kernels/render/shading.h"

namespace meander {

namespace {

constexpr std::int64_t tile_pixels = 64;

// The paint at a pixel: for opaque media its light, for glazes optical densities; and its height.
struct Paint {
  float red = 0, green = 0, blue = 0, height = 0;
};

struct PixelArea {
  std::int64_t x0, y0, x1, y1;  // x1, y1 excluded
  bool empty() const { return x0 >= x1 || y0 >= y1; }
  bool holds(std::int64_t x, std::int64_t y) const { return x >= x0 && x < x1 && y >= y0 && y < y1; }
};

// All but the margin.
PixelArea painted_window(const StrokeCanvas& canvas) {
  const auto margin = static_cast<std::int64_t>(std::lround(canvas.margin));
  return {margin, margin, std::int64_t{canvas.width} - margin, std::int64_t{canvas.height} - margin};
}

PixelArea common_area(const PixelArea& a, const PixelArea& b) {
  return {std::max(a.x0, b.x0), std::max(a.y0, b.y0), std::min(a.x1, b.x1), std::min(a.y1, b.y1)};
}

// Half the extent of a stroke across, with what its bend adds.
float reach_across(const Stroke& stroke) {
  return 0.5f * stroke.width + 0.125f * std::abs(stroke.bend) * stroke.length * stroke.length;
}

PixelArea stroke_bounds(const Stroke& stroke) {
  const float along = 0.5f * stroke.length, across = reach_across(stroke);
  const float half_x = std::abs(stroke.cosine) * along + std::abs(stroke.sine) * across,
              half_y = std::abs(stroke.sine) * along + std::abs(stroke.cosine) * across;
  const auto whole = [](float v) { return static_cast<std::int64_t>(std::clamp(v, -1e8f, 1e8f)); };
  return {whole(std::floor(stroke.x - half_x)), whole(std::floor(stroke.y - half_y)),
          whole(std::ceil(stroke.x + half_x)), whole(std::ceil(stroke.y + half_y))};
}

bool drawable(const Stroke& s) {
  return std::isfinite(s.x + s.y + s.cosine + s.sine + s.length + s.width + s.bend + s.opacity) &&
         s.length > 0 && s.width > 0;
}

// Strokes by the tiles that they may touch, in their order.
class TileLists {
 public:
  TileLists(std::span<const Stroke> strokes, const PixelArea& window, std::int64_t columns, std::int64_t rows)
      : begin_(static_cast<std::size_t>(columns * rows) + 1) {
    const auto each = [&](const auto& take) {
      for (std::size_t s = 0; s < strokes.size(); ++s) {
        if (!drawable(strokes[s])) continue;
        const PixelArea area = common_area(stroke_bounds(strokes[s]), window);
        if (area.empty()) continue;
        for (std::int64_t row = area.y0 / tile_pixels; row <= (area.y1 - 1) / tile_pixels; ++row)
          for (std::int64_t column = area.x0 / tile_pixels; column <= (area.x1 - 1) / tile_pixels; ++column)
            take(static_cast<std::size_t>(row * columns + column), static_cast<std::uint32_t>(s));
      }
    };
    each([&](std::size_t t, std::uint32_t) { ++begin_[t + 1]; });
    for (std::size_t t = 1; t < begin_.size(); ++t) begin_[t] += begin_[t - 1];
    members_.resize(begin_.back());
    std::vector<std::size_t> next(begin_.begin(), begin_.end() - 1);
    each([&](std::size_t t, std::uint32_t s) { members_[next[t]++] = s; });
  }
  std::span<const std::uint32_t> of(std::size_t t) const {
    return std::span(members_).subspan(begin_[t], begin_[t + 1] - begin_[t]);
  }

 private:
  std::vector<std::size_t> begin_;
  std::vector<std::uint32_t> members_;
};

BrushTexel texel_at(const BrushTexture& brush, float u, float v) {
  // The outermost texels are empty and lie outside [0, 1].
  const float x = 0.5f + u * static_cast<float>(brush.along - 2),
              y = 0.5f + v * static_cast<float>(brush.across - 2);
  const auto i = static_cast<std::uint32_t>(x), j = static_cast<std::uint32_t>(y);
  const float s = x - static_cast<float>(i), t = y - static_cast<float>(j);
  const BrushTexel* up = brush.texels.data() + std::size_t{j} * brush.along + i;
  const BrushTexel* down = up + brush.along;
  const auto mix = [&](float a, float b, float c, float d) {
    const float above = a + s * (b - a), below = c + s * (d - c);
    return above + t * (below - above);
  };
  return {mix(up[0].cover, up[1].cover, down[0].cover, down[1].cover),
          mix(up[0].height, up[1].height, down[0].height, down[1].height)};
}

// The columns of a row in which |from + slope x| <= half, cut from [first, last].
void cut_span(float from, float slope, float half, float& first, float& last) {
  if (std::abs(slope) < 1e-6f) {
    if (std::abs(from) > half) last = first - 1;
    return;
  }
  const float a = (-half - from) / slope, b = (half - from) / slope;
  first = std::max(first, std::min(a, b));
  last = std::min(last, std::max(a, b));
}

// Calls paint(x, y, texel) for the pixels of the area that the stroke's texture lies on.
template <class PaintPixel>
void each_pixel(const Stroke& stroke, const BrushTexture& brush, const PixelArea& area,
                const PaintPixel& paint) {
  const float half_length = 0.5f * stroke.length, across = reach_across(stroke);
  const float to_u = 1 / stroke.length, to_v = 1 / stroke.width;
  for (std::int64_t y = area.y0; y < area.y1; ++y) {
    const float dy = static_cast<float>(y) + 0.5f - stroke.y;
    // Along and across at the column 0, measured at the middle of the pixel.
    const float along0 = (0.5f - stroke.x) * stroke.cosine + dy * stroke.sine,
                across0 = dy * stroke.cosine - (0.5f - stroke.x) * stroke.sine;
    float first = static_cast<float>(area.x0), last = static_cast<float>(area.x1 - 1);
    cut_span(along0, stroke.cosine, half_length, first, last);
    cut_span(across0, -stroke.sine, across, first, last);
    if (first > last) continue;
    for (auto x = static_cast<std::int64_t>(std::ceil(first)); x <= static_cast<std::int64_t>(last); ++x) {
      const float along = along0 + static_cast<float>(x) * stroke.cosine;
      const float off = across0 - static_cast<float>(x) * stroke.sine - 0.5f * stroke.bend * along * along;
      float u = 0.5f + along * to_u, v = 0.5f + off * to_v;
      if (!(u >= 0 && u <= 1 && v >= 0 && v <= 1)) continue;
      if (stroke.flips & 1) u = 1 - u;
      if (stroke.flips & 2) v = 1 - v;
      const BrushTexel texel = texel_at(brush, u, v);
      if (texel.cover > 0.002f) paint(x, y, texel);
    }
  }
}

// The share of the paint that paper of height p takes from a dry stick: peaks first, more under more
// pressure.
float taken(float p, float cover, float grain) {
  const float threshold = grain * (0.75f - 0.35f * cover);
  // Valleys get a minimum, which fills them in the end.
  return 0.12f + 0.88f * std::clamp((p - threshold) * 2.2f + 0.5f, 0.0f, 1.0f);
}

class Painter {
 public:
  Painter(std::span<const Stroke> strokes, std::span<const BrushSet> brushes, const StrokeStyle& style,
          const StrokeCanvas& canvas, const std::vector<float>& paper)
      : strokes_(strokes),
        brushes_(brushes),
        style_(style),
        canvas_(canvas),
        window_(painted_window(canvas)),
        paper_(paper) {}

  std::vector<Paint> paint() const {
    std::vector<Paint> picture(std::size_t{canvas_.width} * canvas_.height, bare());
    if (window_.empty()) return picture;
    const std::int64_t columns = (canvas_.width + tile_pixels - 1) / tile_pixels,
                       rows = (canvas_.height + tile_pixels - 1) / tile_pixels;
    const TileLists lists(strokes_, window_, columns, rows);
    parallel_tasks(static_cast<std::size_t>(columns * rows), [&](std::size_t t) {
      const std::int64_t x = static_cast<std::int64_t>(t) % columns * tile_pixels,
                         y = static_cast<std::int64_t>(t) / columns * tile_pixels;
      const PixelArea area = common_area({x, y, x + tile_pixels, y + tile_pixels}, window_);
      for (const std::uint32_t s : lists.of(t)) paint_stroke(strokes_[s], area, picture);
    });
    return picture;
  }

 private:
  Paint bare() const {
    if (style_.glaze) return {};
    return {style_.paper_color[0], style_.paper_color[1], style_.paper_color[2], 0};
  }

  void paint_stroke(const Stroke& stroke, const PixelArea& tile_area, std::vector<Paint>& picture) const {
    const PixelArea area = common_area(stroke_bounds(stroke), tile_area);
    if (area.empty()) return;
    const BrushTexture& brush = brushes_[stroke.layer].at(stroke.brush_length, stroke.brush_variation);
    const auto grain = static_cast<float>(style_.grain);
    if (style_.glaze) {
      std::array<float, 3> density;
      for (std::size_t k = 0; k < 3; ++k)
        density[k] =
            -stroke.opacity * std::log(std::clamp(stroke.color[k] / style_.paper_color[k], 0.004f, 1.0f));
      const auto granulation = static_cast<float>(style_.granulation);
      each_pixel(stroke, brush, area, [&](std::int64_t x, std::int64_t y, const BrushTexel& texel) {
        const std::size_t i = static_cast<std::size_t>(y) * canvas_.width + static_cast<std::size_t>(x);
        float amount = texel.cover * (1 + granulation * (1 - 2 * paper_[i]));
        if (grain > 0) amount *= taken(paper_[i], texel.cover, grain);
        Paint& below = picture[i];
        below.red += amount * density[0];
        below.green += amount * density[1];
        below.blue += amount * density[2];
      });
      return;
    }
    const float thickness = static_cast<float>(style_.impasto * std::max(1.0, canvas_.unit)),
                streak = style_.impasto > 0 ? 0.14f : 0;
    // A hand presses harder in the dark, and fills more of the valleys.
    const float bright = 0.2126f * stroke.color[0] + 0.7152f * stroke.color[1] + 0.0722f * stroke.color[2],
                pressed = style_.sticks ? grain * std::min(1.0f, 0.4f + 1.1f * std::sqrt(bright)) : grain;
    each_pixel(stroke, brush, area, [&](std::int64_t x, std::int64_t y, const BrushTexel& texel) {
      const std::size_t i = static_cast<std::size_t>(y) * canvas_.width + static_cast<std::size_t>(x);
      float cover = std::min(1.0f, stroke.opacity * texel.cover);
      if (pressed > 0) cover *= taken(paper_[i], cover, pressed);
      // Bristles carry a little more or less of the color.
      const float shade = 1 + streak * (texel.height - 0.75f);
      Paint& below = picture[i];
      below.red += cover * (shade * stroke.color[0] - below.red);
      below.green += cover * (shade * stroke.color[1] - below.green);
      below.blue += cover * (shade * stroke.color[2] - below.blue);
      // The brush levels half of the height below it and leaves its own.
      below.height += cover * (thickness * texel.height - 0.55f * below.height);
    });
  }

  std::span<const Stroke> strokes_;
  std::span<const BrushSet> brushes_;
  const StrokeStyle& style_;
  const StrokeCanvas& canvas_;
  const PixelArea window_;
  const std::vector<float>& paper_;
};

// Washes run into one another where the paper is wet, which it is in patches: densities become more like
// those around them. Bare paper stays bare, so that washes keep their outlines.
void run_together(std::vector<Paint>& picture, const StrokeCanvas& canvas, double wet,
                  const LatticeNoise& noise) {
  const auto reach = std::max<std::int64_t>(1, std::lround(4 * canvas.unit));
  const double patch = 1 / (70 * std::max(canvas.unit, 0.1));
  std::vector<float> share(picture.size()), around(picture.size());
  parallel_tasks(canvas.height, [&](std::size_t y) {
    for (std::size_t x = 0; x < canvas.width; ++x) {
      const Paint& own = picture[y * canvas.width + x];
      const float total = own.red + own.green + own.blue;
      if (!(total > 0)) continue;
      const float wetness =
          noise.at(static_cast<double>(x) * patch + 90, static_cast<double>(y) * patch + 130);
      share[y * canvas.width + x] =
          static_cast<float>(wet) * std::min(1.0f, 3 * total) * std::clamp(2.6f * wetness - 0.7f, 0.1f, 1.0f);
    }
  });
  for (float Paint::*const channel : {&Paint::red, &Paint::green, &Paint::blue}) {
    for (std::size_t i = 0; i < around.size(); ++i) around[i] = picture[i].*channel;
    blur(around, canvas.width, canvas.height, reach);
    for (std::size_t i = 0; i < around.size(); ++i)
      picture[i].*channel += share[i] * (around[i] - picture[i].*channel);
  }
}

// Pigment gathers where a wash ends: densities are raised where they exceed those around them.
void darken_edges(std::vector<Paint>& picture, const StrokeCanvas& canvas, double edge) {
  std::vector<float> mean(picture.size());
  for (std::size_t i = 0; i < mean.size(); ++i) mean[i] = picture[i].red + picture[i].green + picture[i].blue;
  blur(mean, canvas.width, canvas.height, std::max<std::int64_t>(1, std::lround(2.5 * canvas.unit)));
  for (std::size_t i = 0; i < mean.size(); ++i) {
    Paint& own = picture[i];
    const float total = own.red + own.green + own.blue;
    const float more =
        static_cast<float>(edge) * std::clamp((total - mean[i]) / (0.35f + total), -0.3f, 0.5f);
    own.red *= 1 + more;
    own.green *= 1 + more;
    own.blue *= 1 + more;
  }
}

// Heights of paper and paint lit from the upper left: the factor of diffuse light, and what ridges reflect.
struct ReliefLight {
  float shade = 1, gloss = 0;
};

class Relief {
 public:
  Relief(const StrokeStyle& style, const StrokeCanvas& canvas, const std::vector<float>& paper,
         const std::vector<Paint>& picture)
      : style_(style), canvas_(canvas), window_(painted_window(canvas)), paper_(paper), picture_(picture) {
    switch (style.paper) {
      case PaperKind::smooth:
        depth_ = 0.08f;
        break;
      case PaperKind::tooth:
        depth_ = 0.16f;
        break;
      case PaperKind::cold_press:
        depth_ = 0.5f;
        break;
      case PaperKind::canvas:
        depth_ = 0.5f;
        break;
    }
    depth_ *= static_cast<float>(std::max(1.0, canvas.unit));
  }

  ReliefLight at(std::size_t x, std::size_t y) const {
    const std::size_t left = x > 0 ? x - 1 : x, right = std::min<std::size_t>(x + 1, canvas_.width - 1),
                      up = y > 0 ? y - 1 : y, down = std::min<std::size_t>(y + 1, canvas_.height - 1);
    const bool painted = window_.holds(static_cast<std::int64_t>(x), static_cast<std::int64_t>(y));
    const float gx = height(right, y, painted) - height(left, y, painted),
                gy = height(x, down, painted) - height(x, up, painted);
    // The light comes from the left and above: slopes that rise away from it face it.
    const float slope = 0.5f * (0.6f * gx + 0.8f * gy);
    ReliefLight light;
    light.shade = 1 + std::clamp(0.42f * slope, -0.3f, 0.26f);
    if (style_.gloss > 0) {
      const float facing = std::clamp(slope - 0.25f, 0.0f, 1.0f);
      light.gloss = static_cast<float>(style_.gloss) * facing;
    }
    return light;
  }

 private:
  // Thick paint fills the paper's valleys. The margin is lit as if there were none.
  float height(std::size_t x, std::size_t y, bool painted) const {
    const std::size_t i = y * canvas_.width + x;
    const float paint = painted ? picture_[i].height : 0;
    return paint + depth_ * paper_[i] / (1 + 1.5f * paint);
  }

  const StrokeStyle& style_;
  const StrokeCanvas& canvas_;
  const PixelArea window_;
  const std::vector<float>& paper_;
  const std::vector<Paint>& picture_;
  float depth_ = 0.1f;
};

}  // namespace

RgbImage paint_strokes(std::span<const Stroke> strokes, std::span<const BrushSet> brushes,
                       const StrokeStyle& style, const StrokeCanvas& canvas, const LatticeNoise& noise) {
  for (const Stroke& stroke : strokes)
    if (stroke.layer >= brushes.size() || stroke.brush_length >= brush_lengths ||
        stroke.brush_variation >= brush_variations || brushes[stroke.layer].textures.empty())
      throw std::invalid_argument("a stroke names a brush that is not there");
  const std::vector<float> paper =
      paper_heights(style.paper, canvas.width, canvas.height, canvas.unit, noise);
  std::vector<Paint> picture = Painter(strokes, brushes, style, canvas, paper).paint();
  if (style.glaze && style.wet > 0) run_together(picture, canvas, style.wet, noise);
  if (style.glaze && style.edge > 0) darken_edges(picture, canvas, style.edge);
  RgbImage image(canvas.width, canvas.height);
  const Relief relief(style, canvas, paper, picture);
  parallel_tasks(canvas.height, [&](std::size_t y) {
    for (std::uint32_t x = 0; x < canvas.width; ++x) {
      const Paint& paint = picture[y * canvas.width + x];
      const ReliefLight light = relief.at(x, y);
      std::array<float, 3> seen = {paint.red, paint.green, paint.blue};
      for (std::size_t k = 0; k < 3; ++k) {
        if (style.glaze) seen[k] = style.paper_color[k] * std::exp(-seen[k]);
        image.pixel(x, static_cast<std::uint32_t>(y))[k] = srgb_byte(light.shade * seen[k] + light.gloss);
      }
    }
  });
  return image;
}

}  // namespace meander
