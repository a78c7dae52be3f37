// Text inside XML and HTML.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace meander {

// Escapes text for element content and quoted attributes: & < > " ' become entities; bytes that are not UTF-8
// and characters that XML 1.0 forbids (control characters but tab and line breaks, U+FFFE, U+FFFF) become
// U+FFFD.
std::string escape_markup(std::string_view text);

// A run of text on the base line (0), raised (-1) or lowered (1).
struct TextRun {
  std::string_view text;
  int shift = 0;
};

// Splits "N^{-1/2}" into "N" and a raised "-1/2", "d_{min}" into "d" and a lowered "min"; marks without an
// end are text. Runs point into `text`.
std::vector<TextRun> text_runs(std::string_view text);

}  // namespace meander
