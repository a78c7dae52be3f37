// Points of a box, for tests of distances.
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "kernels/core/random.h"

namespace meander::test {

// Random points of a box of sides 1, 0.7, 0.4.
inline std::vector<float> box_points(std::size_t n, std::uint64_t seed = 1) {
  const RandomKey key = make_random_key(seed, {});
  std::vector<float> points;
  for (std::size_t i = 0; i < n; ++i) {
    const UnitPair a = random_pair(key, Stream::point_set, i, 0),
                   b = random_pair(key, Stream::point_set, i, 1);
    points.push_back(static_cast<float>(a.first));
    points.push_back(static_cast<float>(0.7 * a.second));
    points.push_back(static_cast<float>(0.4 * b.first));
  }
  return points;
}

inline double distance(const std::vector<float>& p, std::size_t i, std::size_t j) {
  double sum = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const double d = static_cast<double>(p[3 * i + k]) - static_cast<double>(p[3 * j + k]);
    sum += d * d;
  }
  return std::sqrt(sum);
}

}  // namespace meander::test
