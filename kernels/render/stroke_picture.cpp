#include "kernels/render/stroke_picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>
#include <tuple>

#include "kernels/render/depth_picture.h"
#include "kernels/render/seen_samples.h"
#include "kernels/render/shading.h"

namespace meander {

namespace {

StrokePalette palette_of(const StrokePictureParameters& parameters) {
  if (parameters.palette) return *parameters.palette;
  switch (parameters.medium) {
    case StrokeMedium::watercolor:
      return StrokePalette::verdigris;
    case StrokeMedium::crayon:
    case StrokeMedium::acrylic:
      return StrokePalette::terracotta;
    case StrokeMedium::pastel:
      return StrokePalette::slate;
    default:
      return StrokePalette::ochre;
  }
}

double luminance(const LinearColor& c) { return 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2]; }

// Strokes of ground and shadow are not smaller than this, that narrow pictures have no more of them.
constexpr double least_unit = 0.25;

class Planner {
 public:
  Planner(const StrokeModel& model, const StrokePictureParameters& parameters, StrokePlan& plan,
          const LatticeNoise& noise)
      : model_(model),
        parameters_(parameters),
        plan_(plan),
        noise_(noise),
        colors_(palette_colors(palette_of(parameters))),
        key_(picture_key(parameters.seed)),
        depth_(plan.depth) {
    margin_ = std::round(parameters.margin * std::min(parameters.width, parameters.height));
    unit_ = std::min(parameters.width, parameters.height) / 1080.0;
    plan.canvas.width = parameters.width;
    plan.canvas.height = parameters.height;
    plan.canvas.margin = margin_;
    plan.canvas.unit = unit_;
  }

  void run() {
    const std::uint32_t width = parameters_.width, height = parameters_.height;
    view_ = framed_view(model_.positions, parameters_.view, parameters_.up, width, height,
                        margin_ + 0.075 * std::min(width, height));
    depth_ = depth_picture(view_, model_.positions, model_.faces, width, height);
    const Lighting lighting(model_, parameters_, view_);
    const std::vector<SeenSample> seen = seen_samples(model_, view_, depth_, lighting);
    plan_.visible = seen.size();
    measure(seen);
    const std::size_t layers = plan_.style.layers.size();
    plan_.brushes.resize(layers + 3);
    const double spacing = picture_spacing(static_cast<double>(model_.points.size() / 3));
    const double cell = std::max(6.0 * unit_, 2 * spacing);
    const SeenGrid directions(seen, width, height, cell), contours(seen, width, height, cell, true);
    if (plan_.style.background) {
      paint_ground(layers, lighting, 90, 5.5);
      paint_ground(layers + 1, lighting, 46, 1.2);
    }
    paint_shadow(layers + 2, lighting);
    for (std::size_t l = 0; l < layers; ++l)
      paint_layer(l, seen, plan_.style.layers[l].purpose == LayerPurpose::contour ? contours : directions);
  }

 private:
  double random(std::uint64_t index, std::uint32_t layer, std::uint32_t which) const {
    const PhiloxBlock words =
        random_words(key_, Stream::test_shapes, (std::uint64_t{1} << 40) + index, layer);
    return static_cast<double>(words[which]) * 0x1p-32;
  }

  // The area of surface, in pixels where it faces the eye, that a sample stands for: seen samples of these
  // slopes cover the picture.
  void measure(std::span<const SeenSample> seen) {
    double facing = 0, covered = 0;
    for (const SeenSample& sample : seen) facing += sample.normal.z;
    near_ = depth_.far;
    for (const float d : depth_.depth) {
      if (d == empty_depth) continue;
      ++covered;
      near_ = std::max(near_, double{d});
    }
    if (facing > 0) pixels_per_sample_ = covered / facing;
  }

  // Between the samples of the first `count`, in pixels where the surface faces the eye.
  double picture_spacing(double count) const {
    const double all = static_cast<double>(model_.points.size() / 3);
    return std::sqrt(pixels_per_sample_ * all / std::max(1.0, count));
  }

