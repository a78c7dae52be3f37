// A whole file in memory, for small files that are read once, of any kind. For those of items: file_bytes.h.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace meander {

// To the end, whatever the kind of the file: pipes too. Throws FileError, also when reading fails half-way.
std::string content_of_file(const std::filesystem::path& path);
std::optional<std::string> content_if_exists(const std::filesystem::path& path);

}  // namespace meander
