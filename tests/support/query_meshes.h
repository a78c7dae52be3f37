// Models of the shared folder that queries are tested with: closed ones, open ones and soups.
#pragma once

#include <string>
#include <vector>

#include "io/mesh/mesh_reader.h"
#include "support/catch.h"
#include "support/test_meshes.h"

namespace meander::test {

inline const std::vector<std::string>& query_models() {
  static const std::vector<std::string> names = {"paper/bunny_closed.off",
                                                 "paper/bunny_stanford_holes.obj",
                                                 "paper/chineselion_8k.stl",
                                                 "paper/eight.off",
                                                 "paper/eight_hole.off",
                                                 "paper/fandisk.off",
                                                 "paper/hand_3k.off",
                                                 "paper/hand_closed.obj",
                                                 "paper/igea_16k.off",
                                                 "paper/knot.obj",
                                                 "paper/knot_25k.ply",
                                                 "paper/maxplanck_25k.off",
                                                 "paper/squirrel_20k_nonmanifold.off",
                                                 "paper/venus_1k_open.off",
                                                 "dirty/common3d_teapot.obj",
                                                 "dirty/common3d_beetle.obj",
                                                 "dirty/soup_Bicycle_D00016.obj",
                                                 "dirty/soup_Helicopter_D00423.obj",
                                                 "dirty/trimesh_multibody.stl",
                                                 "dirty/trimesh_suzanne.ply"};
  return names;
}

inline PolygonMesh model_of(const std::string& name) {
  const std::filesystem::path path = shared_data(name);
  MeshFormat format{};
  REQUIRE(mesh_format_of(path, format));
  const FileBytes file(path);
  return read_mesh(file.bytes(), format);
}

}  // namespace meander::test
