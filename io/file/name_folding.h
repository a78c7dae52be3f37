// Compares names of files that are written in another case, in another normal form of Unicode, or in Latin-1.
#pragma once

#include <string>
#include <string_view>

namespace meander {

// The same text for names that differ only in case, in the normal form of Unicode (Apple's systems decompose
// letters with accents), or in their encoding, UTF-8 or Latin-1. Slashes and dots are kept. A name with bytes
// that are not well-formed UTF-8 is taken as Latin-1. O(bytes).
std::string folded_name(std::string_view name);

}  // namespace meander
