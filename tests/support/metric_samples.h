// Planar samples that are random or stratified in the metric of a constant spacing tensor.
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "kernels/core/random.h"
#include "kernels/tensor/tangent_tensor.h"

namespace meander::test {

struct PlanarSamples {
  std::vector<double> x, y;
};

// log S of determinant 1, the primary direction at this angle.
inline TangentTensor log_spacing(double ratio, double angle) {
  const double half = 0.5 * std::log(ratio);
  return tensor_of({half, -half, std::cos(angle), std::sin(angle)});
}

// `count` independent points of the unit square.
inline PlanarSamples random_samples(std::size_t count, std::uint64_t seed) {
  const RandomKey key = make_random_key(seed, {});
  PlanarSamples set;
  for (std::size_t i = 0; i < count; ++i) {
    const UnitPair u = random_pair(key, Stream::sequence, i);
    set.x.push_back(u.first);
    set.y.push_back(u.second);
  }
  return set;
}

// One point in each of side x side equal squares of the unit square.
inline PlanarSamples grid_samples(std::size_t side, std::uint64_t seed) {
  PlanarSamples set = random_samples(side * side, seed);
  for (std::size_t i = 0; i < set.x.size(); ++i) {
    set.x[i] = (static_cast<double>(i % side) + set.x[i]) / static_cast<double>(side);
    set.y[i] = (static_cast<double>(i / side) + set.y[i]) / static_cast<double>(side);
  }
  return set;
}

// About `count` points of the unit square, one in each cell of a square grid of the metric, which is turned
// by `turn` and shifted at random.
inline PlanarSamples jittered_samples(double count, TangentTensor log_s, double turn, std::uint64_t seed) {
  const TangentTensor s = exponential(log_s);
  const double cell = 1 / std::sqrt(count), c = std::cos(turn), d = std::sin(turn);
  const TensorAxes axes = tensor_axes(s);
  const RandomKey key = make_random_key(seed, {});
  const UnitPair shift = random_pair(key, Stream::sequence_shift, 0);
  const auto half = static_cast<std::int64_t>(std::ceil(0.75 / (axes.second * cell))) + 2;
  PlanarSamples set;
  for (std::int64_t j = -half; j < half; ++j)
    for (std::int64_t i = -half; i < half; ++i) {
      const UnitPair u =
          random_pair(key, Stream::sequence, static_cast<std::uint64_t>((j + half) * 2 * half + i + half));
      const double a = cell * (static_cast<double>(i) + u.first + shift.first);
      const double b = cell * (static_cast<double>(j) + u.second + shift.second);
      const double p = c * a - d * b, q = d * a + c * b;
      const double x = 0.5 + s.xx * p + s.xy * q, y = 0.5 + s.xy * p + s.yy * q;
      if (!(x >= 0 && x < 1 && y >= 0 && y < 1)) continue;
      set.x.push_back(x);
      set.y.push_back(y);
    }
  return set;
}

}  // namespace meander::test
