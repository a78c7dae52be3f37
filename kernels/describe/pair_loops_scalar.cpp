#include <algorithm>
#include <cmath>

#include "kernels/describe/oriented_tiles.h"
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

void count_distances(const PairTile& tile, const PairCounter& counter) {
  // In a joint table the missing partner is a pad in bin 0, like the pads of the vector loops.
  for_each_pair(tile, [&](float squared) {
    ++counter.table[static_cast<std::uint32_t>(std::min(std::sqrt(squared) * counter.factor, counter.top))];
  });
}

std::uint32_t bin_of(float value, float unit, const float (&cosines)[pair_angle_bins - 1]) {
  std::uint32_t bin = 0;
  for (const float cosine : cosines) bin += value < cosine * unit ? 1u : 0u;
  return bin;
}

template <NormalSense sense>
std::uint32_t slot_of(const OrientedTile& tile, std::size_t i, std::size_t j,
                      const OrientedCounter& counter) {
  const PairTile& at = tile.places;
  const float dx = at.x[j] - at.x[i], dy = at.y[j] - at.y[i], dz = at.z[j] - at.z[i];
  const float distance = std::sqrt((dx * dx + dy * dy) + dz * dz);
  float first = (tile.nx[i] * dx + tile.ny[i] * dy) + tile.nz[i] * dz;
  float second = -((tile.nx[j] * dx + tile.ny[j] * dy) + tile.nz[j] * dz);
  float between = (tile.nx[i] * tile.nx[j] + tile.ny[i] * tile.ny[j]) + tile.nz[i] * tile.nz[j];
  if constexpr (sense == NormalSense::either_side) {
    first = std::abs(first);
    second = std::abs(second);
    between = std::abs(between);
  }
  const std::uint32_t a = bin_of(first, distance, counter.line), b = bin_of(second, distance, counter.line);
  const auto far = static_cast<std::uint32_t>(std::min(distance * counter.factor, pair_distance_top));
  return ((far * pair_angle_bins + std::min(a, b)) * pair_angle_bins + std::max(a, b)) * pair_angle_bins +
         bin_of(between, 1, counter.normals);
}

template <NormalSense sense>
void count_oriented(const OrientedTile& tile, const OrientedCounter& counter) {
  const PairTile& at = tile.places;
  for (std::size_t i = at.row_begin; i < at.row_end; ++i)
    for (std::size_t s = at.offset_begin; s < at.offset_end; ++s)
      ++counter.table.table[slot_of<sense>(tile, i, i + s, counter)];
}

}  // namespace

const PairLoops scalar_pair_loops{largest, sum, count_distances};
const OrientedLoops scalar_oriented_loops{count_oriented<NormalSense::signed_normals>,
                                          count_oriented<NormalSense::either_side>};

}  // namespace meander