  struct Sizes {
    double width, shortest, longest, spacing;
    std::size_t samples;
  };
  Sizes sizes_of(const StrokeLayer& layer) const {
    const std::size_t all = model_.points.size() / 3;
    Sizes sizes{};
    sizes.samples =
        std::min(all, static_cast<std::size_t>(std::ceil(layer.share * static_cast<double>(all))));
    sizes.spacing = picture_spacing(static_cast<double>(sizes.samples));
    const double side = std::min(parameters_.width, parameters_.height);
    const double length = layer.in_pixels ? unit_ : std::min(sizes.spacing, 0.06 * side);
    double larger = 1;
    if (layer.darkest > 0) {
      // Few samples need larger strokes to be as dark as the layer can be; brushes cover about half.
      const double each = 0.5 * layer.width * std::sqrt(layer.shortest * layer.longest) * length * length;
      const double needed = -std::log(1 - layer.darkest) * sizes.spacing * sizes.spacing / strength(layer);
      larger = std::clamp(std::sqrt(needed / each), 1.0, 3.0);
    }
    sizes.width = std::max(1.3, larger * length * layer.width);
    sizes.shortest = std::max(2.0, larger * length * layer.shortest);
    sizes.longest = std::max(sizes.shortest, std::min(0.3 * side, larger * length * layer.longest));
    return sizes;
  }

  // Direction in the picture and how much the stroke is shortened along and across.
  struct Lie {
    double cosine = 1, sine = 0, along = 1, across = 1;
  };
  Lie lie_of(const SeenSample& sample, LayerPurpose purpose) const {
    Vector3 along = sample.along;
    if (purpose == LayerPurpose::cross) along = cross(sample.normal, sample.along);
    if (purpose == LayerPurpose::contour) along = cross(sample.normal, {0, 0, 1});
    double length = std::hypot(along.x, along.y);
    // Straight at the eye: along the contour instead, or anywhere where the surface faces the eye.
    if (length < 1e-3) {
      along = cross(sample.normal, {0, 0, 1});
      length = std::hypot(along.x, along.y);
      if (length < 1e-6) return {};
    }
    Lie lie{along.x / length, along.y / length, std::min(1.0, length), 1};
    if (purpose == LayerPurpose::contour) lie.along = 1;
    lie.across = std::clamp(sample.normal.z / std::max(lie.along, 0.1), 0.0, 1.0);
    return lie;
  }

  // Painted contours are lost in the light, drawn ones are not. Fewer strokes would leave a line of dashes:
  // they become fainter instead.
  static double contour_strength(const SeenSample& sample, const StrokeLayer& layer) {
    return layer.ink >= 0 ? 1 : std::clamp(1 - 2.6 * sample.light, 0.0, 1.0);
  }

  // Whether the sample has a stroke in the layer: its rank, as a share, is below that of the layer there.
  double asked(const SeenSample& sample, const StrokeLayer& layer, const SeenGrid& around) const {
    const StrokeStyle& style = plan_.style;
    switch (layer.purpose) {
      case LayerPurpose::light:
        return sample.light > 0.6 ? 1.5 * (sample.shine - 0.15) : 0;
      case LayerPurpose::contour:
        return contour_strength(sample, layer) > 0 ? 1.2 * (1 - sample.normal.z / 0.34) : 0;
      case LayerPurpose::detail: {
        // Finer strokes where broad ones miss the light (Hertzmann 1998).
        const double missed = sample.light - around.light(sample.at.x, sample.at.y, sample.light);
        return std::clamp(12 * std::abs(missed) - 0.1, 0.0, 1.0);
      }
      default:
        break;
    }
    if (style.glaze && sample.light > style.unpainted_light)
      return std::max(0.0, 1 - (sample.light - style.unpainted_light) / (0.97 - style.unpainted_light));
    return 1;
  }

