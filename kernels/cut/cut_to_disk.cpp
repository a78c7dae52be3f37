#include "kernels/cut/cut_to_disk.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "kernels/cut/open_seams.h"
#include "kernels/cut/seam_graph.h"
#include "kernels/cut/topology_seams.h"

namespace meander {

namespace {

// The vertex farthest from the center of all vertices: approximately a tip.
std::uint32_t outermost_vertex(const PreparedMesh& mesh, const SeamGraph& graph) {
  Vector3 center;
  for (const std::uint32_t w : graph.source_vertex) center = center + mesh.position(w);
  center = (1.0 / static_cast<double>(graph.vertex_count())) * center;
  std::uint32_t best = 0;
  double longest = -1;
  for (std::uint32_t v = 0; v < graph.vertex_count(); ++v) {
    const Vector3 d = mesh.position(graph.source_vertex[v]) - center;
    if (dot(d, d) > longest) {
      longest = dot(d, d);
      best = v;
    }
  }
  return best;
}

// The area of a component in the metric of its lengths.
double measured_area(const MeasuredMesh& surface, const Component& component) {
  if (surface.in_space()) return component.area;
  double area = 0;
  for (std::uint32_t t = component.triangle_begin; t < component.triangle_end; ++t)
    area += area_from_lengths(surface.length(3 * t), surface.length(3 * t + 1), surface.length(3 * t + 2));
  return area;
}

// The first seam of a closed sphere: a shortest path of at least two edges between two mutually far vertices.
std::vector<std::uint32_t> opening_path(const PreparedMesh& mesh, const SeamGraph& graph,
                                        const CancelToken& cancel) {
  ShortestPaths paths(graph);
  const std::uint32_t start = outermost_vertex(mesh, graph);
  paths.add_source(start);
  paths.run(cancel);
  std::uint32_t end = paths.farthest();
  if (end == start) end = graph.arcs[graph.arc_begin[start]].vertex;  // every edge has length 0
  std::vector<std::uint32_t> path = paths.path_to(end);
  if (path.size() == 1) path.push_back(next_half_edge(path[0]));  // goes on to the third corner
  return path;
}

// Shortest paths from the farthest vertices to the existing cut.
class ExtremitySeams {
 public:
  ExtremitySeams(const MeasuredMesh& surface, const Component& component, const SeamGraph& graph,
                 const CancelToken& cancel)
      : mesh_(surface.mesh()), graph_(graph), cancel_(cancel), paths_(graph) {
    // No point of a flat disk is farther from its rim than sqrt(A / pi). A surface whose rim is at least half
    // as long as that of a disk gets seams beyond that distance only; other surfaces get them beyond half of
    // it.
    double rim = 0;
    for (std::uint32_t h = 0; h < graph.opposite.size(); ++h)
      if (graph.opposite[h] == no_index) rim += surface.length(3 * component.triangle_begin + h);
    const double radius = std::sqrt(measured_area(surface, component) / std::numbers::pi);
    shortest_seam_ = rim >= std::numbers::pi * radius ? radius : 0.5 * radius;
    for (const std::uint32_t v : graph.loop_vertices) paths_.add_source(v);
    boundary_edges_ = static_cast<std::uint32_t>(graph.loop_vertices.size());
  }

  void add(std::vector<std::uint32_t> path) {
    for (const std::uint32_t h : path) {
      paths_.add_source(graph_.origin(h));
      paths_.add_source(graph_.target(h));
    }
    boundary_edges_ += 2 * static_cast<std::uint32_t>(path.size());
    seams_.insert(seams_.end(), path.begin(), path.end());
  }

  void grow(std::uint32_t count) {
    if (seams_.empty() && graph_.loop_count() == 0) {
      add(opening_path(mesh_, graph_, cancel_));
      count -= std::min(count, 2u);
    }
    while (count > 0 || boundary_edges_ < 3) {
      paths_.run(cancel_);
      const std::uint32_t tip = paths_.farthest();
      if (boundary_edges_ >= 3 && !(paths_.distance(tip) >= shortest_seam_ && paths_.distance(tip) > 0))
        break;
      add(paths_.path_to(paths_.distance(tip) > 0 ? tip : any_interior_vertex()));
      if (count > 0) --count;
    }
  }

