// The program under test, and what its commands leave in a folder. For tests with a PROGRAM
// (MEANDER_PROGRAM).
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "support/mesh_files.h"
#include "support/run_process.h"

namespace meander::test {

inline const std::string program = MEANDER_PROGRAM;

inline ProcessResult meander_with(std::vector<std::string> arguments, const ProcessOptions& options = {}) {
  arguments.insert(arguments.begin(), program);
  return run_process(arguments, options);
}

inline bool contains(std::string_view text, std::string_view part) {
  return text.find(part) != std::string_view::npos;
}

// Every file below a folder with its bytes.
inline std::map<std::string, std::string> content_of(const std::filesystem::path& folder) {
  std::map<std::string, std::string> content;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
    if (entry.is_regular_file()) content[entry.path().string()] = read_file(entry.path());
  return content;
}

}  // namespace meander::test
