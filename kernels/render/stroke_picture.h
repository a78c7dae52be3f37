// A sampled model painted: every visible sample a brush stroke.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "kernels/core/vector3.h"
#include "kernels/data/rgb_image.h"
#include "kernels/render/default_view.h"
#include "kernels/render/depth_picture.h"
#include "kernels/render/stroke_canvas.h"
#include "kernels/render/stroke_media.h"

namespace meander {

// One unit of length throughout.
struct StrokeModel {
  std::span<const double> positions;     // 3 V vertices
  std::span<const std::uint32_t> faces;  // 3 T: what hides samples, and casts shadows
  std::span<const double> points;        // 3 n samples in progressive order: every prefix is well spread
  std::span<const float> normals;        // 3 n unit vectors
  std::span<const float> directions;     // 3 n unit vectors along the primary spacing
  std::span<const float> spacings;       // 2 n: along and across them; any unit
};

struct StrokePictureParameters {
  StrokeMedium medium = StrokeMedium::oil;
  bool many_tones = false;                    // ink and pencil: three tones
  std::optional<StrokePalette> palette{};     // without it that of the medium
  std::uint32_t width = 1080, height = 1080;  // pixels, 64..8192 each
  double margin = 0.045;                      // unpainted border, share of the smaller side, 0..0.3
  Vector3 view = default_view;                // from the model towards the eye; not along `up`
  Vector3 up = {0, 1, 0};
  Vector3 light = {-0.6, 0.62, 0.5};  // towards the light, as the eye sees it: right, up, towards the eye
  std::uint64_t seed = 1;
};

// Everything wrong with them, one sentence each.
std::vector<std::string> validate(const StrokePictureParameters& parameters);

// Painted in this order: the ground, the cast shadow, then the layers of the style; within a layer from the
// back to the front in 16 slabs of depth, in random order within a slab, so that strokes of nearer parts lie
// on those of farther ones and no direction of painting shows (Meier 1996, "Painterly rendering for
// animation").
struct StrokePlan {
  StrokeStyle style;
  StrokeCanvas canvas;
  std::vector<BrushSet> brushes;  // of the layers of the style, of the ground, of the shadow
  std::vector<Stroke> strokes;    // those of samples have a layer < style.layers.size()
  DepthPicture depth;             // of the mesh, as the picture shows it
  std::size_t visible = 0;        // samples that are seen
};

// A stroke lies along the primary direction of its sample as the picture shows it (contours along the
// silhouette, hatching of deep shadow across), bends with the directions around it, and is as long as the
// primary spacing asks for: one of ten lengths between the 5 % and the 95 % quantile of its logarithm.
// A sample has strokes when its point is seen (a depth buffer of the mesh decides); strokes are not cut at
// the silhouette. Layers take prefixes of the samples (broad underpaint, body, accents at lights and
// contours: Hertzmann 1998, "Painterly rendering with curved brush strokes of multiple sizes"), and where the
// tone comes from the number of strokes each sample has one if its place in the order, as a share, is below
// what the tone there asks for, as textures of Praun, Hoppe, Webb, Finkelstein 2001 nest ("Real-time
// hatching"). Samples and faces that are not finite are left out; no samples give paper. Which samples have
// strokes does not depend on the number of threads; with a prefix of the samples and the same sizes they are
// a part of those of all. Throws std::invalid_argument when arrays do not fit each other, a face names a
// vertex that is not there, or validate() finds a problem. O(T + n + pixels of the mesh).
StrokePlan plan_strokes(const StrokeModel& model, const StrokePictureParameters& parameters);

// The plan painted (paint_strokes). Pure, deterministic; about 100 bytes a pixel and 150 a sample.
RgbImage stroke_picture(const StrokeModel& model, const StrokePictureParameters& parameters);

// Upper bound of the memory of stroke_picture beside its arguments.
std::uint64_t stroke_picture_bytes(std::uint64_t samples, std::uint32_t width, std::uint32_t height);

}  // namespace meander
