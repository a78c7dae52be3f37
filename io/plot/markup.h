// Text inside XML and HTML.
#pragma once

#include <string>
#include <string_view>

namespace meander {

// For element content and quoted attributes: & < > " ' as entities; bytes that are not UTF-8 and characters
// that XML 1.0 forbids (control characters but tab and line breaks, U+FFFE, U+FFFF) as U+FFFD.
std::string escape_markup(std::string_view text);

}  // namespace meander
