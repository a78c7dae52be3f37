// The vertices and edges of one component as a weighted graph, and shortest paths in it.
#pragma once

#include <cstdint>
#include <vector>

#include "kernels/core/cancel.h"
#include "kernels/core/radix_heap.h"
#include "kernels/mesh/measured_mesh.h"

namespace meander {

// An interior edge seen from one of its ends.
struct SeamArc {
  std::uint32_t vertex;     // the other end
  std::uint32_t half_edge;  // runs from this vertex to the other one
  double length;            // >= 0, MeasuredMesh::length
};

// A component (or a chart) with T triangles and V vertices, both counted from 0. The arcs of vertex v are
// arcs[arc_begin[v]] .. arcs[arc_begin[v + 1] - 1]; they are interior edges only, because boundary edges are
// never cut.
struct SeamGraph {
  std::vector<std::uint32_t> triangles;      // 3 T
  std::vector<std::uint32_t> opposite;       // 3 T, no_index at a boundary
  std::vector<std::uint32_t> source_vertex;  // V working vertices
  std::vector<std::uint32_t> arc_begin;      // V + 1
  std::vector<SeamArc> arcs;
  std::vector<std::uint32_t> loop;           // V: number of the boundary loop, no_index for interior vertices
  std::vector<std::uint32_t> loop_begin;     // loops + 1 offsets into loop_vertices
  std::vector<std::uint32_t> loop_vertices;  // every boundary vertex once, loop by loop

  std::size_t vertex_count() const { return source_vertex.size(); }
  std::size_t triangle_count() const { return triangles.size() / 3; }
  std::size_t loop_count() const { return loop_begin.size() - 1; }
  std::uint32_t origin(std::uint32_t half_edge) const { return triangles[half_edge]; }
  std::uint32_t target(std::uint32_t half_edge) const { return triangles[next_half_edge(half_edge)]; }
  // Both half-edges of an edge have the same name.
  std::uint32_t edge_name(std::uint32_t half_edge) const {
    return opposite[half_edge] < half_edge ? opposite[half_edge] : half_edge;
  }
};

// Builds the component with its own numbering, arcs and boundary loops. O(T).
SeamGraph make_seam_graph(const MeasuredMesh& surface, const Component& component);

// Distances along edges from a growing set of sources (Dijkstra). Sources added later only visit the vertices
// that they improve. Deterministic: ties fall by the order in which vertices were reached.
class ShortestPaths {
 public:
  explicit ShortestPaths(const SeamGraph& graph)
      : graph_(graph), distance_(graph.vertex_count(), unreached), arrival_(graph.vertex_count(), no_index) {}

  static constexpr double unreached = 1e300;

  void add_source(std::uint32_t vertex);
  // With `whole_loops`, reaching one vertex of a boundary loop reaches all of them at the same distance. O(T
  // log T).
  void run(const CancelToken& cancel, bool whole_loops = false);

  double distance(std::uint32_t vertex) const { return distance_[vertex]; }
  // The half-edge that ends at the vertex and through which it was reached; no_index at sources.
  std::uint32_t arrival(std::uint32_t vertex) const { return arrival_[vertex]; }
  // The farthest reached vertex, the smallest index among equals.
  std::uint32_t farthest() const;
  // Half-edges from `vertex` back to a source, each from its arrival.
  std::vector<std::uint32_t> path_to(std::uint32_t vertex) const;

 private:
  void reach_loop(std::uint32_t vertex, double distance);

  const SeamGraph& graph_;
  std::vector<double> distance_;
  std::vector<std::uint32_t> arrival_;
  std::vector<std::uint8_t> loop_reached_;
  RadixHeap heap_;
};

}  // namespace meander