  // The part of the darkness that is left to each layer of hatching.
  double darkness(const SeenSample& sample, std::size_t layer) const {
    double left = 1 - std::pow(std::clamp((1 - sample.light - 0.08) / 0.92, 0.0, 1.0), 1.15);
    for (std::size_t l = 0; l < layer; ++l)
      if (plan_.style.layers[l].darkest > 0)
        left /= 1 - std::min(plan_.style.layers[l].darkest, 1 - std::min(left, 1.0));
    return std::min(plan_.style.layers[layer].darkest, 1 - std::min(1.0, left));
  }

  double strength(const StrokeLayer& layer) const {
    const StrokeStyle& style = plan_.style;
    double each = layer.opacity * (style.grain > 0 ? 0.62 : 1);
    if (style.glaze && layer.ink >= 0)
      each *=
          std::log(luminance(style.paper_color) / luminance(style.inks[static_cast<std::size_t>(layer.ink)]));
    return each;
  }

  LinearColor color_of(const SeenSample& sample, const StrokeLayer& layer, double tone, double choice) const {
    if (layer.ink >= 0) return plan_.style.inks[static_cast<std::size_t>(layer.ink)];
    double light = sample.light + layer.tone_jitter * (2 * tone - 1);
    if (layer.purpose == LayerPurpose::light) light = std::max(light, 0.7 + 0.3 * sample.shine);
    if (layer.purpose == LayerPurpose::contour) light = (sample.light > 0.4 ? 0.75 : 0.55) * light;
    if (plan_.style.sticks) {
      // The nearest two colors in turn, as often as each is near.
      const double at = 5 * std::clamp(light, 0.0, 1.0);
      return colors_.stops[std::min<std::size_t>(5, static_cast<std::size_t>(at + choice))];
    }
    light += plan_.style.lift * (1 - light);
    LinearColor mixed = palette_color_at(colors_, light);
    // Broken color: now and then some of the ground's.
    if (!plan_.style.glaze && choice < 0.12)
      for (std::size_t k = 0; k < 3; ++k)
        mixed[k] += 0.22f * (colors_.ground[sample.light > 0.5][k] - mixed[k]);
    return mixed;
  }

  double mean_cover(std::size_t layer, std::size_t length) const {
    double sum = 0;
    for (std::size_t v = 0; v < brush_variations; ++v) sum += plan_.brushes[layer].at(length, v).mean_cover;
    return sum / static_cast<double>(brush_variations);
  }

  // The area that a stroke covers, on average over the variations of its brush.
  double covered_by(const Stroke& stroke, const StrokeLayer& layer, const Sizes& sizes, double across) const {
    return static_cast<double>(stroke.length) * sizes.width * (layer.in_pixels ? 1 : 0.5 + 0.5 * across) *
           mean_cover(stroke.layer, stroke.brush_length);
  }

  // The stroke bends as the directions ahead and behind are turned.
  void bend(Stroke& stroke, const SeenSample& sample, const Lie& lie, const SeenGrid& around) const {
    const double half = 0.4 * static_cast<double>(stroke.length);
    const auto turn = [&](double along) {
      return around.turn(sample.at.x + along * lie.cosine, sample.at.y + along * lie.sine, lie.cosine,
                         lie.sine);
    };
    const double ahead = turn(half), behind = turn(-half), most = 0.9 / (2 * half);
    if (std::abs(ahead) < 0.8 && std::abs(behind) < 0.8)
      stroke.bend = static_cast<float>(std::clamp((ahead - behind) / (2 * half), -most, most));
  }

