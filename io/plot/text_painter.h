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

enum class TextAlign { left, center, right };

// Pixels from the start of the text to its end.
double painted_width(std::string_view text, const TextStyle& style);

// Mixes one line of UTF-8 into the picture, `baseline` pixels below its upper edge; `x` is the start, the
// middle or the end of the text, which is clipped to the picture. Bytes that are not UTF-8 appear as question
// marks. The glyphs depend on the fonts of the machine. Throws std::runtime_error with cairo's reason.
void paint_text(RgbImage& image, std::string_view text, double x, double baseline, const TextStyle& style,
                TextAlign align = TextAlign::left);

// The text if it fits into `width` pixels, else an ellipsis and its end: the end of a path says the most.
std::string shortened_at_front(std::string_view text, double width, const TextStyle& style);

// Breaks the text between words into at most `most` >= 1 lines of at most `width` pixels; only the end of a
// longer word is shown. If the text does not fit, the last line ends with an ellipsis.
std::vector<std::string> wrapped_text(std::string_view text, double width, std::size_t most,
                                      const TextStyle& style);

}  // namespace meander