  std::span<const std::uint32_t> half_edges() const { return seams_; }

 private:
  std::uint32_t any_interior_vertex() const {
    for (std::uint32_t v = 0; v < graph_.vertex_count(); ++v)
      if (paths_.arrival(v) != no_index) return v;
    throw ItemError(Status::internal, "cut_to_disk: a chart of two boundary edges without interior vertex");
  }

  const PreparedMesh& mesh_;
  const SeamGraph& graph_;
  const CancelToken& cancel_;
  ShortestPaths paths_;
  std::vector<std::uint32_t> seams_;
  double shortest_seam_ = 0;
  std::uint32_t boundary_edges_ = 0;
};

}  // namespace

CutChart cut_to_disk(const MeasuredMesh& surface, const Component& component, const CutParameters& parameters,
                     const CancelToken& cancel) {
  SeamGraph graph = make_seam_graph(surface, component);
  cancel.check();
  ExtremitySeams seams(surface, component, graph, cancel);
  seams.add(find_topology_seams(graph, cancel));
  if (graph.triangle_count() > 1) seams.grow(parameters.extremity_seams);

  CutChart chart;
  chart.triangle_begin = component.triangle_begin;
  chart.boundary_edges = static_cast<std::uint32_t>(graph.loop_vertices.size());
  const std::vector<std::uint32_t> opened(seams.half_edges().begin(), seams.half_edges().end());
  chart.triangles = std::move(graph.triangles);
  chart.opposite = std::move(graph.opposite);
  chart.source_vertex = std::move(graph.source_vertex);
  chart.seam.assign(chart.triangles.size(), 0);
  open_seams(chart, opened);
  require_disk(chart);
  return chart;
}

bool add_seam(const MeasuredMesh& surface, CutChart& chart, std::uint32_t chart_vertex,
              const CancelToken& cancel) {
  std::vector<std::uint32_t> leaving(chart.vertex_count(), no_index);  // one half-edge out of each vertex
  std::vector<std::uint8_t> on_boundary(chart.vertex_count(), 0);
  for (std::uint32_t h = 0; h < chart.triangles.size(); ++h) {
    leaving[chart.triangles[h]] = h;
    if (chart.opposite[h] == no_index) on_boundary[chart.triangles[h]] = 1;
  }
  if (on_boundary[chart_vertex]) return false;
  std::vector<double> distance(chart.vertex_count(), ShortestPaths::unreached);
  std::vector<std::uint32_t> arrival(chart.vertex_count(), no_index);
  RadixHeap heap;
  distance[chart_vertex] = 0;
  heap.push(0, chart_vertex);
  std::uint32_t reached = no_index;
  std::size_t steps = 0;
  while (!heap.empty()) {
    const RadixHeap::Entry entry = heap.pop();
    if (entry.key > distance[entry.value]) continue;
    if (on_boundary[entry.value]) {
      reached = entry.value;
      break;
    }
    if ((++steps & 0xFFFF) == 0) cancel.check();
    const std::uint32_t first = leaving[entry.value];
    std::uint32_t h = first;
    do {
      const std::uint32_t other = chart.triangles[next_half_edge(h)];
      const double d = entry.key + surface.length(3 * chart.triangle_begin + h);
      if (d < distance[other]) {
        distance[other] = d;
        arrival[other] = h;
        heap.push(d, other);
      }
      h = chart.opposite[previous_half_edge(h)];
    } while (h != first);
  }
  if (reached == no_index) throw ItemError(Status::internal, "add_seam: no way to the boundary of the chart");
  std::vector<std::uint32_t> path;
  for (std::uint32_t v = reached; v != chart_vertex; v = chart.triangles[arrival[v]])
    path.push_back(arrival[v]);
  open_seams(chart, path);
  return true;
}

}  // namespace meander