  // The sample's stroke in layer l, if it has one.
  std::optional<Stroke> stroke_of(const SeenSample& sample, std::size_t l, const Sizes& sizes,
                                  const SeenGrid& around) const {
    const StrokeLayer& layer = plan_.style.layers[l];
    const auto id = static_cast<std::uint32_t>(l);
    const PhiloxBlock words = random_words(key_, Stream::test_shapes, sample.index, id),
                      more = random_words(key_, Stream::test_shapes, sample.index, id + 64);
    const auto share = [](std::uint32_t word) { return static_cast<double>(word) * 0x1p-32; };
    const Lie lie = lie_of(sample, layer.purpose);
    Stroke stroke;
    stroke.sample = sample.index;
    stroke.layer = static_cast<std::uint8_t>(l);
    stroke.brush_length = sample.length;
    stroke.brush_variation = static_cast<std::uint8_t>(words[0] % brush_variations);
    stroke.flips = static_cast<std::uint8_t>(words[0] >> 30);
    stroke.length = static_cast<float>(brush_length(sizes.shortest, sizes.longest, sample.length) *
                                       (0.45 + 0.55 * lie.along));
    stroke.width = static_cast<float>(
        sizes.width * (layer.in_pixels ? 0.85 + 0.3 * share(more[3]) : 0.5 + 0.5 * lie.across));
    const double cell = sizes.spacing * sizes.spacing,
                 own = std::max(1e-9, covered_by(stroke, layer, sizes, lie.across));
    double wanted = asked(sample, layer, around);
    // So many strokes that what they cover, at random, is as dark as it should be.
    if (layer.darkest > 0)
      wanted = -std::log(1 - darkness(sample, l)) * std::max(0.06, sample.normal.z) * cell /
               (own * strength(layer));
    if ((sample.index + 0.5) / static_cast<double>(sizes.samples) >= wanted) return {};
    const double turned = layer.angle_jitter * (2 * share(words[1]) - 1);
    stroke.x = static_cast<float>(sample.at.x);
    stroke.y = static_cast<float>(sample.at.y);
    stroke.cosine = static_cast<float>(lie.cosine * std::cos(turned) - lie.sine * std::sin(turned));
    stroke.sine = static_cast<float>(lie.sine * std::cos(turned) + lie.cosine * std::sin(turned));
    if (layer.purpose != LayerPurpose::cross) bend(stroke, sample, lie, around);
    stroke.color = color_of(sample, layer, share(words[2]), share(words[3]));
    stroke.opacity = static_cast<float>(layer.opacity * (0.85 + 0.3 * share(more[1])));
    if (layer.purpose == LayerPurpose::contour)
      stroke.opacity *= static_cast<float>(contour_strength(sample, layer));
    // Washes that overlap so often give together the density of the layer.
    if (plan_.style.glaze && layer.ink < 0)
      stroke.opacity *= static_cast<float>(std::min(1.0, cell * std::max(0.3, sample.normal.z) / own));
    return stroke;
  }

  void paint_layer(std::size_t l, std::span<const SeenSample> seen, const SeenGrid& around) {
    const Sizes sizes = sizes_of(plan_.style.layers[l]);
    plan_.brushes[l] = make_brushes(plan_.style.brush, sizes.width, sizes.shortest, sizes.longest, noise_);
    struct Ordered {
      std::uint32_t slab, mix;
      Stroke stroke;
    };
    std::vector<Ordered> made;
    for (const SeenSample& sample : seen) {
      if (sample.index >= sizes.samples) break;
      const auto id = static_cast<std::uint32_t>(l + 64);
      if (const std::optional<Stroke> stroke = stroke_of(sample, l, sizes, around))
        made.push_back(
            {slab_of(sample.at.z), random_words(key_, Stream::test_shapes, sample.index, id)[0], *stroke});
    }
    std::sort(made.begin(), made.end(), [](const Ordered& a, const Ordered& b) {
      return std::tie(a.slab, a.mix, a.stroke.sample) < std::tie(b.slab, b.mix, b.stroke.sample);
    });
    for (const Ordered& each : made) plan_.strokes.push_back(each.stroke);
  }

  std::uint32_t slab_of(double depth) const {
    const double extent = std::max(1e-9, near_ - depth_.far);
    return static_cast<std::uint32_t>(std::clamp(16 * (depth - depth_.far) / extent, 0.0, 15.0));
  }

