// Meshes of the shared folder of the survey's models.
#pragma once

#include <string>

#include "io/mesh/mesh_reader.h"
#include "support/catch.h"
#include "support/test_meshes.h"

namespace meander::test {

// Of the shared paper/.
inline PolygonMesh shared_mesh(const std::string& name) {
  const std::filesystem::path path = shared_data("paper/" + name);
  MeshFormat format{};
  REQUIRE(mesh_format_of(path, format));
  const FileBytes file(path);
  return read_mesh(file.bytes(), format);
}

}  // namespace meander::test
