#include <algorithm>
#include <cmath>

#include "kernels/describe/pair_tiles.h"

namespace meander {

namespace {

float squared_distance(const PairTile& tile, std::size_t i, std::size_t j) {
  const float dx = tile.x[i] - tile.x[j], dy = tile.y[i] - tile.y[j], dz = tile.z[i] - tile.z[j];
  return (dx * dx + dy * dy) + dz * dz;
}

template <class Body>
void for_each_pair(const PairTile& tile, const Body& body) {
  for (std::size_t i = tile.row_begin; i < tile.row_end; ++i)
    for (std::size_t s = tile.offset_begin; s < tile.offset_end; ++s) body(squared_distance(tile, i, i + s));
}

float largest(const PairTile& tile) {
  float most = 0;
  for_each_pair(tile, [&](float squared) { most = std::max(most, squared); });
  return most;
}

std::uint64_t sum(const PairTile& tile) {
  std::uint64_t total = 0;
  for_each_pair(tile, [&](float squared) {
    total += static_cast<std::uint64_t>(std::lrint(std::sqrt(squared) * distance_unit));
  });
  return total;
}

void count(const PairTile& tile, const PairCounter& counter) {
  // In a joint table the missing partner is a pad in bin 0, like the pads of the vector loops.
  for_each_pair(tile, [&](float squared) {
    ++counter.table[static_cast<std::uint32_t>(std::min(std::sqrt(squared) * counter.factor, counter.top))];
  });
}

}  // namespace

const PairLoops scalar_pair_loops{largest, sum, count};

}  // namespace meander
