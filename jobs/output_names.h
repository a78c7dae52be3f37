// Names of files that a job writes, one an item.
#pragma once

#include <filesystem>

namespace meander {

// The path with every part short enough for file systems (230 bytes of the 255, as a temporary name is longer
// than the name): what is cut off, in front of the extension, is told apart by a hash of the whole part.
std::filesystem::path shortened_parts(const std::filesystem::path& path);

}  // namespace meander
