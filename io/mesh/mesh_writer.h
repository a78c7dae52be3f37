// Writing triangle meshes as files that other programs read.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>

#include "io/mesh/mesh_reader.h"

namespace meander {

// x, y, z: V coordinates of the file; triangles: 3 F vertex numbers. PLY: binary little-endian, double
// coordinates, faces as lists of uchar and uint; OFF and OBJ: shortest decimals that read back to the same
// double. An AtomicFile: its name is that of a whole file at every moment. Throws FileError,
// std::invalid_argument for STL, glTF and for arrays that do not fit. O(V + F), 1 MiB of buffer.
void write_mesh(const std::filesystem::path& path, MeshFormat format, std::span<const double> x,
                std::span<const double> y, std::span<const double> z,
                std::span<const std::uint32_t> triangles);

}  // namespace meander
