// Pictures beside each other, with lines of text under each.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "kernels/render/rgb_image.h"

namespace meander {

struct CaptionedPicture {
  RgbImage image;
  std::string title;               // below the picture, dark; UTF-8
  std::vector<std::string> lines;  // below that, smaller and paler
};

struct PictureRowParameters {
  std::uint32_t gap = 16;  // pixels between pictures and at the border
  double title_size = 20;  // pixels of an em, 4..400
  double line_size = 15;
};

// White background; pictures that are lower than others stand at the top, texts that are wider than their
// picture are made smaller. No picture gives one of size 0 x 0. O(pixels). Throws what
// paint_text throws.
RgbImage picture_row(std::span<const CaptionedPicture> pictures, const PictureRowParameters& parameters = {});

}  // namespace meander
