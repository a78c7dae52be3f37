#include "kernels/cut/open_seams.h"

#include <string>
#include <vector>

namespace meander {

namespace {

// Gives every corner of the fan that starts at boundary half-edge `first`, which leaves the vertex, the index
// `vertex`.
void relabel_fan(CutChart& chart, std::uint32_t first, std::uint32_t vertex) {
  std::uint32_t h = first;
  do {
    chart.triangles[h] = vertex;
    h = chart.opposite[previous_half_edge(h)];
  } while (h != no_index && h != first);
}

[[noreturn]] void fail(const std::string& what) { throw ItemError(Status::internal, "cut_to_disk: " + what); }

std::size_t reachable_triangles(const CutChart& chart) {
  std::vector<std::uint8_t> seen(chart.triangle_count(), 0);
  std::vector<std::uint32_t> stack = {0};
  seen[0] = 1;
  std::size_t count = 0;
  while (!stack.empty()) {
    const std::uint32_t t = stack.back();
    stack.pop_back();
    ++count;
    for (std::uint32_t h = 3 * t; h < 3 * t + 3; ++h) {
      const std::uint32_t other = chart.opposite[h];
      if (other == no_index || seen[other / 3]) continue;
      seen[other / 3] = 1;
      stack.push_back(other / 3);
    }
  }
  return count;
}

}  // namespace

void open_seams(CutChart& chart, std::span<const std::uint32_t> half_edges) {
  if (half_edges.empty()) return;
  std::vector<std::uint8_t> claimed(chart.vertex_count(), 0);  // by a boundary fan
  for (std::uint32_t h = 0; h < chart.opposite.size(); ++h)
    if (chart.opposite[h] == no_index) claimed[chart.triangles[h]] = 1;
  std::vector<std::uint32_t> opened;
  opened.reserve(2 * half_edges.size());
  for (const std::uint32_t h : half_edges) {
    const std::uint32_t other = chart.opposite[h];
    if (other == no_index) continue;
    chart.opposite[h] = chart.opposite[other] = no_index;
    chart.seam[h] = chart.seam[other] = 1;
    opened.push_back(h);
    opened.push_back(other);
  }
  for (const std::uint32_t h : opened) {
    const std::uint32_t vertex = chart.triangles[h];
    if (!claimed[vertex]) {
      claimed[vertex] = 1;
      continue;
    }
    const auto copy = static_cast<std::uint32_t>(chart.vertex_count());
    chart.source_vertex.push_back(chart.source_vertex[vertex]);
    claimed.push_back(1);
    relabel_fan(chart, h, copy);
  }
  chart.boundary_edges += static_cast<std::uint32_t>(opened.size());
}

void require_disk(const CutChart& chart) {
  if (chart.triangle_count() == 0) fail("a chart without triangles");
  if (reachable_triangles(chart) != chart.triangle_count()) fail("the chart fell apart");
  std::vector<std::uint32_t> outgoing(chart.vertex_count(), no_index);
  std::uint32_t boundary = 0, start = no_index;
  for (std::uint32_t h = 0; h < chart.opposite.size(); ++h) {
    if (chart.opposite[h] != no_index) continue;
    if (outgoing[chart.triangles[h]] != no_index) fail("the boundary meets a vertex twice");
    outgoing[chart.triangles[h]] = h;
    start = h;
    ++boundary;
  }
  const auto edges = static_cast<std::int64_t>((chart.triangles.size() + boundary) / 2);
  const std::int64_t chi = static_cast<std::int64_t>(chart.vertex_count()) - edges +
                           static_cast<std::int64_t>(chart.triangle_count());
  if (chi != 1) fail("the Euler characteristic is " + std::to_string(chi) + " instead of 1");
  std::uint32_t length = 0;
  for (std::uint32_t h = start; h != no_index && length <= boundary; ++length) {
    h = outgoing[chart.triangles[next_half_edge(h)]];
    if (h == start) {
      ++length;
      break;
    }
  }
  if (length != boundary || boundary != chart.boundary_edges || boundary < 3)
    fail("a boundary loop of " + std::to_string(length) + " edges where " + std::to_string(boundary) +
         " (counted " + std::to_string(chart.boundary_edges) + ") were expected");
}

}  // namespace meander
