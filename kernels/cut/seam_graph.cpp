#include "kernels/cut/seam_graph.h"

namespace meander {

namespace {

void copy_component(const PreparedMesh& mesh, const Component& component, SeamGraph& graph) {
  const std::size_t begin = std::size_t{3} * component.triangle_begin;
  const std::size_t count = std::size_t{3} * (component.triangle_end - component.triangle_begin);
  graph.triangles.resize(count);
  graph.opposite.resize(count);
  for (std::size_t h = 0; h < count; ++h) {
    graph.triangles[h] = mesh.triangles[begin + h] - component.vertex_begin;
    const std::uint32_t other = mesh.opposite[begin + h];
    graph.opposite[h] = other == no_index ? no_index : other - static_cast<std::uint32_t>(begin);
  }
  graph.source_vertex.resize(component.vertex_end - component.vertex_begin);
  for (std::size_t v = 0; v < graph.source_vertex.size(); ++v)
    graph.source_vertex[v] = component.vertex_begin + static_cast<std::uint32_t>(v);
}

void build_arcs(const MeasuredMesh& surface, const Component& component, SeamGraph& graph) {
  const std::size_t count = graph.triangles.size();
  graph.arc_begin.assign(graph.vertex_count() + 1, 0);
  std::size_t arcs = 0;
  for (std::size_t h = 0; h < count; ++h)
    if (graph.opposite[h] != no_index) ++graph.arc_begin[graph.triangles[h] + 1], ++arcs;
  for (std::size_t v = 0; v < graph.vertex_count(); ++v) graph.arc_begin[v + 1] += graph.arc_begin[v];
  graph.arcs.resize(arcs);
  std::vector<std::uint32_t> cursor(graph.arc_begin.begin(), graph.arc_begin.end() - 1);
  for (std::uint32_t h = 0; h < count; ++h) {
    const std::uint32_t other = graph.opposite[h];
    if (other == no_index || other < h) continue;
    const std::uint32_t a = graph.origin(h), b = graph.target(h);
    const double length = surface.length(3 * component.triangle_begin + h);
    graph.arcs[cursor[a]++] = {b, h, length};
    graph.arcs[cursor[b]++] = {a, other, length};
  }
}

void build_loops(SeamGraph& graph) {
  graph.loop.assign(graph.vertex_count(), no_index);
  graph.loop_begin.assign(1, 0);
  std::vector<std::uint32_t> outgoing;  // the boundary half-edge that leaves a vertex
  for (std::uint32_t h = 0; h < graph.opposite.size(); ++h) {
    if (graph.opposite[h] != no_index) continue;
    if (outgoing.empty()) outgoing.assign(graph.vertex_count(), no_index);
    if (outgoing[graph.origin(h)] != no_index)
      throw ItemError(Status::internal, "vertex " + std::to_string(graph.source_vertex[graph.origin(h)]) +
                                            " lies twice on the boundary of its component");
    outgoing[graph.origin(h)] = h;
  }
  for (std::uint32_t start = 0; start < outgoing.size(); ++start) {
    if (outgoing[start] == no_index || graph.loop[start] != no_index) continue;
    const auto number = static_cast<std::uint32_t>(graph.loop_count());
    for (std::uint32_t v = start; graph.loop[v] == no_index; v = graph.target(outgoing[v])) {
      graph.loop[v] = number;
      graph.loop_vertices.push_back(v);
    }
    graph.loop_begin.push_back(static_cast<std::uint32_t>(graph.loop_vertices.size()));
  }
}

}  // namespace

SeamGraph make_seam_graph(const MeasuredMesh& surface, const Component& component) {
  SeamGraph graph;
  copy_component(surface.mesh(), component, graph);
  build_arcs(surface, component, graph);
  build_loops(graph);
  return graph;
}

void ShortestPaths::add_source(std::uint32_t vertex) {
  distance_[vertex] = 0;
  arrival_[vertex] = no_index;
  heap_.push(0, vertex);
}

void ShortestPaths::reach_loop(std::uint32_t vertex, double distance) {
  const std::uint32_t number = graph_.loop[vertex];
  if (number == no_index || loop_reached_[number]) return;
  loop_reached_[number] = 1;
  for (std::uint32_t i = graph_.loop_begin[number]; i < graph_.loop_begin[number + 1]; ++i) {
    const std::uint32_t other = graph_.loop_vertices[i];
    if (other == vertex) continue;
    distance_[other] = distance;
    arrival_[other] = no_index;
    heap_.push(distance, other);
  }
}

void ShortestPaths::run(const CancelToken& cancel, bool whole_loops) {
  if (whole_loops) loop_reached_.assign(graph_.loop_count(), 0);
  std::size_t steps = 0;
  while (!heap_.empty()) {
    const RadixHeap::Entry entry = heap_.pop();
    if (entry.key > distance_[entry.value]) continue;  // superseded by a shorter path
    if ((++steps & 0xFFFF) == 0) cancel.check();
    if (whole_loops) reach_loop(entry.value, entry.key);
    for (std::uint32_t a = graph_.arc_begin[entry.value]; a < graph_.arc_begin[entry.value + 1]; ++a) {
      const SeamArc& arc = graph_.arcs[a];
      const double distance = entry.key + arc.length;
      if (!(distance < distance_[arc.vertex])) continue;
      distance_[arc.vertex] = distance;
      arrival_[arc.vertex] = arc.half_edge;
      heap_.push(distance, arc.vertex);
    }
  }
  heap_.restart();
}

std::uint32_t ShortestPaths::farthest() const {
  std::uint32_t best = no_index;
  double longest = -1;
  for (std::uint32_t v = 0; v < distance_.size(); ++v)
    if (distance_[v] < unreached && distance_[v] > longest) {
      longest = distance_[v];
      best = v;
    }
  return best;
}

std::vector<std::uint32_t> ShortestPaths::path_to(std::uint32_t vertex) const {
  std::vector<std::uint32_t> path;
  for (std::uint32_t h = arrival_[vertex]; h != no_index; h = arrival_[graph_.origin(h)]) path.push_back(h);
  return path;
}

}  // namespace meander
