// The sharp edges of a surface: found by angle, joined to curves, and points along them.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "kernels/mesh/prepared_mesh.h"

namespace meander {

struct SharpEdgeParameters {
  double angle = 30;  // degrees between the normals of two triangles from which their edge is sharp; above 0,
                      // below 180
  bool borders = false;     // edges at which the surface ends are sharp, too
  double tolerance = 1e-6;  // corners as close as that, over the diagonal of the box, are one; 0 to 0.01, 0:
                            // those at equal positions
  // A class of each polygon, or empty. Where polygons of two classes meet the edge is sharp, whatever its
  // angle; NaN is a class.
  std::span<const double> classes = {};
};

// E edges, one behind the other along C curves.
struct SharpEdges {
  std::vector<std::uint32_t> start, end;  // E working vertices, in the direction of the curve: an edge starts
                                          // where the one before it in its curve ends
  std::vector<std::uint32_t> triangle;    // 2 E: those that form the edge; no_index second at a border
  std::vector<std::uint32_t> curve_begin;  // C + 1 edges
  std::vector<double> before;  // E + 1: length of the edges before, working units; the last of all

  std::size_t count() const { return start.size(); }
  double length() const { return before.empty() ? 0 : before.back(); }
};

// Finds the edges whose two triangles, whichever way they are wound, have an angle of at least `angle`
// between their normals, and those where more than two directions meet. Corners are welded first, so that
// surfaces without neighbors (soups) have edges, too. Triangles in the same direction from an edge count
// once: doubled and opposite faces make no edge sharp. Triangles without area are left out.
//
// Curves go straight on at corners: each begins where an odd number of edges meets, or anywhere on what is
// left then, and takes the straightest edge (of up to 32) that is not taken yet until there is none. So a
// curve passes corners, every edge is in one curve, and there are as few curves as edges allow, but for those
// that meet themselves. Deterministic. Throws std::invalid_argument for other parameters. O(T log T).
SharpEdges find_sharp_edges(const PreparedMesh& mesh, const SharpEdgeParameters& parameters = {});

// An end of a sharp edge.
struct EdgeEnd {
  std::uint32_t edge;
  bool is_start;
};

// The corners of sharp edges: where other than two of them meet, or where two turn by at least `angle`
// degrees, above 0. Each by the end of one of its edges, the first; along the 3-D Hilbert curve. O(E log E),
// in less memory than finding the edges took.
std::vector<EdgeEnd> sharp_corners(const PreparedMesh& mesh, const SharpEdges& edges, double angle);

// Upper bound of the bytes that it takes beside the mesh: sides of edges, and what is found, which grow.
constexpr double sharp_edges_bytes(double triangles) {
  constexpr double bytes_per_triangle = 450, least = 4096;
  return triangles * bytes_per_triangle + least;
}

// N points on edges.
struct EdgePoints {
  std::vector<double> point;        // 3 N, working units
  std::vector<std::uint32_t> edge;  // N
  std::vector<double> along;        // N: the weight of the end of the edge, 0 to 1
};

// The points at shares in [0, 1) of the length of all edges (else std::invalid_argument), in any order: those
// of a sequence that is even on [0, 1) are even by length along the curves and across their corners. Where
// there is no edge there may be no share. O(N + E).
EdgePoints points_on_edges(const PreparedMesh& mesh, const SharpEdges& edges, std::span<const double> shares);

// Bytes of the points, and of their search.
constexpr double edge_points_bytes(double points, double edges) { return 36 * points + 4 * edges; }

}  // namespace meander
