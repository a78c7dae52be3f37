// Meshes as files: writers of every format that io/mesh reads, and temporary folders.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "kernels/mesh/polygon_mesh.h"

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

void write_file(const std::filesystem::path& path, std::string_view bytes);
std::string read_file(const std::filesystem::path& path);

inline bool same_bytes(const std::filesystem::path& a, const std::filesystem::path& b) {
  return read_file(a) == read_file(b);
}

// A new empty folder, removed with everything in it at the end of the scope.
class ScratchFolder {
 public:
  ScratchFolder();
  ~ScratchFolder();
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path operator/(std::string_view name) const { return path_ / name; }

 private:
  std::filesystem::path path_;
};

}  // namespace meander::test
