// One file of the process, for readers that take a path.
#pragma once

#include <filesystem>
#include <string_view>

#include "support/mesh_files.h"

namespace meander::fuzz {

// A file of this name in a folder that goes with the process. Names of different files must differ.
inline const std::filesystem::path& scratch_folder() {
  static const test::ScratchFolder folder;
  return folder.path();
}
inline std::filesystem::path scratch_file(std::string_view name, std::string_view bytes) {
  const std::filesystem::path path = scratch_folder() / name;
  test::write_file(path, bytes);
  return path;
}

}  // namespace meander::fuzz
