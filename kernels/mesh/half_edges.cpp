#include "kernels/mesh/half_edges.h"

#include <algorithm>
#include <array>
#include <bit>
#include <numeric>
#include <utility>

#include "kernels/core/large_vector.h"
#include "kernels/core/parallel.h"
#include "kernels/core/vector_instructions.h"

namespace meander {

namespace {

constexpr std::size_t star_block = 32768;

// Results of pairing many stars.
struct Findings {
  std::uint32_t* opposite = nullptr;
  std::uint32_t crowded = 0;  // edges of more than two triangles
  bool same_way = false;      // the two triangles of some edge run along it in the same direction
};

// The corners at one vertex, with one half-edge each that starts there. 8 more entries can be read.
struct OutgoingEdges {
  std::uint32_t vertex;
  std::size_t size;
  const std::uint32_t* half_edges;
  const std::uint32_t* next;      // the vertex where the half-edge ends
  const std::uint32_t* previous;  // the vertex where the half-edge before it starts
};

// Eight entries of a list.
struct Eight {
  __m128i first, second;

  explicit Eight(const std::uint32_t* at)
      : first(_mm_loadu_si128(reinterpret_cast<const __m128i*>(at))),
        second(_mm_loadu_si128(reinterpret_cast<const __m128i*>(at + 4))) {}
  // Sixteen-bit lanes, all ones where an entry is `value`.
  __m128i equal(__m128i value) const {
    return _mm_packs_epi32(_mm_cmpeq_epi32(first, value), _mm_cmpeq_epi32(second, value));
  }
  void store(std::uint32_t* at) const {
    _mm_storeu_si128(reinterpret_cast<__m128i*>(at), first);
    _mm_storeu_si128(reinterpret_cast<__m128i*>(at + 4), second);
  }
};

__m128i previous_half_edges(__m128i h) {
  // Multiples of 3 are the numbers whose product with the inverse of 3 is at most (2^32 - 1) / 3.
  const __m128i third = _mm_set1_epi32(0x55555555);
  const __m128i product = _mm_mullo_epi32(h, _mm_set1_epi32(static_cast<int>(0xAAAAAAABu)));
  const __m128i first_of_three = _mm_cmpeq_epi32(_mm_min_epu32(product, third), product);
  return _mm_add_epi32(_mm_add_epi32(h, _mm_set1_epi32(-1)),
                       _mm_and_si128(first_of_three, _mm_set1_epi32(3)));
}

// Sets bit k for the corner k whose next vertex is `value`, and bit 8 + k for the corner k whose previous one
// is.
std::uint32_t incidences(const Eight& next, const Eight& previous, std::uint32_t value) {
  const __m128i all = _mm_set1_epi32(static_cast<int>(value));
  return static_cast<std::uint32_t>(_mm_movemask_epi8(_mm_packs_epi16(next.equal(all), previous.equal(all))));
}

// Stars of up to 8 corners: nearly all.
struct SmallStar {
  using Bits = std::uint32_t;
  static constexpr std::size_t capacity = 8;
  Eight next, previous;
  Bits valid;

  explicit SmallStar(const OutgoingEdges& star)
      : next(star.next), previous(star.previous), valid(((Bits{1} << star.size) - 1) * 0x101) {}
  Bits at(std::uint32_t value) const { return incidences(next, previous, value) & valid; }
};

// Stars of up to 31 corners.
struct MediumStar {
  using Bits = std::uint64_t;
  static constexpr std::size_t capacity = 32;
  const OutgoingEdges& star;
  Bits valid;

