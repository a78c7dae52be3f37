// What attributes the file of a mesh has, and of which type, from its header alone.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "io/file/byte_source.h"
#include "io/mesh/mesh_reader.h"

namespace meander {

struct FileAttribute {
  std::string name;
  std::uint32_t width = 1;  // of glTF; elsewhere vectors are attributes with names of their own
  bool integers = false;    // see ScalarAttribute::integers
  bool of_faces = false;
};

// Those that an attribute column can be made of, in the order of the file, each once: of PLY the scalar
// properties of vertices and of faces; of glTF those whose names begin with `_`, and the numbers of faces
// that every such file has; of OBJ the latter alone, whether or not the file names any group; none of other
// formats. Reads at most 64 KiB, of glTF the JSON up to 16 MiB. Of a file that cannot be read, none.
std::vector<FileAttribute> peek_attributes(const ByteSource& file, MeshFormat format);

// Whether a column would take integers from a model with these attributes; nothing where it finds none.
std::optional<bool> takes_integers(std::span<const FileAttribute> attributes, const AttributeColumn& column);

}  // namespace meander
