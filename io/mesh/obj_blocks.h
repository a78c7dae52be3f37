// Internal to io/mesh: what the lines of one block of an OBJ file hold.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "io/mesh/mesh_reader.h"
#include "io/mesh/polygon_parts.h"

namespace meander {

struct RelativeIndex {
  std::size_t position;  // in the index array of its part
  std::int64_t offset;   // added to the count of all earlier parts
};

// From this polygon of a part on: of a material, an object or groups.
struct NameUse {
  std::size_t polygon;
  std::string_view name;
};

// What is read beside positions, normals and faces.
struct ObjExtras {
  bool colors = false, textures = false;  // colors; textures of materials, which need coordinates
  bool keeps_coordinates = false;         // texture coordinates for their own sake
  bool groups = false, objects = false, materials = false;  // what faces belong to
  bool coordinates() const { return textures || keeps_coordinates; }
};

// Index numbers of one kind (vertices, normals or texture coordinates) that faces of a part name.
struct ObjPart {
  std::vector<double> x, y, z;
  std::vector<float> normals;
  std::vector<float> colors;       // three per vertex, where they are asked for
  std::vector<float> painted;      // the same, of comments `#MRGB`, for the vertices in their order
  std::vector<NameUse> materials;  // the same
  std::vector<NameUse> groups, objects;
  PolygonPart polygons;
  std::vector<std::uint32_t> corner_normals;      // for the first corners, as far as faces name normals
  std::vector<float> coordinates;                 // two per texture coordinate, where they are asked for
  std::vector<std::uint32_t> corner_coordinates;  // as corner_normals
  std::vector<RelativeIndex> relative_corners, relative_normals, relative_coordinates;
  std::uint64_t bad_faces = 0, free_forms = 0;
  const char* first_bad_face = nullptr;
  const char* bad_vertex = nullptr;  // the token that is not a number
  bool cut_vertex = false;           // the last line of the file ends in a vertex
  bool keywords = false;             // a line that only OBJ files have was seen
};

// Whether a line end does not end the line: one behind a backslash, and blanks.
bool is_continued(const char* line_end, const char* text_begin);

// Reads whole lines into an empty part.
void read_obj_block(const char* begin, const char* end, ObjExtras extras, ObjPart& part);

// See FormatRow::read.
PolygonMesh read_obj(std::string_view content, const CancelToken& cancel, const BlockRule& rule,
                     const MeshSurroundings& around);

}  // namespace meander
