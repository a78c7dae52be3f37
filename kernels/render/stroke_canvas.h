// Painting strokes: textured quadrilaterals on paper, in order.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "kernels/data/rgb_image.h"
#include "kernels/render/stroke_brushes.h"
#include "kernels/render/stroke_media.h"

namespace meander {

struct Stroke {
  float x = 0, y = 0;           // its middle, pixels
  float cosine = 1, sine = 0;   // of its direction in the picture (y down)
  float length = 0, width = 0;  // pixels
  float bend = 0;               // curvature of its middle line, 1 / pixels; small against 1 / length
  float opacity = 1;            // glaze: its optical density relative to that of its color
  LinearColor color{};
  std::uint32_t sample = 0;  // that it stands for
  std::uint8_t layer = 0;    // its brushes
  std::uint8_t brush_length = 0, brush_variation = 0;
  std::uint8_t flips = 0;  // bit 0: the texture mirrored along, bit 1: across
};

struct StrokeCanvas {
  std::uint32_t width = 0, height = 0;
  double margin = 0;  // pixels that stay paper on each side
  double unit = 1;    // pixels per 1/1080 of the height
};

// Strokes are painted one over the other in the order given, by tiles in parallel; the result does not depend
// on that. style.glaze: densities add up (light is multiplied) and gather at edges and in valleys of the
// paper (Curtis, Anderson, Seims, Fleischer, Salesin 1997); else colors and heights are replaced by the
// share that is covered, and the heights are lit afterwards (Hertzmann 2002). Paper with its relief where
// nothing is painted. O(pixels + covered pixels of all strokes); about 80 bytes a pixel. Throws
// std::invalid_argument for a stroke whose brush is not there. `brushes`: by layer of the strokes.
RgbImage paint_strokes(std::span<const Stroke> strokes, std::span<const BrushSet> brushes,
                       const StrokeStyle& style, const StrokeCanvas& canvas, const LatticeNoise& noise);

}  // namespace meander
