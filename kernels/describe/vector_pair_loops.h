// The loops over the pairs of tiles in vectors, one text for all instruction sets. Internal to
// kernels/describe.
//
// The source of an instruction set declares MEANDER_LANES, its vectors and their functions, then includes
// this text once. MEANDER_LANES is the target: every function carries it itself, because a file compiled with
// other flags could leave its instructions in inline functions that the whole program shares.
#pragma once

#include <utility>

#include "kernels/describe/oriented_tiles.h"
#include "kernels/describe/pair_tiles.h"

namespace meander {

namespace {

struct Vectors {
  Floats x, y, z;
};

MEANDER_LANES inline Vectors all_of(const float* x, const float* y, const float* z, std::size_t i) {
  return {all(x[i]), all(y[i]), all(z[i])};
}
MEANDER_LANES inline Vectors load(const float* x, const float* y, const float* z, std::size_t j) {
  return {load(x + j), load(y + j), load(z + j)};
}
MEANDER_LANES inline Vectors difference(const Vectors& a, const Vectors& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
MEANDER_LANES inline Floats dot(const Vectors& a, const Vectors& b) {
  return (a.x * b.x + a.y * b.y) + a.z * b.z;
}

MEANDER_LANES inline Floats squared_distances(const PairTile& tile, const Vectors& row, std::size_t j) {
  const Vectors d = difference(row, load(tile.x, tile.y, tile.z, j));
  return dot(d, d);
}
// The last vector of a row: pads have distance 0.
MEANDER_LANES inline Floats last_squared_distances(const PairTile& tile, const Vectors& row, std::size_t j,
                                                   std::size_t used) {
  return first_lanes(squared_distances(tile, row, j), used);
}

MEANDER_LANES float largest(const PairTile& tile) {
  const std::size_t length = tile.offset_end - tile.offset_begin, full = length / lanes * lanes;
  Floats most = all(0);
  for (std::size_t i = tile.row_begin; i < tile.row_end; ++i) {
    const Vectors row = all_of(tile.x, tile.y, tile.z, i);
    const std::size_t first = i + tile.offset_begin;
    for (std::size_t k = 0; k < full; k += lanes)
      most = larger(most, squared_distances(tile, row, first + k));
    if (full < length) most = larger(most, last_squared_distances(tile, row, first + full, length - full));
  }
  return largest_lane(most);
}

MEANDER_LANES std::uint64_t sum(const PairTile& tile) {
  const std::size_t length = tile.offset_end - tile.offset_begin, full = length / lanes * lanes;
  Ints total = zeros();
  for (std::size_t i = tile.row_begin; i < tile.row_end; ++i) {
    const Vectors row = all_of(tile.x, tile.y, tile.z, i);
    const std::size_t first = i + tile.offset_begin;
    Ints units = zeros();  // pair_offsets / lanes terms below 2^24 a lane
    for (std::size_t k = 0; k < full; k += lanes)
      units = added(units, rounded(root(squared_distances(tile, row, first + k)) * all(distance_unit)));
    if (full < length)
      units = added(units, rounded(root(last_squared_distances(tile, row, first + full, length - full)) *
                                   all(distance_unit)));
    total = with_wide_lanes(total, units);
  }
  return sum_of_wide_lanes(total);
}

// Counts the table entries of a row while it writes those of the next: the two wait for different parts of
// the processor. Pads come before the first row.
template <class Slots>
MEANDER_LANES inline void count_rows(const PairTile& tile, const PairCounter& counter, Slots slots_of) {
  constexpr std::size_t share = Slots::share;
  const std::size_t length = tile.offset_end - tile.offset_begin, full = length / lanes * lanes;
  std::uint32_t buffers[2][pair_offsets];
  for (std::uint32_t& slot : buffers[1]) slot = Slots::pad;
  std::uint32_t *slots = buffers[0], *before = buffers[1];
  for (std::size_t i = tile.row_begin; i < tile.row_end; ++i, std::swap(slots, before)) {
    slots_of.begin_row(i);
    const std::size_t first = i + tile.offset_begin;
    for (std::size_t k = 0; k < full; k += lanes) {
      slots_of.write(first + k, slots + k / share);
      count_slots(before + k / share, lanes / share, counter);
    }
    if (full < length) {
      slots_of.write_last(first + full, length - full, slots + full / share);
      count_slots(before + full / share, lanes / share, counter);
    }
  }
  count_slots(before, (length + lanes - 1) / lanes * lanes / share, counter);
}

template <bool joint>
struct DistanceSlots {
  static constexpr std::size_t share = joint ? 2 : 1;  // pairs of an entry
  static constexpr std::uint32_t pad = 0;
  const PairTile& tile;
  Floats factor, top;
  __m128i shift;
  Vectors row;

  MEANDER_LANES void begin_row(std::size_t i) { row = all_of(tile.x, tile.y, tile.z, i); }
  MEANDER_LANES void write(std::size_t j, std::uint32_t* to) const {
    write_squared(squared_distances(tile, row, j), to);
  }
  MEANDER_LANES void write_last(std::size_t j, std::size_t used, std::uint32_t* to) const {
    write_squared(last_squared_distances(tile, row, j, used), to);
  }
  MEANDER_LANES void write_squared(Floats squared, std::uint32_t* to) const {
    const Ints bins = truncated(smaller(root(squared) * factor, top));
    if constexpr (joint)
      store_joint(bins, shift, to);
    else
      store(bins, to);
  }
};

template <bool joint>
MEANDER_LANES void count_distances(const PairTile& tile, const PairCounter& counter) {
  const __m128i shift = _mm_cvtsi32_si128(32 - static_cast<int>(counter.side_bits));
  count_rows(tile, counter, DistanceSlots<joint>{tile, all(counter.factor), all(counter.top), shift, {}});
}

void count(const PairTile& tile, const PairCounter& counter) {
  if (counter.side_bits > 0)
    count_distances<true>(tile, counter);
  else
    count_distances<false>(tile, counter);
}

struct Edges {
  Floats cosine[pair_angle_bins - 1];

  MEANDER_LANES static Edges of(const float (&cosines)[pair_angle_bins - 1]) {
    return {{all(cosines[0]), all(cosines[1]), all(cosines[2])}};
  }
  MEANDER_LANES Edges times(Floats unit) const {
    return {{cosine[0] * unit, cosine[1] * unit, cosine[2] * unit}};
  }
  MEANDER_LANES Ints bins(Floats value) const { return lanes_below(value, cosine[0], cosine[1], cosine[2]); }
};

template <NormalSense sense>
struct OrientedSlots {
  static constexpr std::size_t share = 1;
  static constexpr std::uint32_t pad = pad_slot;
  const OrientedTile& tile;
  Edges line, normals;
  Floats factor, top;
  Vectors place, normal;

  MEANDER_LANES void begin_row(std::size_t i) {
    place = all_of(tile.places.x, tile.places.y, tile.places.z, i);
    normal = all_of(tile.nx, tile.ny, tile.nz, i);
  }
  MEANDER_LANES void write(std::size_t j, std::uint32_t* to) const { store(slots(j), to); }
  // The last vector of a row: pads go to an entry of their own.
  MEANDER_LANES void write_last(std::size_t j, std::size_t used, std::uint32_t* to) const {
    store(first_lanes_else(slots(j), used, pad_slot), to);
  }
  MEANDER_LANES Ints slots(std::size_t j) const {
    const Vectors d = difference(load(tile.places.x, tile.places.y, tile.places.z, j), place);
    const Vectors other = load(tile.nx, tile.ny, tile.nz, j);
    const Floats distance = root(dot(d, d));
    Floats first = dot(normal, d), second = -dot(other, d), between = dot(normal, other);
    if constexpr (sense == NormalSense::either_side) {
      first = magnitude(first);
      second = magnitude(second);
      between = magnitude(between);
    }
    const Edges scaled = line.times(distance);
    return slot_of(truncated(smaller(distance * factor, top)), scaled.bins(first), scaled.bins(second),
                   normals.bins(between));
  }
};

template <NormalSense sense>
MEANDER_LANES void count_oriented(const OrientedTile& tile, const OrientedCounter& counter) {
  count_rows(tile.places, counter.table,
             OrientedSlots<sense>{tile,
                                  Edges::of(counter.line),
                                  Edges::of(counter.normals),
                                  all(counter.factor),
                                  all(pair_distance_top),
                                  {},
                                  {}});
}

constexpr PairLoops pair_loops_in_vectors{largest, sum, count};
constexpr OrientedLoops oriented_loops_in_vectors{count_oriented<NormalSense::signed_normals>,
                                                  count_oriented<NormalSense::either_side>};

}  // namespace

}  // namespace meander
