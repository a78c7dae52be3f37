// Synthesized brushes: the textures of strokes, and the paper below them.
#pragma once

#include <cstdint>
#include <vector>

#include "kernels/core/random.h"
#include "kernels/render/stroke_media.h"

namespace meander {

inline constexpr std::size_t brush_lengths = 10, brush_variations = 5;

// The key of all randomness of a picture. Keyed apart from that of samples, so that its streams are its own.
RandomKey picture_key(std::uint64_t seed);

// Smooth noise in the plane with period 256 in both coordinates: values at whole places are uniform in [0, 1)
// and pure functions of the key, between them interpolated (value noise).
class LatticeNoise {
 public:
  explicit LatticeNoise(RandomKey key);
  float at(double x, double y) const;

 private:
  std::vector<float> values_;
};

struct BrushTexel {
  float cover = 0;   // of the stroke's paint, 0..1; of a brush with a rim up to 1 + rim
  float height = 0;  // of the paint, about 0..1.5
};

// across rows of along texels each. The outermost texels are empty.
struct BrushTexture {
  std::uint32_t along = 0, across = 0;
  std::vector<BrushTexel> texels;
  float mean_cover = 0;
};

// brush_lengths x brush_variations textures, lengths from the shortest (in pixels) to the longest in equal
// ratios, all of one width. Seeded; O(texels).
struct BrushSet {
  std::vector<BrushTexture> textures;  // length by length
  const BrushTexture& at(std::size_t length, std::size_t variation) const {
    return textures[length * brush_variations + variation];
  }
};
// The length of bin k of brush_lengths: shortest (longest / shortest)^(k / 9).
double brush_length(double shortest, double longest, std::size_t bin);
BrushSet make_brushes(const BrushShape& shape, double width, double shortest, double longest,
                      const LatticeNoise& noise);

// The height of the paper at every pixel, 0 (valleys) to 1, row by row. `unit`: pixels of a grain's unit: 1
// in a picture 1,080 high. Parallel over rows.
std::vector<float> paper_heights(PaperKind kind, std::uint32_t width, std::uint32_t height, double unit,
                                 const LatticeNoise& noise);

}  // namespace meander
