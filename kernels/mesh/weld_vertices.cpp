#include "kernels/mesh/weld_vertices.h"

#include <bit>
#include <cstddef>

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

// Hashes that came once and those that came again, one bit each.
struct HashMarks {
  std::uint64_t once = 0, again = 0;
};

}  // namespace

std::vector<std::uint32_t> weld_vertices(const PolygonMesh& mesh, std::span<const std::uint8_t> used,
                                         RepairCounts& repairs) {
  // In most files hardly any two positions are equal. So hashes are marked first, 16 bits or more a vertex,
  // and only vertices that share a mark are looked up in a table.
  const double *const x = mesh.x.data(), *const y = mesh.y.data(), *const z = mesh.z.data();
  std::vector<std::uint32_t> welded(mesh.vertex_count());  // at first the hash
  std::vector<HashMarks> marks(std::bit_ceil(mesh.vertex_count() / 4 + 1));
  const auto marks_of = [at = marks.data(), last = marks.size() - 1](std::uint32_t hash) -> HashMarks& {
    return at[hash / 64 & last];
  };
  for (std::size_t v = 0; v < welded.size(); ++v) {
    welded[v] = hash_of_position(x[v], y[v], z[v]);
    HashMarks& mark = marks_of(welded[v]);
    const std::uint64_t bit = std::uint64_t{used[v]} << welded[v] % 64;
    mark.again |= mark.once & bit;
    mark.once |= bit;
  }
  const auto is_shared = [&](std::size_t v) { return used[v] & marks_of(welded[v]).again >> welded[v] % 64; };
  std::size_t shared = 0;
  for (std::size_t v = 0; v < welded.size(); ++v) shared += is_shared(v);
  const std::size_t slots = std::bit_ceil(2 * shared + 2);
  std::vector<std::uint32_t> table(slots, no_index);
  std::uint32_t again = 0;
  for (std::uint32_t v = 0; v < welded.size(); ++v) {
    if (!is_shared(v)) {
      welded[v] = used[v] ? v : no_index;
      continue;
    }
    // Turned, because what shares a mark shares the low bits of the hash.
    std::size_t slot = std::rotl(welded[v], 16) & (slots - 1);
    while (table[slot] != no_index) {
      const std::uint32_t other = table[slot];
      if (x[other] == x[v] && y[other] == y[v] && z[other] == z[v]) break;
      slot = (slot + 1) & (slots - 1);
    }
    again += table[slot] != no_index;
    if (table[slot] == no_index) table[slot] = v;
    welded[v] = table[slot];
  }
  repairs[Repair::welded_vertices] += again;
  return welded;
}

}  // namespace meander
