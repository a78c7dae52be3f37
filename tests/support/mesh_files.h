// Meshes as files: writers of every format that io/mesh reads.
#pragma once

#include <filesystem>
#include <string>

#include "kernels/mesh/polygon_mesh.h"
#include "support/scratch_files.h"  // where they are written

namespace meander::test {

enum class MeshFile {
  off,
  off_binary,
  obj,
  ply_ascii,
  ply_little_endian,
  ply_big_endian,
  stl_ascii,
  stl_binary
};

// The bytes of a file that holds the mesh. Text has shortest decimals that read back to the same doubles;
// binary OFF and STL hold float32. OBJ writes corner normals (a//c), OFF and PLY vertex normals, PLY every
// scalar attribute as double. STL holds fans of the polygons. Vertex numbers are written as they are,
// whatever they name.
std::string mesh_bytes(const PolygonMesh& mesh, MeshFile kind);
void write_mesh(const std::filesystem::path& path, const PolygonMesh& mesh, MeshFile kind);
// By the extension: .off, .obj, .ply (little-endian) or .stl (binary).
void write_mesh(const std::filesystem::path& path, const PolygonMesh& mesh);

}  // namespace meander::test
