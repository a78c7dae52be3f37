// Histograms of the pairs of oriented points around each of the first points: shape nearby, where
// oriented_pair_histogram counts all pairs at once.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "kernels/core/cancel.h"
#include "kernels/core/instruction_set.h"
#include "kernels/core/words.h"
#include "kernels/describe/oriented_pairs.h"

namespace meander {

// The bins of oriented_pair_histogram without its last one of distances, which takes what lies beyond the
// radius.
inline constexpr std::uint32_t local_distance_bins = pair_distance_bins - 1;
inline constexpr std::uint32_t local_pair_bins =
    oriented_pair_bins / pair_distance_bins * local_distance_bins;

// A radius is a multiple of the root mean square distance of the points from their centroid (size), or of the
// mean distance of a point to the nearest other one (spacing).
enum class RadiusUnit : std::uint8_t { size, spacing };
inline constexpr Word<RadiusUnit> radius_unit_words[] = {{"size", RadiusUnit::size},
                                                         {"spacing", RadiusUnit::spacing}};

struct LocalPairParameters {
  NormalSense sense = NormalSense::either_side;
  std::uint32_t centers = 320;  // the first points, or all where there are fewer
  double radius = 0.7;
  RadiusUnit unit = RadiusUnit::size;
  InstructionSet instructions = InstructionSet::automatic;
};

// The square roots of shares, local_pair_bins for each center: distance (7 equal bins up to the radius) x
// smaller angle x larger angle x angle between the normals, the last varying fastest; edges of angles and
// senses are those of oriented_pairs.h. A center with no point within the radius has zeros. points: 3 n
// coordinates, finite, n >= 2; normals: 3 n, finite, of length 1. Neither position nor direction nor size of
// the whole changes the values, and with either_side no sense of a normal does.
//
// The loops are those of oriented_pair_histogram: any instruction set and number of threads gives the same
// bytes. O(centers x n), and O(n^2) for the spacing. Exceptions as there, and std::invalid_argument for a
// radius that is not positive.
std::vector<float> local_pair_histograms(std::span<const float> points, std::span<const float> normals,
                                         const LocalPairParameters& parameters = {},
                                         const CancelToken& cancel = {});

}  // namespace meander
