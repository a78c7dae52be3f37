// Names of files that a job writes, one an item.
#pragma once

#include <filesystem>
#include <functional>
#include <set>
#include <string>

namespace meander {

// The path with every part short enough for file systems (230 bytes of the 255, as a temporary name is longer
// than the name): what is cut off, in front of the extension, is told apart by a hash of the whole part.
std::filesystem::path shortened_parts(const std::filesystem::path& path);

// Removes the temporary files of killed processes (AtomicFile: NAME.tmp and a number) whose NAME is one of
// these, relative to the folder, or one in the folder itself for which `is_own` says so. One listing a
// folder.
void remove_temporaries(const std::filesystem::path& folder, const std::set<std::string>& names);
void remove_temporaries(const std::filesystem::path& folder,
                        const std::function<bool(const std::string& name)>& is_own);

}  // namespace meander
