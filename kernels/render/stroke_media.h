// The media that strokes are painted in: brush, paper, layers and colors of each.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

namespace meander {

enum class StrokeMedium : std::uint8_t { watercolor, crayon, pencil, ink, acrylic, pastel, oil };
inline constexpr std::array<std::string_view, 7> stroke_medium_names = {
    "watercolor", "crayon", "pencil", "ink", "acrylic", "pastel", "oil"};

enum class StrokePalette : std::uint8_t { terracotta, verdigris, ochre, slate };
inline constexpr std::array<std::string_view, 4> stroke_palette_names = {"terracotta", "verdigris", "ochre",
                                                                         "slate"};

using LinearColor = std::array<float, 3>;  // red, green, blue of sRGB's primaries, linear light

// The mark of a brush on flat paper. Shares are of the length or of half the width.
struct BrushShape {
  double bristles = 0;  // streaks across the width; 0: none
  double streak = 0;    // how much paint the gaps between bristles lack, 0..1
  double ragged = 0;    // how much earlier than the stroke single bristles end, share of the length
  double taper = 0;     // share of the length at each end over which the width falls to nothing
  double soft = 0.2;    // share of the half width over which the edge fades
  double wobble = 0;    // how much the outline and the middle line wander, share of the half width
  double rim = 0;       // more paint along the outline than within, 0..1 (edge darkening)
  double mottle = 0;    // slow variation of the paint within, 0..1
  double ridge = 0;     // height at the edges that the brush pushed paint to, beside 1 for its middle
};

enum class PaperKind : std::uint8_t { smooth, tooth, cold_press, canvas };

enum class LayerPurpose : std::uint8_t {
  underpaint,  // broad, over everything
  body,        // along the primary direction
  detail,      // the same, where the light differs from that around
  cross,       // across it
  light,       // where the light is brightest
  contour      // along the silhouette
};

// One pass over the samples. Lengths and widths are in units of the layer's spacing, sqrt(area of the picture
// of the surface / samples of the layer), or in pixels of a picture 1,080 high where `in_pixels`.
struct StrokeLayer {
  LayerPurpose purpose = LayerPurpose::body;
  double share = 1;  // share of the samples, the first ones, 0..1
  double width = 0.9;
  double shortest = 1.6, longest = 5;  // by the primary spacing: those of the 5 % and the 95 % quantile
  double opacity = 1;
  double angle_jitter = 0.06;  // radians, largest
  double tone_jitter = 0.08;   // of the light, largest
  bool in_pixels = false;
  // Tone by the number of strokes: the darkness that this layer reaches at most, 0: all its samples have
  // strokes.
  double darkest = 0;
  int ink = -1;  // of StrokeStyle::inks; -1: the color of the light there
};

struct StrokeStyle {
  BrushShape brush;
  PaperKind paper = PaperKind::smooth;
  LinearColor paper_color{};
  bool glaze = false;          // strokes multiply the light of what lies below; otherwise they cover it
  double grain = 0;            // how much of a stroke the valleys of the paper stay free of, 0..1
  double granulation = 0;      // glaze: how much more pigment settles in the valleys
  double edge = 0;             // glaze: how much pigment gathers at the edge of a wash
  double wet = 0;              // glaze: how far washes run into one another where the paper is wet, 0..1
  double impasto = 0;          // height of paint, pixels of a picture up to 1,080 high; 0: flat
  double gloss = 0;            // of the light that wet ridges reflect
  bool sticks = false;         // every stroke has one of the palette's colors, unmixed
  bool background = false;     // the ground is painted too
  double lift = 0;             // how much lighter than the light there colors are, 0..1
  double unpainted_light = 2;  // glaze: light from which on the paper shows, thinned by rank
  std::vector<LinearColor> inks{};
  std::vector<StrokeLayer> layers{};  // painted one after the other
};

// From the deepest shadow, cool, to the brightest light, warm; colors of the ground, dark and light.
struct PaletteColors {
  std::array<LinearColor, 6> stops;
  std::array<LinearColor, 2> ground;
};

// `many_tones`: ink and pencil in three tones instead of one (no other medium has them).
bool has_tones(StrokeMedium medium);
StrokeStyle stroke_style(StrokeMedium medium, bool many_tones = false);
PaletteColors palette_colors(StrokePalette palette);
// The value for a light, clamped to [0, 1].
LinearColor palette_color_at(const PaletteColors& palette, double light);

}  // namespace meander
