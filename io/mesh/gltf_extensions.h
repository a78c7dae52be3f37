// Internal to io/mesh: what extensions of glTF mean for the shape and the colors of a model at rest.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "io/json/json_tree.h"
#include "kernels/core/notes.h"

namespace meander {

// Whether a file may require it: it is applied, or what it changes is not the shape.
bool is_known_extension(std::string_view name);

// A name or URI of a file as one line of at most `most` bytes of UTF-8.
std::string shown_text(std::string_view text, std::size_t most = 64);

// Adds Note::feature_ignored, once for each extension that the file lists or has in one of its objects, that
// changes the shape (with `colors` also the colors) and is not applied; the example names them. O(values).
void note_ignored_extensions(const JsonTree& json, bool colors, Notes& notes);

}  // namespace meander
