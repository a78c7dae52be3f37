// Reads small files of any kind as a whole. Files of items: see file_bytes.h.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace meander {

// Reads a file of any kind to its end, pipes included. Throws FileError, also when reading fails halfway.
std::string content_of_file(const std::filesystem::path& path);
std::optional<std::string> content_if_exists(const std::filesystem::path& path);

}  // namespace meander