  // Point i of Roberts's additive recurrence in the window, moved a little: any prefix is spread evenly.
  std::array<double, 2> plane_point(std::uint64_t i, std::uint32_t layer, double move) const {
    const double a = 0.5 + 0.7548776662466927 * static_cast<double>(i + 1),
                 b = 0.5 + 0.5698402909980532 * static_cast<double>(i + 1);
    return {margin_ + (a - std::floor(a)) * (parameters_.width - 2 * margin_) +
                move * (random(i, layer + 64, 0) - 0.5),
            margin_ + (b - std::floor(b)) * (parameters_.height - 2 * margin_) +
                move * (random(i, layer + 64, 1) - 0.5)};
  }

  double window_area() const {
    return std::max(0.0, parameters_.width - 2 * margin_) * std::max(0.0, parameters_.height - 2 * margin_);
  }

  // Broad strokes over all, then some smaller ones; darker where the light comes from, so that the lit side
  // of the model stands against dark and its shadow against light.
  void paint_ground(std::size_t brushes, const Lighting& lighting, double width, double cover) {
    width *= std::max(unit_, least_unit);
    const double shortest = 1.6 * width, longest = 4 * width;
    plan_.brushes[brushes] = make_brushes(plan_.style.brush, width, shortest, longest, noise_);
    const auto count = static_cast<std::uint64_t>(cover * window_area() / (width * 2.6 * width));
    const double side = 0.5 * std::min(parameters_.width, parameters_.height);
    const Vector3 towards = lighting.towards();
    const auto layer = static_cast<std::uint32_t>(brushes + 128);
    for (std::uint64_t i = 0; i < count; ++i) {
      const std::array<double, 2> at = plane_point(i, layer, width);
      const double x = (at[0] - 0.5 * parameters_.width) / side,
                   y = (at[1] - 0.5 * parameters_.height) / side;
      const double light = std::clamp(
          0.5 - 0.4 * (x * towards.x + y * towards.y) + 0.14 * (2 * random(i, layer, 0) - 1), 0.0, 1.0);
      const double angle =
          -0.8 + 2.2 * (noise_.at(1.7 * x + 20, 1.7 * y + 40) - 0.5) + 1.3 * (random(i, layer, 1) - 0.5);
      Stroke stroke = plane_stroke(brushes, at, angle, width, random(i, layer, 2), shortest, longest);
      stroke.bend =
          static_cast<float>((random(i, layer, 3) - 0.5) * 0.9 / static_cast<double>(stroke.length));
      for (std::size_t k = 0; k < 3; ++k) {
        const double dark = std::sqrt(colors_.ground[0][k]), bright = std::sqrt(colors_.ground[1][k]);
        const double mixed = dark + light * (bright - dark);
        stroke.color[k] = static_cast<float>(mixed * mixed);
      }
      plan_.strokes.push_back(stroke);
    }
  }

  Stroke plane_stroke(std::size_t brushes, const std::array<double, 2>& at, double angle, double width,
                      double pick, double shortest, double longest) const {
    Stroke stroke;
    const auto choice = static_cast<std::size_t>(pick * (brush_lengths * brush_variations));
    stroke.layer = static_cast<std::uint8_t>(brushes);
    stroke.brush_length = static_cast<std::uint8_t>(choice / brush_variations);
    stroke.brush_variation = static_cast<std::uint8_t>(choice % brush_variations);
    stroke.x = static_cast<float>(at[0]);
    stroke.y = static_cast<float>(at[1]);
    stroke.cosine = static_cast<float>(std::cos(angle));
    stroke.sine = static_cast<float>(std::sin(angle));
    stroke.width = static_cast<float>(width);
    stroke.length = static_cast<float>(brush_length(shortest, longest, stroke.brush_length));
    stroke.opacity = 0.95f;
    return stroke;
  }