  explicit MediumStar(const OutgoingEdges& of) : star(of), valid(((Bits{1} << of.size) - 1) * 0x100000001) {}
  Bits at(std::uint32_t value) const {
    Bits bits = 0;
    for (std::size_t k = 0; k < star.size; k += 8) {
      const Bits found = incidences(Eight(star.next + k), Eight(star.previous + k), value);
      bits |= (found & 0xFF) << k | (found >> 8) << (capacity + k);
    }
    return bits & valid;
  }
};

// Pairs the half-edges that start at a vertex: partners are the two half-edges of an edge that has just two.
// Compares all corners with each other, without branches: stars have about six corners, and sorting or
// hashing them costs more. Returns whether faces around the vertex join all its corners; false may also mean
// that this is unknown.
template <class Corners>
bool pair_star(const OutgoingEdges& star, Findings& findings) {
  using Bits = typename Corners::Bits;
  constexpr std::size_t capacity = Corners::capacity, none = 2 * capacity;
  const Corners corners(star);
  std::array<std::uint32_t, none + 1> partner;
  for (std::size_t k = 0; k < (capacity == 8 ? capacity : star.size); k += 8) {
    Eight half_edges(star.half_edges + k);
    half_edges.store(&partner[k]);
    half_edges.first = previous_half_edges(half_edges.first);
    half_edges.second = previous_half_edges(half_edges.second);
    half_edges.store(&partner[capacity + k]);
  }
  partner[none] = no_index;
  // Behind the half-edge of every corner: an index of `partner`.
  std::array<std::uint8_t, capacity + 1> following;
  Bits partners = 0;
  const Bits end = none < 8 * sizeof(Bits) ? Bits{1} << none % (8 * sizeof(Bits)) : 0;
  for (std::size_t i = 0; i < star.size; ++i) {
    const Bits found = corners.at(star.next[i]), others = found ^ (Bits{1} << i);
    const Bits one = (others & (others - 1)) == 0 ? others : 0;
    const auto index = static_cast<std::size_t>(std::countr_zero(one | end));
    findings.opposite[star.half_edges[i]] = partner[index];
    following[i] = static_cast<std::uint8_t>(index);
    partners |= one;
    if (one != others) [[unlikely]] {
      // Counted once: at the lower end, or at the end where all its half-edges start.
      const bool here = found >> capacity == 0 || star.vertex < star.next[i];
      findings.crowded += here && (found & ((Bits{1} << i) - 1)) == 0;
    }
  }
  const Bits reached = partners >> capacity;
  const bool same_way = partners != reached << capacity;
  findings.same_way |= same_way;
  const auto open = star.size - static_cast<std::size_t>(std::popcount(reached));
  if (same_way || open > 1) return false;
  // An open fan is closed by going from its end to its first corner, the only one without a predecessor.
  const auto first = open == 0 ? std::size_t{0} : static_cast<std::size_t>(std::countr_one(reached));
  following[capacity] = static_cast<std::uint8_t>(capacity + first);
  std::size_t returns = 0, at = first;
  for (std::size_t step = 0; step < star.size + open; ++step) {
    at = following[at] - capacity;
    returns += at == first;
  }
  return returns == 1 && at == first;
}

// The same for fans of many triangles. O(n log n).
void pair_by_sorting(const OutgoingEdges& star, Findings& findings) {
  // The vertex at the other end, then 2 i where the half-edge of corner i leaves and 2 i + 1 where one
  // arrives.
  std::vector<std::uint64_t> ends(2 * star.size);
  for (std::size_t i = 0; i < star.size; ++i) {
    ends[2 * i] = std::uint64_t{star.next[i]} << 32 | 2 * i;
    ends[2 * i + 1] = std::uint64_t{star.previous[i]} << 32 | (2 * i + 1);
  }
  std::sort(ends.begin(), ends.end());
  const auto leaves = [&](std::size_t k) { return ends[k] % 2 == 0; };
  const auto half_edge = [&](std::size_t k) {
    const std::uint32_t h = star.half_edges[static_cast<std::uint32_t>(ends[k]) / 2];
    return leaves(k) ? h : previous_half_edge(h);
  };
  for (std::size_t begin = 0, end = 0; begin < ends.size(); begin = end) {
    const std::uint64_t vertex = ends[begin] >> 32;
    std::size_t leaving = 0;
    for (end = begin; end < ends.size() && ends[end] >> 32 == vertex; ++end) leaving += leaves(end);
    const bool paired = end - begin == 2;
    for (std::size_t k = begin; k < end; ++k)
      if (leaves(k)) findings.opposite[half_edge(k)] = paired ? half_edge(begin + end - 1 - k) : no_index;
    findings.same_way |= paired && leaving == 2;
    findings.crowded += end - begin > 2 && leaving > 0 && (leaving == end - begin || star.vertex < vertex);
  }
}

// Calls part(is_own) for a range of vertices a thread, or one range where vertices are few; is_own(vertex)
// says whether a vertex is in the range. Each part looks at all triangles, and no two parts count at one
// vertex.
template <class Part>
void in_parts(std::size_t vertex_count, const Part& part) {
  constexpr std::size_t many = std::size_t{1} << 18, max_parts = 4;
  const std::size_t parts = ranges_for_threads(vertex_count, many, max_parts);
  if (parts == 1) {
    part([](std::uint32_t) { return true; });
    return;
  }
  parallel_tasks(parts, [&](std::size_t p) {
    const auto first = static_cast<std::uint32_t>(vertex_count * p / parts),
               past = static_cast<std::uint32_t>(vertex_count * (p + 1) / parts);
    part([first, past](std::uint32_t vertex) { return vertex - first < past - first; });
  });
}

}  // namespace

std::uint32_t pair_half_edges(std::span<const std::uint32_t> triangles, std::size_t vertex_count,
                              std::vector<std::uint32_t>& opposite, FanSurvey* survey) {
  resize_large(opposite, triangles.size());
  if (survey != nullptr) survey->one_fan.assign(vertex_count, 1);
  // The end of the star of every vertex, shifted by one.
  std::vector<std::uint32_t> end;
  assign_large(end, vertex_count + 1, 0u);
  in_parts(vertex_count, [&](const auto& is_own) {
    for (const std::uint32_t v : triangles)
      if (is_own(v)) ++end[v + 1];
  });
  std::partial_sum(end.begin(), end.end(), end.begin());
  const std::size_t room = triangles.size() + 8;
  const auto lists = make_large<std::uint32_t>(3 * room);
  std::uint32_t *const half_edges = lists.get(), *const next = half_edges + room,
                       *const previous = next + room;
  for (std::uint32_t* const list : {half_edges, next, previous}) std::fill_n(list + triangles.size(), 8, 0u);
  in_parts(vertex_count, [&](const auto& is_own) {
    const auto add = [&](std::uint32_t h, std::uint32_t v, std::uint32_t after, std::uint32_t before) {
      if (!is_own(v)) return;
      const std::uint32_t to = end[v]++;
      half_edges[to] = h;
      next[to] = after;
      previous[to] = before;
    };
    for (std::uint32_t h = 0; h < triangles.size(); h += 3) {
      const std::uint32_t a = triangles[h], b = triangles[h + 1], c = triangles[h + 2];
      add(h, a, b, c);
      add(h + 1, b, c, a);
      add(h + 2, c, a, b);
    }
  });
  // Every half-edge is in one star.
  std::vector<Findings> found((vertex_count + star_block - 1) / star_block, Findings{opposite.data()});
  parallel_blocks(vertex_count, star_block, [&](std::size_t first, std::size_t last) {
    Findings findings = found[first / star_block];
    for (std::size_t v = first, begin = first == 0 ? 0 : end[first - 1]; v < last; begin = end[v++]) {
      const OutgoingEdges star{static_cast<std::uint32_t>(v), end[v] - begin, half_edges + begin,
                               next + begin, previous + begin};
      if (star.size == 0) continue;
      bool one_fan = false;
      if (star.size <= SmallStar::capacity)
        one_fan = pair_star<SmallStar>(star, findings);
      else if (star.size < MediumStar::capacity)
        one_fan = pair_star<MediumStar>(star, findings);
      else
        pair_by_sorting(star, findings);
      if (survey != nullptr) survey->one_fan[v] = one_fan;
    }
    found[first / star_block] = findings;
  });
  Findings all{};
  for (const Findings& findings : found) {
    all.crowded += findings.crowded;
    all.same_way |= findings.same_way;
  }
  if (survey != nullptr) survey->consistent = !all.same_way;
  return all.crowded;
}

std::uint32_t number_fans(std::span<const std::uint32_t> opposite, std::vector<std::uint32_t>& vertex) {
  const auto count = static_cast<std::uint32_t>(opposite.size());
  vertex.assign(count, no_index);
  std::uint32_t fans = 0;
  for (std::uint32_t h = 0; h < count; ++h) {
    if (vertex[h] != no_index) continue;
    for_fan(opposite, h,
            [&](std::uint32_t corner) { return std::exchange(vertex[corner], fans) == no_index; });
    ++fans;
  }
  return fans;
}

std::vector<std::uint8_t> boundary_vertices(std::span<const std::uint32_t> triangles,
                                            std::span<const std::uint32_t> opposite,
                                            std::size_t vertex_count) {
  std::vector<std::uint8_t> boundary(vertex_count, 0);
  for (std::uint32_t h = 0; h < opposite.size(); ++h)
    if (opposite[h] == no_index) boundary[triangles[h]] = boundary[triangles[next_half_edge(h)]] = 1;
  return boundary;
}

std::uint32_t next_boundary_half_edge(std::span<const std::uint32_t> opposite, std::uint32_t h) {
  std::uint32_t at = next_half_edge(h);
  while (opposite[at] != no_index) at = next_half_edge(opposite[at]);
  return at;
}

}  // namespace meander
