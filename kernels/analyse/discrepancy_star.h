// Star discrepancy in the plane: the supremum over boxes anchored at the origin (docs/METHODS.md 13.2).
#pragma once

#include <cstdint>
#include <span>

namespace meander {

// sup over (a, b) in [0, 1]^2 of |#{x < a, y < b}/N - ab| and of the closed boxes; exact to rounding.
// x, y: N coordinates in [0, 1], in any order; equal ones allowed. O(N^2) time (2^14 points: 0.1 s of one
// core), O(N) memory; parallel, the same for every thread count. Throws std::invalid_argument without points
// or when lengths differ.
double star_discrepancy_exact(std::span<const double> x, std::span<const double> y);

struct StarSearchParameters {
  std::uint32_t boxes = 1u << 14;  // random corners: 1 .. 2^20
  std::uint32_t climbs = 32;       // the best of them that are climbed from
  std::uint64_t seed = 1;
};
// A lower bound for large N: boxes whose corner has the x of one random point and the y of another (corners
// at coordinates of points are where maxima lie; which ranks is a function of the seed), then from the best
// of them exact line searches along x and y in turn until neither helps (threshold accepting of Winker and
// Fang 1997 without its random steps). Usually within a few per cent of the exact value. O(N log N + climbs
// N): N = 1,572,864 takes about 2 s. Deterministic. Throws like star_discrepancy_exact.
double star_discrepancy_search(std::span<const double> x, std::span<const double> y,
                               const StarSearchParameters& parameters = {});

}  // namespace meander
