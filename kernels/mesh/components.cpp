#include "kernels/mesh/components.h"

#include <algorithm>
#include <numeric>
#include <string>
#include <utility>

#include "kernels/core/disjoint_sets.h"
#include "kernels/core/large_vector.h"
#include "kernels/core/parallel.h"
#include "kernels/core/radix_sort.h"
#include "kernels/curve/curve_key.h"
#include "kernels/mesh/half_edges.h"

namespace meander {

namespace {

// Breadth-first search over the edges between the triangles [begin, end). Numbers components from 0 on in the
// order of their first triangles, and calls leave(from, to) for every triangle of the range and each neighbor
// behind the range. `is_all`: the mesh has no other triangles.
template <bool is_all, class Leave>
std::uint32_t search_range(std::span<const std::uint32_t> opposite, std::uint32_t begin, std::uint32_t end,
                           std::span<std::uint32_t> component, std::span<std::uint32_t> queue,
                           const Leave& leave, const CancelToken& cancel) {
  std::size_t queued = 0;
  std::uint32_t components = 0;
  for (std::uint32_t seed = begin; queued < end - begin; ++seed) {
    if (component[seed] != no_index) continue;
    std::size_t at = queued;
    queue[queued++] = seed;
    component[seed] = components;
    for (; at < queued; ++at) {
      if (at % 65536 == 0) cancel.check();
      const std::uint32_t t = queue[at];
      for (std::uint32_t h = 3 * t; h < 3 * t + 3; ++h) {
        const std::uint32_t neighbor = opposite[h] == no_index ? t : opposite[h] / 3;
        if constexpr (!is_all)
          if (neighbor < begin || neighbor >= end) {
            if (neighbor >= end) leave(t, neighbor);
            continue;
          }
        // The entry is always written, and stays if it is new. Most are not, and a branch on it could not be
        // predicted.
        queue[queued] = neighbor;
        queued += component[neighbor] == no_index;
        component[neighbor] = components;
      }
    }
    ++components;
  }
  return components;
}

// Searches each range of triangles in a thread, then joins components of different ranges that share an edge.
// Numbers stay those of the first triangles.
std::uint32_t find_components_in_ranges(std::span<const std::uint32_t> opposite, std::size_t ranges,
                                        std::span<std::uint32_t> component, std::span<std::uint32_t> queue,
                                        const CancelToken& cancel) {
  const std::size_t count = component.size();
  struct Range {
    std::uint32_t begin, end, components = 0, first_component = 0;
    // Pairs of a triangle of the range and a neighbor behind the range.
    std::vector<std::pair<std::uint32_t, std::uint32_t>> left;
  };
  std::vector<Range> range(ranges);
  parallel_tasks(ranges, [&](std::size_t r) {
    Range& own = range[r];
    own.begin = static_cast<std::uint32_t>(count * r / ranges);
    own.end = static_cast<std::uint32_t>(count * (r + 1) / ranges);
    own.components = search_range<false>(
        opposite, own.begin, own.end, component, queue.subspan(own.begin + r),
        [&](std::uint32_t from, std::uint32_t to) { own.left.emplace_back(from, to); }, cancel);
  });
  // Where faces are in no order, most edges leave their range, and joining costs more than one search.
  std::size_t left = 0;
  for (const Range& own : range) left += own.left.size();
  if (left > count / 8) {
    range.clear();
    std::fill(component.begin(), component.end(), no_index);
    return search_range<true>(
        opposite, 0, static_cast<std::uint32_t>(count), component, queue, [](auto, auto) {}, cancel);
  }
  cancel.check();
  std::uint32_t parts = 0;
  for (Range& own : range) own.first_component = std::exchange(parts, parts + own.components);
  const auto part_of = [&](std::uint32_t t) {
    const auto own =
        std::partition_point(range.begin(), range.end(), [t](const Range& r) { return r.end <= t; });
    return own->first_component + component[t];
  };
  DisjointSets joined(parts);
  for (const Range& own : range)
    for (const auto& [from, to] : own.left) joined.join(own.first_component + component[from], part_of(to));
  // Parts are in the order of their first triangles.
  std::vector<std::uint32_t> number(parts), of_root(parts, no_index);
  std::uint32_t components = 0;
  for (std::uint32_t part = 0; part < parts; ++part) {
    std::uint32_t& own = of_root[joined.find(part)];
    if (own == no_index) own = components++;
    number[part] = own;
  }
  parallel_tasks(ranges, [&](std::size_t r) {
    const Range& own = range[r];
    for (std::uint32_t t = own.begin; t < own.end; ++t)
      component[t] = number[own.first_component + component[t]];
  });
  return components;
}

}  // namespace

std::uint32_t find_components(std::span<const std::uint32_t> opposite, std::vector<std::uint32_t>& component,
                              const CancelToken& cancel) {
  constexpr std::size_t many = std::size_t{1} << 19, max_ranges = 8;
  const std::size_t count = opposite.size() / 3;
  const std::size_t ranges = ranges_for_threads(count, many, max_ranges);
  assign_large(component, count, no_index);
  // Each range writes one entry behind its last.
  std::vector<std::uint32_t> queue;
  resize_large(queue, count + ranges);
  if (ranges > 1) return find_components_in_ranges(opposite, ranges, component, queue, cancel);
  return search_range<true>(
      opposite, 0, static_cast<std::uint32_t>(count), component, queue, [](auto, auto) {}, cancel);
}

std::vector<std::uint32_t> places_along_curve(std::span<const CentroidSum> components) {
  std::vector<std::uint64_t> key(components.size());
  for (std::size_t c = 0; c < key.size(); ++c) key[c] = hilbert_key_3d(components[c].centroid());
  // A word has the leading bits of the key, then the number. These bits mostly decide, and words are sorted
  // faster than numbers whose keys are elsewhere. Components with the same leading bits are sorted again.
  constexpr int number_bits = 28, key_bits = 63;
  constexpr std::uint64_t numbers = std::uint64_t{1} << number_bits;
  std::vector<std::uint32_t> order(key.size()), place(key.size());
  const auto by_key = [&](std::uint32_t a, std::uint32_t b) { return key[a] < key[b]; };
  if (key.size() <= numbers) {
    std::vector<std::uint64_t> words(key.size()), scratch;
    for (std::size_t c = 0; c < words.size(); ++c)
      words[c] = key[c] >> (key_bits + number_bits - 64) << number_bits | c;
    radix_sort_words(words, scratch, number_bits);
    for (std::size_t i = 0; i < words.size(); ++i) order[i] = static_cast<std::uint32_t>(words[i] % numbers);
    for (std::size_t begin = 0, end = 0; begin < words.size(); begin = end) {
      bool sorted = true;
      for (end = begin + 1; end < words.size() && words[end] / numbers == words[begin] / numbers; ++end)
        sorted = sorted && !by_key(order[end], order[end - 1]);
      const auto first = order.begin();
      if (!sorted)
        std::stable_sort(first + static_cast<std::ptrdiff_t>(begin), first + static_cast<std::ptrdiff_t>(end),
                         by_key);
    }
  } else {
    std::iota(order.begin(), order.end(), 0u);
    std::stable_sort(order.begin(), order.end(), by_key);
  }
  for (std::uint32_t i = 0; i < order.size(); ++i) place[order[i]] = i;
  return place;
}

void describe_components(PreparedMesh& out) {
  std::vector<std::uint8_t> visited;
  assign_large(visited, out.opposite.size(), std::uint8_t{0});
  std::uint32_t next_vertex = 0;
  for (Component& c : out.components) {
    c.vertex_begin = next_vertex;
    std::uint32_t boundary = 0;
    double area = 0;
    for (std::uint32_t t = c.triangle_begin; t < c.triangle_end; ++t) {
      area += out.area[t];
      for (std::uint32_t h = 3 * t; h < 3 * t + 3; ++h) {
        next_vertex = std::max(next_vertex, out.triangles[h] + 1);  // fans are numbered in triangle order
        if (out.opposite[h] != no_index) continue;
        ++boundary;
        if (visited[h]) continue;
        ++c.boundary_loops;
        for (std::uint32_t at = h; !visited[at]; at = next_boundary_half_edge(out.opposite, at))
          visited[at] = 1;
      }
    }
    c.vertex_end = next_vertex;
    c.area = area;
    const std::int64_t faces = c.triangle_end - c.triangle_begin, edges = (3 * faces + boundary) / 2;
    const std::int64_t euler = std::int64_t{c.vertex_end} - c.vertex_begin - edges + faces;
    const std::int64_t twice_genus = 2 - std::int64_t{c.boundary_loops} - euler;
    if (twice_genus < 0 || twice_genus % 2 != 0)
      throw ItemError(Status::internal, "a component of Euler number " + std::to_string(euler) + " with " +
                                            std::to_string(c.boundary_loops) +
                                            " boundary loops is no oriented surface");
    c.genus = static_cast<std::uint32_t>(twice_genus / 2);
  }
}

}  // namespace meander
