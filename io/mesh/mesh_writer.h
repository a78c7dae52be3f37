// Writing triangle meshes as files that other programs read.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "io/mesh/mesh_reader.h"

namespace meander {

// What vertices have beside their places; empty spans are not written.
struct WrittenValues {
  struct Attribute {
    std::string name;
    std::span<const float> values;  // V, NaN where there is none
    bool integers = false;          // all are whole numbers within int32
  };
  std::span<const std::uint8_t> rgb;  // 3 V, as displayed
  std::span<const float> texcoord;    // 2 V, NaN where there are none
  std::vector<Attribute> attributes;
};

// Why a file of this format cannot hold those values, or cannot under these names; empty where it can. OFF
// has colors, OBJ colors and texture coordinates, PLY all three.
std::string written_values_problem(MeshFormat format, bool colors, bool texcoord,
                                   std::span<const std::string> attributes);

// x, y, z: V coordinates of the file; triangles: 3 F vertex numbers. PLY: binary little-endian, double
// coordinates, faces as lists of uchar and uint, colors as uchar red, green, blue, texture coordinates as
// float s, t, attributes as float, integers as int, under their names; OFF and OBJ: shortest decimals that
// read back to the same double. OFF and OBJ: colors in [0, 1] behind the coordinates, of OFF (COFF) with an
// opacity; OBJ: `vt` of the vertices that have texture coordinates, faces with them where all three have. An
// AtomicFile: its name is that of a whole file at every moment. Throws FileError, std::invalid_argument for
// other formats, for arrays that do not fit, and values that the format cannot hold. O(V + F), 1 MiB of
// buffer.
void write_mesh(const std::filesystem::path& path, MeshFormat format, std::span<const double> x,
                std::span<const double> y, std::span<const double> z,
                std::span<const std::uint32_t> triangles, const WrittenValues& values = {});

}  // namespace meander
