// Text in pictures, in the sans-serif font of the system (by cairo).
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "io/plot/color.h"
#include "kernels/data/rgb_image.h"

namespace meander {

struct TextStyle {
  double size = 16;  // pixels of an em, 1..400
  bool bold = false;
  Rgb color{60, 60, 60};
};

enum class TextAlign { left, centre, right };

// Pixels from the start of the text to its end.
double painted_width(std::string_view text, const TextStyle& style);

// Mixes one line of UTF-8 into the picture, `baseline` pixels below its upper edge; `x` is the start, the
// middle or the end of the text. What lies outside the picture is cut off. Bytes that are not UTF-8 appear as
// question marks. Which glyphs appear depends on the fonts of the machine. Throws std::runtime_error with
// cairo's reason.
void paint_text(RgbImage& image, std::string_view text, double x, double baseline, const TextStyle& style,
                TextAlign align = TextAlign::left);

// The text if it fits into `width` pixels, else its end behind an ellipsis: of a path the file says more than
// the folder.
std::string shortened_at_front(std::string_view text, double width, const TextStyle& style);

// Broken between words into lines of at most `width` pixels; of a longer word the end is shown. What does
// not fit into `most` >= 1 lines is left out and the last line ends with an ellipsis.
std::vector<std::string> wrapped_text(std::string_view text, double width, std::size_t most,
                                      const TextStyle& style);

}  // namespace meander
