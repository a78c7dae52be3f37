// Which components of a surface are closed, and which way they are to be turned so that the surface bounds a
// solid.
#pragma once

#include <cstdint>
#include <vector>

#include "kernels/mesh/polygon_mesh.h"
#include "kernels/mesh/prepared_mesh.h"
#include "kernels/query/triangle_tree.h"
#include "kernels/query/winding_number.h"

namespace meander {

// Of a mesh of T triangles.
struct OrientedSurface {
  std::vector<std::uint8_t> flipped;  // T: 1 where the triangle is to be turned over
  std::vector<std::uint8_t> closed;   // by component: its triangles pass every edge as often one way as the
                                      // other
  // T: bits 0 to 2 for open edges, from the corners 0, 1 and 2 on, which all triangles, once turned, pass
  // more often one way than the other; bits 3 to 5 for the corners at the ends of open edges of any triangle.
  std::vector<std::uint8_t> open_sides;
  std::uint32_t open_edges = 0;  // how often more, in all
  std::vector<double> boundary;  // seven numbers for each open edge: ends, and how often more towards the
                                 // second
  bool nested = true;            // false where it is not known which of too many components lie in which
  bool all_closed() const { return open_edges == 0; }
};

// Turns components outward. A closed component is turned so that its volume is positive, unless it lies in
// another closed one that is wound the other way: then it stays wound against that one, and is a cavity in a
// solid or a solid in a cavity. (It lies in the smallest one whose box holds its own and which winds around
// eight of its vertices, as far as it has them.) So a model that is inside out as a whole has the same
// orientation, and components that overlap are one solid. A component with a boundary is turned so that it
// has positive volume with the cone from its boundary to the middle of that, or, where that says nothing (a
// flat sheet), so that it faces away from the middle of the whole surface.
//
// Edges are compared by the positions of their ends, so that what prepare_mesh split along edges of more than
// two faces may be closed. Components without volume are left as they are. O(T log T), and the cost of eight
// winding numbers for each component that the box of another holds. That search ends after about a second,
// by counted work: components that it did not come to are turned outward, and `nested` is false. mesh: with
// topology.
OrientedSurface orient_outward(const PreparedMesh& mesh);

// Upper bound of the bytes that it takes beside the mesh.
constexpr double orient_outward_bytes(double triangles) {
  // Sides of edges, positions, boxes of components, and the result, of which the boundary has up to three
  // edges a triangle; trees of components in which others lie.
  constexpr double bytes_per_triangle = 330, least = 32768;
  return least + triangles * bytes_per_triangle + triangle_tree_bytes(triangles) +
         winding_tree_bytes(triangles);
}

// Takes the corners from polygons whose corners have the positions of those of an earlier polygon, in any
// order, so that two-sided and doubled surfaces are single ones. The others keep their numbers. Returns how
// many were taken. O(K log K).
std::uint32_t drop_doubled_faces(PolygonMesh& mesh);

// Upper bound of the bytes that it takes beside the mesh.
constexpr double drop_doubled_faces_bytes(double polygons, double corners, double vertices) {
  return 9 * polygons + 4 * corners + 40 * vertices;
}

}  // namespace meander
