// Images on a surface: their pixels, how they are laid on it, and where each corner lies in them.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "kernels/core/notes.h"
#include "kernels/mesh/polygon_mesh.h"

namespace meander {

// height rows from top to bottom of width pixels from left to right; red, green, blue as displayed (sRGB). An
// image that could not be read has no pixels, and `problem` says why.
struct ColorImage {
  std::uint32_t width = 0, height = 0;
  std::vector<std::uint8_t> rgb;  // height x width x 3
  std::string problem;
  Note loss = Note::image_unreadable;  // the kind of the problem, where there is one
  bool is_lost() const { return rgb.empty(); }
};

// The content beyond the edges of an image.
enum class TextureWrap : std::uint8_t { repeat, mirror, clamp };

// One image, and how texture coordinates lead into it. (u, v) becomes placement . (u, v, 1); then u = 0 is
// the left edge of the image, u = 1 the right one, v = 0 the upper and v = 1 the lower one.
struct Texture {
  std::uint32_t image = no_index;  // in SurfaceTextures::images; no_index: lost
  TextureWrap wrap_u = TextureWrap::repeat, wrap_v = TextureWrap::repeat;
  bool nearest = false;                                  // the nearest pixel; otherwise bilinear
  std::array<double, 6> placement = {1, 0, 0, 0, 1, 0};  // two rows
  double base = 0, gain = 1;                             // values are base + gain x those of the image
};

struct SurfaceTextures {
  std::vector<ColorImage> images;
  std::vector<Texture> textures;
  std::vector<std::uint32_t> face;    // P indices of textures; no_index: none
  std::vector<float> coordinates;     // 2 per texture coordinate
  std::vector<std::uint32_t> corner;  // K indices of coordinates; no_index: none
};

}  // namespace meander
