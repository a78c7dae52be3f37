#include "kernels/mesh/half_edges.h"

#include <algorithm>
#include <numeric>

namespace meander {

namespace {

struct Entry {
  std::uint32_t larger, half_edge;  // larger end of the edge
};

// Pairs the half-edges of one vertex's list: partners are the two entries of an edge that has just two.
// Returns the number of edges with more. A list has about six entries: a full scan without early exits beats
// sorting. O(n^2), the list is used up.
std::uint32_t pair_by_scanning(std::span<Entry> list, std::vector<std::uint32_t>& opposite) {
  std::uint32_t crowded = 0;
  for (std::size_t left = list.size(); left > 1;) {
    const Entry entry = list[--left];
    std::size_t matches = 0, match = 0;
    for (std::size_t i = 0; i < left; ++i) {
      const bool same = list[i].larger == entry.larger;
      matches += same;
      match = same ? i : match;
    }
    if (matches == 1) {
      opposite[entry.half_edge] = list[match].half_edge;
      opposite[list[match].half_edge] = entry.half_edge;
      list[match] = list[--left];
    } else if (matches > 1) {
      ++crowded;
      const auto rest = list.first(left);
      const auto end = std::remove_if(rest.begin(), rest.end(),
                                      [&](const Entry& other) { return other.larger == entry.larger; });
      left = static_cast<std::size_t>(end - rest.begin());
    }
  }
  return crowded;
}

// The same for fans of hundreds of triangles. O(n log n).
std::uint32_t pair_by_sorting(std::span<Entry> list, std::vector<std::uint32_t>& opposite) {
  std::sort(list.begin(), list.end(), [](const Entry& a, const Entry& b) { return a.larger < b.larger; });
  std::uint32_t crowded = 0;
  for (auto entry = list.begin(); entry != list.end();) {
    auto end = entry + 1;
    while (end != list.end() && end->larger == entry->larger) ++end;
    if (end - entry == 2) {
      opposite[entry[0].half_edge] = entry[1].half_edge;
      opposite[entry[1].half_edge] = entry[0].half_edge;
    }
    crowded += end - entry > 2;
    entry = end;
  }
  return crowded;
}

}  // namespace

std::uint32_t pair_half_edges(std::span<const std::uint32_t> triangles, std::size_t vertex_count,
                              std::vector<std::uint32_t>& opposite) {
  constexpr std::size_t short_list = 32;
  opposite.assign(triangles.size(), no_index);
  const auto each_half_edge = [&](const auto& body) {
    for (std::uint32_t h = 0; h < triangles.size(); h += 3) {
      const std::uint32_t a = triangles[h], b = triangles[h + 1], c = triangles[h + 2];
      body(h, a, b);
      body(h + 1, b, c);
      body(h + 2, c, a);
    }
  };
  std::vector<std::uint32_t> end(vertex_count + 1, 0);  // of the list of every vertex, shifted by one
  each_half_edge([&](std::uint32_t, std::uint32_t a, std::uint32_t b) { ++end[std::min(a, b) + 1]; });
  std::partial_sum(end.begin(), end.end(), end.begin());
  std::vector<Entry> entries(triangles.size());
  each_half_edge([&](std::uint32_t h, std::uint32_t a, std::uint32_t b) {
    entries[end[std::min(a, b)]++] = {std::max(a, b), h};
  });
  std::uint32_t crowded = 0;
  for (std::size_t v = 0, begin = 0; v < vertex_count; begin = end[v++]) {
    const std::span<Entry> list = std::span(entries).subspan(begin, end[v] - begin);
    crowded += list.size() <= short_list ? pair_by_scanning(list, opposite) : pair_by_sorting(list, opposite);
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
