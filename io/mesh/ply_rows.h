// Internal to io/mesh: where the rows of one PLY element go, and the reader of binary rows.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "io/mesh/mesh_reader.h"
#include "io/mesh/ply_header.h"
#include "io/mesh/polygon_parts.h"

namespace meander {

// The entries of one list of numbers, row by row: those of row r are [begin[r], begin[r + 1]).
struct PlyNumberList {
  std::vector<std::size_t> begin = {0};
  std::vector<float> values;
};

// Per property of an element: where its values go, one per row, or three apart for the components of normals;
// both null for a property that is skipped.
struct PlyColumns {
  struct Column {
    double* values = nullptr;
    float* normals = nullptr;
  };
  std::vector<Column> columns;
  int index_list = -1;               // the property whose entries become the corners of one polygon per row
  int number_list = -1;              // the property whose entries go
  PlyNumberList* numbers = nullptr;  // here
};

// Throws ItemError(unreadable) where vertices have no x, y or z.
void check_positions(const PlyElement& vertices);
// Takes memory for `rows` vertices, for x, y, z and, where the element has all three, nx, ny, nz to go there.
void place_vertices(const PlyElement& vertices, std::uint64_t rows,
                    std::array<std::vector<double>*, 3> positions, std::vector<float>& normals,
                    PlyColumns& columns);

// How far the rows of one element could be read.
struct PlyProgress {
  std::uint64_t rows = 0;  // complete rows
  std::size_t bytes = 0;   // of `data` that they take
};

// Reads as many of the element's rows from the start of `data` as are there. Columns hold at least
// min(count, data.size() / fixed_bytes()) values. Lists of one length throughout (all triangles, say) and
// rows without lists are read in parallel blocks.
PlyProgress read_binary_rows(std::string_view data, const PlyElement& element, bool swap,
                             const PlyColumns& columns, PolygonPart& polygons, const CancelToken& cancel,
                             const BlockRule& rule);

// The triangles of strips (one polygon of `strips` each; no_index restarts), in order and with one
// orientation.
PolygonPart triangles_of_strips(const std::vector<PolygonPart>& strips);

// See FormatRow::read.
PolygonMesh read_ply(std::string_view content, const CancelToken& cancel, const BlockRule& rule,
                     const MeshSurroundings& around);

}  // namespace meander
