// Points of a scrambled digital net in up to six dimensions, each a pure function of its index.
#pragma once

#include <array>
#include <cstdint>

#include "kernels/core/random.h"

namespace meander {

// Sobol's sequence with the direction numbers of Joe and Kuo 2008, scrambled dimension by dimension by a hash
// in place of Owen's random permutations (Burley 2020, "Practical hash-based Owen scrambling"): the first
// 2^k points are a net for every k, and each point is uniform over keys to the quality of the hash.
class ScrambledNet {
 public:
  static constexpr std::size_t dimensions = 6;

  // Nets of different numbers are independent of each other. Pure.
  ScrambledNet(RandomKey key, Stream stream, std::uint32_t number);

  // The coordinates of a point, multiples of 2^-33 in (0, 1). Pure; some 20 ns.
  std::array<double, dimensions> operator()(std::uint32_t index) const;
  // The first of them alone. In half the time.
  std::array<double, 4> first_four(std::uint32_t index) const;

 private:
  std::array<std::uint32_t, 8> seeds_{};  // of the dimensions, and two unused
};

// The number below which a standard normal variable lies with the probability p in (0, 1): Wichura 1988,
// "Algorithm AS 241: the percentage points of the normal distribution", PPND16, about 1e-16 relative. The
// same bits on every machine.
double normal_quantile(double p);

// The probability that it lies within `limit` >= 0 of 0, by bisection of normal_quantile.
double normal_share(double limit);

}  // namespace meander
