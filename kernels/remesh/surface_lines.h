// The lines of a surface that a remeshed one keeps: its boundary, and creases.
#pragma once

#include <cstdint>
#include <span>

#include "kernels/remesh/edited_mesh.h"

namespace meander {

struct LineParameters {
  double crease_angle = 40;  // degrees between the normals of two triangles from which their edge is a
                             // crease; 1..180, 180: none
  double spacing = 1.2;      // longest edge of a line over the spacing of the samples; 0.5..10
  double deviation = 0.05;   // how far a line may move where its vertices are left out, over that spacing
  double merging = 0.25;     // lines come together, and corners vanish, within that part of it
  double shortest = 2;       // connected creases of less length in all, over that spacing, are no lines
};

// Marks the creases of a mesh whose edges are those of the surface. spacing: W lengths, of the samples around
// each vertex. A triangle without a normal takes that of the triangle beyond its longest edge. O(T).
void mark_creases(EditedMesh& mesh, std::span<const double> spacing, const LineParameters& parameters);

// Cuts boundary edges and creases longer than they may be into equal parts. The new vertices follow those
// that are there; `spacing` has values for the ends of all lines. Cuts at most `most` times; false when that
// was not enough. O(T).
bool split_lines(EditedMesh& mesh, std::span<const double> spacing, const LineParameters& parameters,
                 std::uint32_t most);

// Cuts all but one of the edges that join the same two vertices in the middle, so that the vertices of a
// triangle tell its edges, as files of vertex numbers need it. O(T log T).
void split_double_edges(EditedMesh& mesh);

}  // namespace meander
