// Images on a surface: what they show, how they are laid on it, and where each corner lies in them.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "kernels/core/notes.h"
#include "kernels/mesh/polygon_mesh.h"

namespace meander {

// height rows from top to bottom of width pixels from left to right; red, green, blue as displayed (sRGB).
// Of an image that could not be read there are no pixels, and the problem says why.
struct ColorImage {
  std::uint32_t width = 0, height = 0;
  std::vector<std::uint8_t> rgb;  // height x width x 3
  std::string problem;
  Note loss = Note::image_unreadable;  // the kind of the problem; only where there is one
  bool is_lost() const { return rgb.empty(); }
};

// What an image shows beyond its edges.
enum class TextureWrap : std::uint8_t { repeat, mirror, clamp };

// One image, and how texture coordinates lead into it. (u, v) becomes placement . (u, v, 1); then u = 0 is
// the left edge of the image, u = 1 the right one, v = 0 the upper and v = 1 the lower one.
struct Texture {
  std::uint32_t image = no_index;  // in SurfaceTextures::images; no_index: lost
  TextureWrap wrap_u = TextureWrap::repeat, wrap_v = TextureWrap::repeat;
  bool nearest = false;                                  // the pixel itself; otherwise bilinear between four
  std::array<double, 6> placement = {1, 0, 0, 0, 1, 0};  // two rows
  double base = 0, gain = 1;  // the values shown are base + gain x those of the image
};

struct SurfaceTextures {
  std::vector<ColorImage> images;
  std::vector<Texture> textures;
  std::vector<std::uint32_t> face;    // P numbers of textures; no_index: none
  std::vector<float> coordinates;     // 2 per texture coordinate
  std::vector<std::uint32_t> corner;  // K numbers of coordinates; no_index: none
};

}  // namespace meander
