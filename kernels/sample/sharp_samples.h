// Samples on the sharp edges of a surface, evenly spread by length.
#pragma once

#include <cstdint>
#include <string>

#include "kernels/core/cancel.h"
#include "kernels/core/random.h"
#include "kernels/core/words.h"
#include "kernels/data/samples.h"
#include "kernels/mesh/polygon_mesh.h"
#include "kernels/mesh/prepared_mesh.h"
#include "kernels/query/sharp_edges.h"
#include "kernels/sample/place_samples.h"

namespace meander {

// What stands in for the points of a model without a sharp edge: its samples, or NaN.
enum class SharpFill : std::uint8_t { surface, nan };
inline constexpr Word<SharpFill> sharp_fill_words[] = {{"surface", SharpFill::surface},
                                                       {"nan", SharpFill::nan}};

// Of a model.
inline constexpr std::uint32_t most_sharp_samples = std::uint32_t{1} << 24;

struct SharpParameters {
  std::uint32_t samples = 0;  // of a model; 0: none
  double angle = 30;          // degrees, see SharpEdgeParameters
  bool borders = false;       // of these, too
  bool corners = false;       // of these first
  std::string attribute;      // edges between faces that differ in this attribute are sharp, too; empty: none
  SharpFill fill = SharpFill::surface;
};

// The edges that the parameters ask for. See find_sharp_edges. A model whose faces have no such attribute has
// no edges by it, which is a note; faces beyond its values are of one class, that of faces without a number.
// `file` needs its polygons and attributes, where there is one to look at.
SharpEdges sharp_edges_of(const PolygonMesh& file, const PreparedMesh& mesh,
                          const SharpParameters& parameters, Notes& notes);

// The mean of the normals of the two faces at an edge, of length 1, turned as the first of them is; that of
// the first where the faces lie on each other, or where there is only one.
Vector3 edge_normal(const PreparedMesh& mesh, const SharpEdges& edges, std::size_t e);

// Adds the points on the edges to a row whose samples are placed, in its frame, and what the report says of
// them. Positions along the edges are those of the sequence `shifted`, with the jitter of the samples
// (sample_sequence), whose numbers are drawn from `key` apart from those of the samples; in the file they are
// ordered as samples are. With `corners` the first are the corners of the edges (sharp_corners), of too many
// of them those at even steps along the 3-D Hilbert curve, with the edge, normal and tangent of one edge
// there; in a progressive order, and the sequence is that of the others. Without a sharp edge, or with edges
// of no length, the samples of the row stand in, from the front again where there are fewer of them, with
// normals, and with tangents from one corner of their triangle to the next; or NaN. O(S log E). Throws
// timeout / RunCanceled.
void add_sharp_samples(const PreparedMesh& mesh, const SharpEdges& edges, const SharpParameters& parameters,
                       OrderKind order, double jitter, RandomKey key, const CancelToken& cancel, Row& row);

// Upper bound of the bytes that finding edges and placing points take, beside the row; and those of the row.
constexpr double sharp_bytes(double samples, double triangles) {
  constexpr double bytes_per_sample = 8 + 4 + 24 + 24 + 2 * 40;
  return samples * bytes_per_sample + edge_points_bytes(samples, 3 * triangles) +
         sharp_edges_bytes(triangles);
}

}  // namespace meander
