// A model whose colors and attributes change from left to right.
#pragma once

#include <string>

namespace meander::test {

// A square of side 2 that faces z, in an ASCII PLY file: red and of the kind 3 where x < 0, blue and of the
// kind 7 where x > 0. Its `heat` is x, its texture coordinates are (x + 1) / 2 and (y + 1) / 2.
inline std::string colored_square() {
  return "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\n"
         "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty float heat\n"
         "property int kind\nproperty float s\nproperty float t\nelement face 2\n"
         "property list uchar int vertex_indices\nend_header\n"
         "-1 -1 0 255 0 0 -1 3 0 0\n0 -1 0 255 0 0 0 3 0.5 0\n0 1 0 255 0 0 0 3 0.5 1\n"
         "-1 1 0 255 0 0 -1 3 0 1\n"
         "0 -1 0 0 0 255 0 7 0.5 0\n1 -1 0 0 0 255 1 7 1 0\n1 1 0 0 0 255 1 7 1 1\n0 1 0 0 0 255 0 7 0.5 1\n"
         "4 0 1 2 3\n4 4 5 6 7\n";
}

}  // namespace meander::test
