#include "kernels/mesh/half_edges.h"

#include <algorithm>

namespace meander {

namespace {

struct Entry {
  std::uint32_t larger, half_edge;  // larger end of the edge
};

// A vertex has about six edges: insertion beats a general sort three times over. Entries come in order of
// half-edge, and insertion is stable. Fans of hundreds of triangles go to the general sort.
void sort_entries(std::vector<Entry>::iterator first, std::vector<Entry>::iterator last) {
  constexpr std::ptrdiff_t short_list = 32;
  if (last - first > short_list) {
    std::stable_sort(first, last, [](const Entry& a, const Entry& b) { return a.larger < b.larger; });
    return;
  }
  for (auto at = first; at != last; ++at) {
    const Entry moving = *at;
    auto to = at;
    for (; to != first && (to - 1)->larger > moving.larger; --to) *to = *(to - 1);
    *to = moving;
  }
}

}  // namespace

std::uint32_t pair_half_edges(std::span<const std::uint32_t> triangles, std::size_t vertex_count,
                              std::vector<std::uint32_t>& opposite) {
  const auto count = static_cast<std::uint32_t>(triangles.size());
  opposite.assign(count, no_index);
  std::vector<std::uint32_t> begin(vertex_count + 1, 0);
  const auto ends = [&](std::uint32_t h) { return std::minmax(triangles[h], triangles[next_half_edge(h)]); };
  for (std::uint32_t h = 0; h < count; ++h) ++begin[ends(h).first + 1];
  for (std::size_t v = 0; v < vertex_count; ++v) begin[v + 1] += begin[v];
  std::vector<Entry> entries(count);
  {
    std::vector<std::uint32_t> at(begin.begin(), begin.end() - 1);
    for (std::uint32_t h = 0; h < count; ++h) {
      const auto [smaller, larger] = ends(h);
      entries[at[smaller]++] = {larger, h};
    }
  }
  std::uint32_t crowded = 0;
  for (std::size_t v = 0; v < vertex_count; ++v) {
    const auto first = entries.begin() + begin[v], last = entries.begin() + begin[v + 1];
    sort_entries(first, last);
    for (auto e = first; e != last;) {
      auto group_end = e + 1;
      while (group_end != last && group_end->larger == e->larger) ++group_end;
      if (group_end - e == 2) {
        opposite[e->half_edge] = (e + 1)->half_edge;
        opposite[(e + 1)->half_edge] = e->half_edge;
      } else if (group_end - e > 2) {
        ++crowded;
      }
      e = group_end;
    }
  }
  return crowded;
}

std::uint32_t number_fans(std::span<const std::uint32_t> opposite, std::vector<std::uint32_t>& vertex) {
  const auto count = static_cast<std::uint32_t>(opposite.size());
  vertex.assign(count, no_index);
  std::uint32_t fans = 0;
  for (std::uint32_t h = 0; h < count; ++h) {
    if (vertex[h] != no_index) continue;
    std::uint32_t at = h;
    while (at != no_index && vertex[at] == no_index) {  // one way round, until the start or a boundary
      vertex[at] = fans;
      at = opposite[previous_half_edge(at)];
    }
    at = opposite[h] == no_index ? no_index : next_half_edge(opposite[h]);
    while (at != no_index && vertex[at] == no_index) {  // and the other way
      vertex[at] = fans;
      at = opposite[at] == no_index ? no_index : next_half_edge(opposite[at]);
    }
    ++fans;
  }
  return fans;
}

std::uint32_t next_boundary_half_edge(std::span<const std::uint32_t> opposite, std::uint32_t h) {
  std::uint32_t at = next_half_edge(h);
  while (opposite[at] != no_index) at = next_half_edge(opposite[at]);
  return at;
}

}  // namespace meander
