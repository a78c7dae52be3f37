// Points of the unit square for the tests of spectra and differences.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "kernels/core/random.h"

namespace meander::test {

struct PlanarSet {
  std::vector<double> x, y;
};

inline PlanarSet random_set(std::size_t count, std::uint64_t seed) {
  const RandomKey key = make_random_key(seed, {});
  PlanarSet set;
  for (std::size_t i = 0; i < count; ++i) {
    const UnitPair u = random_pair(key, Stream::sequence, i);
    set.x.push_back(u.first);
    set.y.push_back(u.second);
  }
  return set;
}

// One point in each of side x side equal squares.
inline PlanarSet jittered_set(std::size_t side, std::uint64_t seed) {
  PlanarSet set = random_set(side * side, seed);
  for (std::size_t i = 0; i < set.x.size(); ++i) {
    set.x[i] = (static_cast<double>(i % side) + set.x[i]) / static_cast<double>(side);
    set.y[i] = (static_cast<double>(i / side) + set.y[i]) / static_cast<double>(side);
  }
  return set;
}

}  // namespace meander::test
