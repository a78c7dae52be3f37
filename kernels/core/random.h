// Counter-based random numbers: every draw is a pure function of (key, stream, index, counter).
//
// Philox4x32-10 (Salmon, Moraes, Dror, Shaw 2011, "Parallel random numbers: as easy as 1, 2, 3").
#pragma once

#include <array>
#include <cstdint>
#include <span>

namespace meander {

using PhiloxBlock = std::array<std::uint32_t, 4>;

// One Philox4x32-10 block. Pure.
constexpr PhiloxBlock philox4x32(const PhiloxBlock& counter, const std::array<std::uint32_t, 2>& key) {
  // Words, not arrays: where sanitizers keep the functions of arrays from being inlined, indices cost more
  // than sums.
  auto [c0, c1, c2, c3] = counter;
  auto [k0, k1] = key;
  for (int round = 0; round < 10; ++round) {
    const std::uint64_t p0 = std::uint64_t{0xD2511F53} * c0;
    const std::uint64_t p1 = std::uint64_t{0xCD9E8D57} * c2;
    c0 = static_cast<std::uint32_t>(p1 >> 32) ^ c1 ^ k0;
    c1 = static_cast<std::uint32_t>(p1);
    c2 = static_cast<std::uint32_t>(p0 >> 32) ^ c3 ^ k1;
    c3 = static_cast<std::uint32_t>(p0);
    k0 += 0x9E3779B9u;
    k1 += 0xBB67AE85u;
  }
  return {c0, c1, c2, c3};
}

// The purpose of a draw. Streams never share numbers; the values are part of the method version.
enum class Stream : std::uint32_t {
  sequence = 1,        // jitter of the 1-D sample set
  sequence_shift = 2,  // the shared shift and the permutation masks
  element_key = 3,     // the point whose curve key orders an element
  element_point = 4,   // the sample inside its element
  leaf_ray = 5,        // the point of a curve leaf that a ray is cast through
  stratum_point = 6,   // the places that a stratum offers to its spaced sample
  stratum_retry = 7,   // further numbers that a density needs for those places
  stratum_start = 8,   // the place that a spaced sample starts at
  cell_axes = 9,       // the axes that cells of spaced samples are cut along
  digital_shift = 10,  // the shift of the net that samples in cells form
  sharp_edges = 11,    // the key of the samples on sharp edges
  query_points = 12,   // the nets of the points that signed distances are given at
  test_shapes = 16,    // random shapes that measure point sets; no sample depends on them
  tangent_frame = 24,  // directions of tangent frames on surfaces, in measures
  surface_probe = 25,  // points at which the distance between two surfaces is measured
  point_set = 26,      // the point sets that samplings are compared with (kernels/pointset)
  shape_tuple = 27,    // the random triangles and tetrahedra of shape functions
  pair_scale = 28,     // pairs of descriptors whose mean distance scales a combined descriptor
  metric_window = 30,  // windows of a domain that anisotropic discrepancies are measured in
};

// The key of all randomness of one model: the user's seed and the content of the model, nothing else.
struct RandomKey {
  std::array<std::uint32_t, 2> words{};
  friend bool operator==(const RandomKey&, const RandomKey&) = default;
};

// Mixes the seed with the first 16 bytes of the content's digest (any bytes; an empty digest is allowed).
constexpr RandomKey make_random_key(std::uint64_t seed, std::span<const std::uint8_t> content_digest) {
  PhiloxBlock counter{};
  for (std::size_t i = 0; i < content_digest.size() && i < 16; ++i)
    counter[i / 4] |= static_cast<std::uint32_t>(content_digest[i]) << (8 * (i % 4));
  const PhiloxBlock mixed =
      philox4x32(counter, {static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32)});
  return {{mixed[0] ^ mixed[2], mixed[1] ^ mixed[3]}};
}

// Four random words for (key, stream, index, counter).
constexpr PhiloxBlock random_words(RandomKey key, Stream stream, std::uint64_t index,
                                   std::uint32_t counter = 0) {
  return philox4x32({static_cast<std::uint32_t>(index), static_cast<std::uint32_t>(index >> 32),
                     static_cast<std::uint32_t>(stream), counter},
                    key.words);
}

// A uniform number in [0, 1) with 53 bits from two words.
constexpr double unit_double(std::uint32_t high, std::uint32_t low) {
  const std::uint64_t bits = (static_cast<std::uint64_t>(high) << 32 | low) >> 11;
  return static_cast<double>(bits) * 0x1p-53;
}

struct UnitPair {
  double first, second;
};
// Two uniform numbers in [0, 1) for (key, stream, index, counter).
constexpr UnitPair random_pair(RandomKey key, Stream stream, std::uint64_t index, std::uint32_t counter = 0) {
  const PhiloxBlock w = random_words(key, stream, index, counter);
  return {unit_double(w[0], w[1]), unit_double(w[2], w[3])};
}

}  // namespace meander
