// Histogram of all pairs of oriented points: distance, the angles of both normals with the line, and the
// angle between the normals. These are the features of the point pairs of Wahl, Hillenbrand and Hirzinger
// 2003 ("Surflet-pair-relation histograms"), without their order of the two points, over every pair.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "kernels/core/cancel.h"
#include "kernels/core/instruction_set.h"

namespace meander {

// signed_normals: normals have a consistent outside; angles are in [0, pi]. either_side: a normal and its
// opposite are the same; angles are in [0, pi / 2].
enum class NormalSense : std::uint8_t { signed_normals, either_side };

// The bins: distance x smaller angle x larger angle x angle between the normals, the last varying fastest.
inline constexpr std::uint32_t pair_distance_bins = 8, pair_angle_bins = 4;
inline constexpr std::uint32_t oriented_pair_bins =
    pair_distance_bins * pair_angle_bins * pair_angle_bins * pair_angle_bins;
inline constexpr double pair_distance_range = 2.5;  // over the mean; larger distances are in the last bin

// The ends of the bins of angles, degrees. No edge lies at an angle that flat, right-angled or regular shapes
// have in many pairs (0, 90, 180, multiples of 15, 18 and 22.5 degrees between normals; 90 degrees between a
// normal and a line in its plane), where rounding would decide.
struct PairAngleEdges {
  std::array<double, pair_angle_bins - 1> line, normals;
};
inline constexpr PairAngleEdges signed_angle_edges = {{84, 96, 126}, {33, 83, 128}};
inline constexpr PairAngleEdges either_side_angle_edges = {{36, 60, 84}, {33, 57, 83}};

struct OrientedPairParameters {
  NormalSense sense = NormalSense::signed_normals;
  InstructionSet instructions = InstructionSet::automatic;
};

struct OrientedPairHistogram {
  std::vector<std::uint64_t> counts;  // oriented_pair_bins; sum pairs
  std::vector<float> roots;           // square roots of the shares of the pairs
  double mean_distance = 0;           // units of the points
  std::uint64_t pairs = 0;            // n (n - 1) / 2
};

// Counts all pairs. points: 3 n coordinates, finite, n >= 2; normals: 3 n, finite, of length 1. For points i
// and j at distance d along the line l from i to j, the angles with the line are those between n_i and l, and
// between n_j and -l; the smaller bin comes first. So the histogram depends neither on the order of the
// points nor on position, direction or size of the whole; with either_side it does not depend on the sense of
// any normal. Where two points coincide, both angles with the line count in the first bin. Points that all
// coincide have mean distance 0 and lie in the first bin of distances.
//
// Cosines are compared with those of the edges: float32 with one rounding per operation, no division and no
// function of the C library in the loop, counts are integers. Any permutation, instruction set and number of
// threads gives the same bytes. O(n^2), parallel; bench/describe_bench.cpp measures it. Throws
// std::invalid_argument for fewer than two points, lengths that differ, numbers that are not finite, or
// instructions that the processor does not have; RunCanceled and ItemError(timeout) from `cancel`.
OrientedPairHistogram oriented_pair_histogram(std::span<const float> points, std::span<const float> normals,
                                              const OrientedPairParameters& parameters = {},
                                              const CancelToken& cancel = {});

}  // namespace meander