  // The shadow that the model casts on the plane it stands on, in level strokes. None where the light comes
  // from below or grazes, or the plane is seen from below or edge-on.
  void paint_shadow(std::size_t brushes, const Lighting& lighting) {
    const Vector3 up = unit_vector(parameters_.up), light = lighting.world();
    if (plan_.visible == 0 || dot(up, light) < 0.25 || dot(up, view_.back) < 0.05) return;
    double floor = std::numeric_limits<double>::infinity();
    std::vector<double> cast(model_.positions.begin(), model_.positions.end());
    const auto height = [&](std::size_t i) { return dot(up, Vector3{cast[i], cast[i + 1], cast[i + 2]}); };
    for (const std::uint32_t v : model_.faces)
      if (std::isfinite(height(3 * std::size_t{v}))) floor = std::min(floor, height(3 * std::size_t{v}));
    for (std::size_t i = 0; i + 2 < cast.size(); i += 3) {
      const double fall = (height(i) - floor) / dot(up, light);
      cast[i] -= fall * light.x;
      cast[i + 1] -= fall * light.y;
      cast[i + 2] -= fall * light.z;
    }
    const DepthPicture shadow =
        depth_picture(view_, cast, model_.faces, parameters_.width, parameters_.height);
    shadow_strokes(brushes, shadow);
  }

  // From 0 where an end of the stroke comes to the margin to 1 an eighth of the smaller side away from it.
  double room_around(const Stroke& stroke) const {
    const double half = 0.5 * static_cast<double>(stroke.length),
                 x = half * std::abs(static_cast<double>(stroke.cosine)),
                 y = half * std::abs(static_cast<double>(stroke.sine));
    const double nearest =
        std::min({static_cast<double>(stroke.x) - x, parameters_.width - static_cast<double>(stroke.x) - x,
                  static_cast<double>(stroke.y) - y, parameters_.height - static_cast<double>(stroke.y) - y});
    return 8 * (nearest - margin_) / std::min(parameters_.width, parameters_.height);
  }

  void shadow_strokes(std::size_t brushes, const DepthPicture& shadow) {
    const StrokeStyle& style = plan_.style;
    const bool lines = style.layers.front().in_pixels;
    // Lines, washes, or strokes that cover.
    const double unit = std::max(unit_, least_unit);
    const double width = unit_ * (lines         ? style.layers.front().width
                                  : style.glaze ? 46
                                                : 30),
                 shortest = unit * (lines         ? 22
                                    : style.glaze ? 110
                                                  : 60),
                 longest = unit * (lines         ? 64
                                   : style.glaze ? 240
                                                 : 150);
    plan_.brushes[brushes] = make_brushes(style.brush, width, shortest, longest, noise_);
    const double wanted = lines ? 0.62 : style.glaze ? 11 : 3.5;
    const auto count =
        static_cast<std::uint64_t>(wanted * window_area() / (0.5 * width * (shortest + longest)));
    const auto layer = static_cast<std::uint32_t>(brushes + 128);
    for (std::uint64_t i = 0; i < count; ++i) {
      const std::array<double, 2> at = plane_point(i, layer, 0.5 * shortest);
      const auto x = static_cast<std::int64_t>(at[0]), y = static_cast<std::int64_t>(at[1]);
      if (!shadow.covered(x, y)) continue;
      // Paint that covers hides what of the shadow lies behind the model, lines and washes do not.
      if (!style.background && depth_.covered(x, y)) continue;
      const double angle = (lines ? 0.06 : 0.2) * (2 * random(i, layer, 1) - 1);
      Stroke stroke = plane_stroke(brushes, at, angle, width, random(i, layer, 2), shortest, longest);
      if (!style.inks.empty()) {
        stroke.color = style.inks[style.inks.size() / 2];
      } else {
        // Cool: between the palette's shadow and the dark ground.
        const auto t = static_cast<float>(0.15 + 0.4 * random(i, layer, 3));
        for (std::size_t k = 0; k < 3; ++k)
          stroke.color[k] = t * colors_.stops[0][k] + (1 - t) * 0.75f * colors_.ground[0][k];
      }
      // On bare paper a shadow ends where the hand stops, before the margin; in a painted ground, with it.
      if (!style.background && random(i, layer, 0) > room_around(stroke)) continue;
      stroke.opacity = lines ? 0.8f : style.glaze ? 0.075f : 0.7f;
      plan_.strokes.push_back(stroke);
    }
  }

