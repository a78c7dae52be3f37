// Names of files as people and systems write them: files name others in another case, in another normal form
// of Unicode, or in Latin-1.
#pragma once

#include <string>
#include <string_view>

namespace meander {

// The same text for names that differ in case, in the normal form of Unicode (systems of Apple decompose
// letters with accents), or in that one is UTF-8 and the other Latin-1. Slashes and dots stay where they are.
// Bytes that are not well-formed UTF-8 make the whole name Latin-1. O(bytes).
std::string folded_name(std::string_view name);

}  // namespace meander
