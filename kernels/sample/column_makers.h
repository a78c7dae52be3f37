// How the columns that have an option are made, a row each, in the order of sample_columns.
#pragma once

#include <array>
#include <cstddef>
#include <string_view>

#include "kernels/core/cancel.h"
#include "kernels/data/columns.h"
#include "kernels/mesh/polygon_mesh.h"
#include "kernels/mesh/prepared_mesh.h"

namespace meander {

// The model whose samples are given a column.
struct ColumnSource {
  const PolygonMesh& file;
  const PreparedMesh& surface;
  const CancelToken& cancel;
};

// What a maker says of a column with optional values: whether a sample has none, and whether all have none.
struct MadeColumn {
  bool lacks_some = false, is_missing = false;
};

// What a maker takes of the model that readers or earlier stages would leave out or free.
struct ColumnReads {
  bool colors = false, coordinates = false;  // of the file
  bool polygons = false;                     // where they begin in the file
  bool neighbors = false;                    // of the triangles
};

// Memory, beside what reads of the file take: of the model, of each of its vertices, triangles and samples.
struct ColumnBytes {
  double fixed = 0, per_vertex = 0, per_triangle = 0, per_sample = 0;
};

struct ColumnMaker {
  std::size_t column = 0;  // in sample_columns
  std::string_view stage;
  // Fills the array of row.samples, which are placed, and what the report says of it. Throws RunCanceled and
  // ItemError(timeout) by source.cancel.
  MadeColumn (*make)(const ColumnSource& source, Row& row) = nullptr;
  ColumnReads reads = {};
  ColumnBytes bytes = {};
};

MadeColumn make_colors(const ColumnSource& source, Row& row);       // sample_colors.h
MadeColumn make_coordinates(const ColumnSource& source, Row& row);  // sample_attributes.h

inline constexpr auto column_makers = std::to_array<ColumnMaker>({
    // The materials of OBJ; values and the attributes or parts they are made of, of a vertex, and of a
    // polygon and its three corners, of textured ones with three coordinates of their own.
    {column_of(&Samples::rgb),
     "color_samples",
     make_colors,
     {.colors = true, .polygons = true},
     {2.0 * 1024 * 1024, 64, 180, 6}},
    {column_of(&Samples::texcoord),
     "coordinate_samples",
     make_coordinates,
     {.coordinates = true, .polygons = true},
     {0, 0, 0, 24}},
});

static_assert([] {  // each column that has an option has a maker
  std::size_t m = 0;
  for (std::size_t c = 0; c < sample_columns.size(); ++c)
    if (sample_columns[c].is_asked_for() && (m == column_makers.size() || column_makers[m++].column != c))
      return false;
  return m == column_makers.size();
}());

// Whether a maker of one of the columns reads it: &ColumnReads::colors ...
constexpr bool any_reads(const ColumnSet& columns, bool ColumnReads::*what) {
  for (const ColumnMaker& maker : column_makers)
    if (columns[maker.column] && maker.reads.*what) return true;
  return false;
}

}  // namespace meander