  const StrokeModel& model_;
  const StrokePictureParameters& parameters_;
  StrokePlan& plan_;
  const LatticeNoise& noise_;
  PaletteColors colors_;
  RandomKey key_;
  PictureView view_;
  DepthPicture& depth_;
  double margin_ = 0, unit_ = 1, pixels_per_sample_ = 1, near_ = 0;
};

void check_stroke_model(const StrokeModel& model) {
  const std::size_t values = model.points.size();
  if (model.positions.size() % 3 != 0 || model.faces.size() % 3 != 0 || values % 3 != 0 ||
      model.normals.size() != values || model.directions.size() != values ||
      3 * model.spacings.size() != 2 * values)
    throw std::invalid_argument("arrays of strokes do not fit each other");
  for (const std::uint32_t v : model.faces)
    if (v >= model.positions.size() / 3)
      throw std::invalid_argument("a face names a vertex that is not there");
}

}  // namespace

std::vector<std::string> validate(const StrokePictureParameters& parameters) {
  std::vector<std::string> problems;
  if (parameters.many_tones && !has_tones(parameters.medium))
    problems.push_back("several tones are for ink and pencil");
  for (const std::uint32_t side : {parameters.width, parameters.height})
    if (side < 64 || side > 8192)
      problems.push_back("a side of " + std::to_string(side) + " pixels is not in 64..8192");
  if (!(parameters.margin >= 0 && parameters.margin <= 0.3))
    problems.push_back("a margin of " + std::to_string(parameters.margin) + " is not in 0..0.3");
  if (!(norm(cross(parameters.view, parameters.up)) > 1e-6 * norm(parameters.view) * norm(parameters.up)))
    problems.push_back("the view lies along the direction that points up");
  if (!(norm(parameters.light) > 0) || !finite_vector(parameters.light))
    problems.push_back("the light has no direction");
  return problems;
}

StrokePlan plan_strokes(const StrokeModel& model, const StrokePictureParameters& parameters) {
  check_stroke_model(model);
  const std::vector<std::string> problems = validate(parameters);
  if (!problems.empty()) throw std::invalid_argument(problems.front());
  StrokePlan plan;
  plan.style = stroke_style(parameters.medium, parameters.many_tones);
  const LatticeNoise noise(picture_key(parameters.seed));
  Planner(model, parameters, plan, noise).run();
  return plan;
}

RgbImage stroke_picture(const StrokeModel& model, const StrokePictureParameters& parameters) {
  const StrokePlan plan = plan_strokes(model, parameters);
  return paint_strokes(plan.strokes, plan.brushes, plan.style, plan.canvas,
                       LatticeNoise(picture_key(parameters.seed)));
}

std::uint64_t stroke_picture_bytes(std::uint64_t samples, std::uint32_t width, std::uint32_t height) {
  // Eight sets of brushes, no texture larger than 98 x 322 or wider and longer than these shares of the side.
  const double side = std::min(width, height);
  const double texels = std::min(98.0, 0.15 * side + 3) * std::min(322.0, 0.34 * side + 3);
  const double brushes =
      8 * static_cast<double>(brush_lengths * brush_variations) * texels * sizeof(BrushTexel);
  constexpr std::uint64_t shadow_map = std::uint64_t{16} << 20;
  return shadow_map + static_cast<std::uint64_t>(brushes) + std::uint64_t{width} * height * 80 +
         samples * 1500;
}

}  // namespace meander
