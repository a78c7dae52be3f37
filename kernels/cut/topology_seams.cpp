#include "kernels/cut/topology_seams.h"

#include <algorithm>

#include "kernels/core/disjoint_sets.h"

namespace meander {

namespace {

// Adds the 2 g edges that tree and cotree leave over, so that the complement of `in_cut` (indexed by edge
// name) is a tree in the dual.
void add_handle_edges(const SeamGraph& graph, const ShortestPaths& paths, std::vector<std::uint8_t>& in_cut) {
  struct Candidate {
    double weight;
    std::uint32_t half_edge;
  };
  std::vector<Candidate> candidates;
  candidates.reserve(graph.triangle_count() + 16);
  for (std::uint32_t v = 0; v < graph.vertex_count(); ++v)
    for (std::uint32_t a = graph.arc_begin[v]; a < graph.arc_begin[v + 1]; ++a) {
      const SeamArc& arc = graph.arcs[a];
      if (graph.edge_name(arc.half_edge) != arc.half_edge || in_cut[arc.half_edge]) continue;
      candidates.push_back({paths.distance(v) + paths.distance(arc.vertex) + arc.length, arc.half_edge});
    }
  std::sort(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) {
    return a.weight > b.weight || (a.weight == b.weight && a.half_edge < b.half_edge);
  });
  DisjointSets sets(graph.triangle_count());
  for (const Candidate& c : candidates)
    if (!sets.join(c.half_edge / 3, graph.opposite[c.half_edge] / 3)) in_cut[c.half_edge] = 1;
}

// Removes edges that end at an interior vertex with no other cut edge, again and again. Boundary loops are
// nodes that stay.
void prune_dead_ends(const SeamGraph& graph, std::vector<std::uint8_t>& in_cut) {
  std::vector<std::uint32_t> degree(graph.vertex_count(), 0), ends;
  for (std::uint32_t h = 0; h < in_cut.size(); ++h)
    if (in_cut[h]) ++degree[graph.origin(h)], ++degree[graph.target(h)];
  for (std::uint32_t v = 0; v < graph.vertex_count(); ++v)
    if (degree[v] == 1 && graph.loop[v] == no_index) ends.push_back(v);
  while (!ends.empty()) {
    const std::uint32_t v = ends.back();
    ends.pop_back();
    if (degree[v] != 1) continue;  // its last edge went with the other end
    for (std::uint32_t a = graph.arc_begin[v]; a < graph.arc_begin[v + 1]; ++a) {
      const SeamArc& arc = graph.arcs[a];
      std::uint8_t& cut = in_cut[graph.edge_name(arc.half_edge)];
      if (!cut) continue;
      cut = 0;
      --degree[v];
      if (--degree[arc.vertex] == 1 && graph.loop[arc.vertex] == no_index) ends.push_back(arc.vertex);
      break;
    }
  }
}

}  // namespace

std::int64_t euler_characteristic(const SeamGraph& graph) {
  const auto edges = static_cast<std::int64_t>(graph.triangles.size() - graph.arcs.size() / 2);
  return static_cast<std::int64_t>(graph.vertex_count()) - edges +
         static_cast<std::int64_t>(graph.triangle_count());
}

std::vector<std::uint32_t> find_topology_seams(const SeamGraph& graph, const CancelToken& cancel) {
  // chi = 2 - 2 g - b
  const std::int64_t handle_edges =
      2 - static_cast<std::int64_t>(graph.loop_count()) - euler_characteristic(graph);
  if (handle_edges < 0 || handle_edges % 2 != 0)
    throw ItemError(Status::internal, "a component has Euler characteristic " +
                                          std::to_string(euler_characteristic(graph)) + " with " +
                                          std::to_string(graph.loop_count()) + " boundary loops");
  if (handle_edges == 0 && graph.loop_count() <= 1) return {};

  ShortestPaths paths(graph);
  paths.add_source(graph.loop_count() > 0 ? graph.loop_vertices[0] : 0);
  paths.run(cancel, true);
  std::vector<std::uint8_t> in_cut(graph.opposite.size(), 0);
  for (std::uint32_t v = 0; v < graph.vertex_count(); ++v)
    if (paths.arrival(v) != no_index) in_cut[graph.edge_name(paths.arrival(v))] = 1;
  if (handle_edges > 0) add_handle_edges(graph, paths, in_cut);
  cancel.check();
  prune_dead_ends(graph, in_cut);

  std::vector<std::uint32_t> seams;
  for (std::uint32_t h = 0; h < in_cut.size(); ++h)
    if (in_cut[h]) seams.push_back(h);
  return seams;
}

}  // namespace meander
