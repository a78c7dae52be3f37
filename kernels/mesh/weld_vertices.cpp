#include "kernels/mesh/weld_vertices.h"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <optional>
#include <tuple>

#include "kernels/core/large_vector.h"
#include "kernels/core/parallel.h"

namespace meander {

namespace {

std::uint32_t hash_of_position(double x, double y, double z) {
  const auto bits = [](double c) { return std::bit_cast<std::uint64_t>(c + 0.0); };  // -0 + 0 = 0
  std::uint64_t hash = bits(x);
  hash = (hash ^ (hash >> 32)) * 0x9E3779B97F4A7C15u + bits(y);
  hash = (hash ^ (hash >> 29)) * 0xBF58476D1CE4E5B9u + bits(z);
  hash = (hash ^ (hash >> 32)) * 0x94D049BB133111EBu;
  return static_cast<std::uint32_t>(hash ^ (hash >> 31));
}

constexpr std::size_t block_vertices = 16384, many_vertices = std::size_t{1} << 18, max_parts = 4;

// Hashes that occurred once and hashes that occurred again, one bit each.
struct HashMarks {
  std::uint64_t once = 0, again = 0;
};

// Looks the vertices up in a table by their hashes in `welded`, where each becomes the first vertex at its
// position. Returns how many were not the first, or nothing where the hashes collide so badly that searches
// get long: such positions are adversarial, and the partial table is useless.
std::optional<std::uint32_t> weld_by_hash(const PolygonMesh& mesh,
                                          const std::vector<std::vector<std::uint32_t>>& vertices,
                                          std::size_t count, std::vector<std::uint32_t>& welded) {
  const double *const x = mesh.x.data(), *const y = mesh.y.data(), *const z = mesh.z.data();
  const std::size_t slots = std::bit_ceil(2 * count + 2);
  std::vector<std::uint32_t> table(slots, no_index);
  std::uint32_t again = 0;
  // A table that is half full takes one or two steps a vertex.
  std::uint64_t steps_left = 64 * std::uint64_t{count} + 4096;
  for (const std::vector<std::uint32_t>& own : vertices)
    for (const std::uint32_t v : own) {
      // Rotated, because vertices that share a mark share the low bits of the hash.
      std::size_t slot = std::rotl(welded[v], 16) & (slots - 1);
      for (; table[slot] != no_index; slot = (slot + 1) & (slots - 1)) {
        const std::uint32_t other = table[slot];
        if (x[other] == x[v] && y[other] == y[v] && z[other] == z[v]) break;
        if (steps_left-- == 0) return std::nullopt;
      }
      again += table[slot] != no_index;
      if (table[slot] == no_index) table[slot] = v;
      welded[v] = table[slot];
    }
  return again;
}

// The same by sorting.
std::uint32_t weld_by_order(const PolygonMesh& mesh, const std::vector<std::vector<std::uint32_t>>& vertices,
                            std::size_t count, std::vector<std::uint32_t>& welded) {
  std::vector<std::uint32_t> order;
  order.reserve(count);
  for (const std::vector<std::uint32_t>& own : vertices) order.insert(order.end(), own.begin(), own.end());
  const auto at = [&](std::uint32_t v) { return std::tie(mesh.x[v], mesh.y[v], mesh.z[v]); };
  std::sort(order.begin(), order.end(),
            [&](std::uint32_t a, std::uint32_t b) { return at(a) < at(b) || (at(a) == at(b) && a < b); });
  std::uint32_t again = 0;
  for (std::size_t i = 0; i < order.size(); ++i) {
    const bool first = i == 0 || at(order[i]) != at(order[i - 1]);
    welded[order[i]] = first ? order[i] : welded[order[i - 1]];
    again += !first;
  }
  return again;
}

std::uint32_t weld_shared(const PolygonMesh& mesh, const std::vector<std::vector<std::uint32_t>>& vertices,
                          std::size_t count, std::vector<std::uint32_t>& welded) {
  if (const auto again = weld_by_hash(mesh, vertices, count, welded)) return *again;
  return weld_by_order(mesh, vertices, count, welded);
}

}  // namespace

std::vector<std::uint32_t> weld_vertices(const PolygonMesh& mesh, std::span<const std::uint8_t> used,
                                         RepairCounts& repairs) {
  // In most files hardly any two positions are equal. So hashes are marked first, 16 bits or more a vertex,
  // and only vertices that share a mark are looked up in a table.
  const double *const x = mesh.x.data(), *const y = mesh.y.data(), *const z = mesh.z.data();
  const std::size_t count = mesh.vertex_count(), blocks = (count + block_vertices - 1) / block_vertices;
  std::vector<std::uint32_t> welded;  // at first the hash
  resize_large(welded, count);
  std::vector<HashMarks> marks(std::bit_ceil(count / 4 + 1));
  const std::size_t last_mark = marks.size() - 1;
  const auto mark = [&](std::size_t v, std::size_t at) {
    HashMarks& marks_there = marks[at];
    const std::uint64_t bit = std::uint64_t{used[v]} << welded[v] % 64;
    marks_there.again |= marks_there.once & bit;
    marks_there.once |= bit;
  };
  const std::size_t parts = ranges_for_threads(count, many_vertices, max_parts);
  if (parts == 1) {
    for (std::size_t v = 0; v < count; ++v) {
      welded[v] = hash_of_position(x[v], y[v], z[v]);
      mark(v, welded[v] / 64 & last_mark);
    }
  } else {
    parallel_blocks(count, block_vertices, [&](std::size_t begin, std::size_t end) {
      for (std::size_t v = begin; v < end; ++v) welded[v] = hash_of_position(x[v], y[v], z[v]);
    });
    // Every thread looks at all hashes and makes the marks of its own range.
    parallel_tasks(parts, [&](std::size_t part) {
      const std::size_t first = marks.size() * part / parts, past = marks.size() * (part + 1) / parts;
      for (std::size_t v = 0; v < count; ++v)
        if (const std::size_t at = welded[v] / 64 & last_mark; at >= first && at < past) mark(v, at);
    });
  }
  std::vector<std::vector<std::uint32_t>> shared(blocks);
  parallel_blocks(count, block_vertices, [&](std::size_t begin, std::size_t end) {
    std::vector<std::uint32_t>& own = shared[begin / block_vertices];
    for (std::size_t v = begin; v < end; ++v) {
      const std::uint64_t again = marks[welded[v] / 64 & last_mark].again >> welded[v] % 64;
      if (used[v] & again)
        own.push_back(static_cast<std::uint32_t>(v));
      else
        welded[v] = used[v] ? static_cast<std::uint32_t>(v) : no_index;
    }
  });
  std::size_t sharing = 0;
  for (const std::vector<std::uint32_t>& own : shared) sharing += own.size();
  repairs[Repair::welded_vertices] += weld_shared(mesh, shared, sharing, welded);
  return welded;
}

}  // namespace meander
