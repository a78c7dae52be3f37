// A triangulation that is changed edge by edge: split, flip, collapse. docs/ARCHITECTURE.md (Dependencies)
// compares it with OpenMesh.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "kernels/core/vector3.h"
#include "kernels/mesh/prepared_mesh.h"

namespace meander {

// What keeps an edge from being flipped.
enum EdgeMark : std::uint8_t { mark_crease = 1, mark_kept = 2 };

// A vertex that was put on an edge, between two others.
struct CutVertex {
  std::uint32_t vertex, first, second;
  double share;  // of the second; the first has the rest
};

// An oriented 2-manifold with boundary as flat half-edges, numbered as those of PreparedMesh: half-edge
// h = 3 t + k of triangle t starts at vertex[h]. Removed triangles have no_index for their vertices, removed
// vertices for their half-edge; numbers of the others never change. Two edges may join the same two vertices,
// the three vertices of a triangle differ. Everything is O(1) but what walks around a vertex.
struct EditedMesh {
  std::vector<Vector3> position;  // W
  std::vector<std::uint32_t>
      out;  // W: a half-edge that starts there; of a boundary vertex that of the boundary
  std::vector<std::uint32_t> vertex;    // 3 T
  std::vector<std::uint32_t> opposite;  // 3 T, no_index at a boundary
  std::vector<std::uint8_t> crease;     // 3 T: EdgeMark (the same on both sides)
  std::vector<CutVertex> cuts;          // ascending by vertex

  std::uint32_t start(std::uint32_t h) const { return vertex[h]; }
  std::uint32_t end(std::uint32_t h) const { return vertex[next_half_edge(h)]; }
  std::uint32_t apex(std::uint32_t h) const { return vertex[previous_half_edge(h)]; }
  bool exists(std::uint32_t triangle) const { return vertex[3 * std::size_t{triangle}] != no_index; }
  bool is_boundary_edge(std::uint32_t h) const { return opposite[h] == no_index; }
  bool is_boundary_vertex(std::uint32_t v) const { return opposite[out[v]] == no_index; }
  // Not to be flipped.
  bool is_line(std::uint32_t h) const { return crease[h] != 0 || opposite[h] == no_index; }
  bool is_crease_or_boundary(std::uint32_t h) const {
    return (crease[h] & mark_crease) != 0 || opposite[h] == no_index;
  }
  std::size_t triangle_count() const { return vertex.size() / 3; }
  // Twice the area along the normal.
  Vector3 area_vector(std::uint32_t triangle) const;

  // Calls visit(h) for the half-edges that start at v, counter-clockwise, a boundary vertex's first.
  template <class Visit>
  void for_outgoing(std::uint32_t v, const Visit& visit) const {
    const std::uint32_t first = out[v];
    std::uint32_t h = first;
    do {
      visit(h);
      h = opposite[previous_half_edge(h)];
    } while (h != first && h != no_index);
  }
  // Calls visit(w, h) for the neighbors of v, with a half-edge of the edge between: one that starts at v,
  // but for the last neighbor of a boundary vertex.
  template <class Visit>
  void for_neighbors(std::uint32_t v, const Visit& visit) const {
    std::uint32_t last = no_index;
    for_outgoing(v, [&](std::uint32_t h) {
      visit(end(h), h);
      last = previous_half_edge(h);
    });
    if (opposite[last] == no_index) visit(start(last), last);
  }
  // Whether more than `most` half-edges start at v. O(most).
  bool has_more_outgoing(std::uint32_t v, std::uint32_t most) const {
    const std::uint32_t first = out[v];
    std::uint32_t h = first, count = 0;
    do {
      if (++count > most) return true;
      h = opposite[previous_half_edge(h)];
    } while (h != first && h != no_index);
    return false;
  }
  // O(the lesser number of neighbors of the two).
  bool are_neighbors(std::uint32_t v, std::uint32_t w) const;

  // A vertex of that position, not yet in any triangle.
  std::uint32_t add_vertex(Vector3 at);
  // Cuts triangle t into three around the vertex p, which no triangle has yet.
  void split_triangle(std::uint32_t t, std::uint32_t p);
  // Cuts the edge of h, and the triangles beside it, in two at p. h then runs from its start to p.
  void split_edge(std::uint32_t h, std::uint32_t p);
  // Turns the edge of h, which is no boundary, inside the quadrilateral of its two triangles. h then runs
  // from the apex on its other side to its old end. The caller has made sure that the two apexes are no
  // neighbors.
  void flip(std::uint32_t h);
  // Takes the triangle of the boundary edge of h away, whose apex is inside: it is at the boundary then.
  void remove_at_boundary(std::uint32_t h);
  // Moves v along the edge of h to the other end of it, so that the triangles beside it vanish. The caller
  // has made sure that the topology stays.
  void collapse(std::uint32_t h, std::uint32_t v);

 private:
  std::uint32_t add_triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c);
  void glue(std::uint32_t g, std::uint32_t h);
  // Takes the triangle of h out, whose edges next to h become one. Returns a half-edge on it.
  std::uint32_t close_triangle(std::uint32_t h);
  void begin_at_boundary(std::uint32_t v, std::uint32_t h);
};

// One component, with the numbers of its triangles and vertices counted from 0.
EditedMesh edited_component(const PreparedMesh& mesh, const Component& component);

}  // namespace meander
