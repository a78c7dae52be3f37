// Angles without the C library, whose last bits differ between processors: the same bytes on every machine.
#pragma once

#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "kernels/core/exact_sums.h"

namespace meander {

// Angle of the vector (x, y) with y >= 0, in [0, pi]; 0 for the zero vector. Within 2 units in the last
// place.
inline double upper_angle(double y, double x) {
  // The arc tangents of i / 16.
  constexpr std::array<double, 17> arc_tangents = {0.0,
                                                   0.06241880999595735,
                                                   0.12435499454676144,
                                                   0.18534794999569476,
                                                   0.24497866312686414,
                                                   0.3028848683749714,
                                                   0.35877067027057225,
                                                   0.4124104415973873,
                                                   0.4636476090008061,
                                                   0.5123894603107377,
                                                   0.5585993153435624,
                                                   0.6022873461349642,
                                                   0.6435011087932844,
                                                   0.6823165548747481,
                                                   0.7188299996216245,
                                                   0.7531512809621944,
                                                   0.7853981633974483};
  const double ax = std::abs(x), low = y < ax ? y : ax, high = y < ax ? ax : y;
  if (!(high > 0)) return 0;
  const double t = low / high;
  const int i = static_cast<int>(16 * t + 0.5);
  const double c = i * 0.0625, z = (t - c) / (1 + t * c), zz = z * z;
  // |z| <= 1/32: the next term is below 1e-20.
  const double series =
      1 - zz * (1.0 / 3 - zz * (1.0 / 5 - zz * (1.0 / 7 - zz * (1.0 / 9 - zz * (1.0 / 11)))));
  double angle = arc_tangents[static_cast<std::size_t>(i)] + z * series;
  if (y > ax) angle = 0.5 * std::numbers::pi - angle;
  return x < 0 ? std::numbers::pi - angle : angle;
}

struct Direction {
  double cosine, sine;
};

// An angle of at most 1e15 less the given number of quarter turns.
inline double rest_of_angle(double angle, double quarters) {
  // pi / 2 in two parts, the first with 33 bits so that the product is exact.
  if (std::abs(angle) < 8192)
    return (angle - quarters * 1.57079632673412561417e+00) - quarters * 6.07710050650619224932e-11;
  // Three parts, with the errors of the products.
  const DoublePair high = two_product(quarters, 0x1.921fb54442d18p+0),
                   middle = two_product(quarters, 0x1.1a62633145c07p-54);
  return ((angle - high.high) - high.low - middle.high) - (middle.low + quarters * -0x1.f1976b7ed8fbcp-110);
}

// Cosine and sine of an angle; absolute error below 1e-15 plus 2e-16 a turn up to 8192. NaN from 1e15 on,
// where doubles are an eighth apart, and for NaN.
inline Direction direction_of(double angle) {
  if (!(std::abs(angle) < 1e15))
    return {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::quiet_NaN()};
  const double quarters = std::floor(angle * (2 * std::numbers::inv_pi) + 0.5);
  const double r = rest_of_angle(angle, quarters);
  const double s = r * r;
  const double sine =
      r *
      (1 -
       s / 6 * (1 - s / 20 * (1 - s / 42 * (1 - s / 72 * (1 - s / 110 * (1 - s / 156 * (1 - s / 210)))))));
  const double cosine =
      1 - s / 2 *
              (1 - s / 12 *
                       (1 - s / 30 *
                                (1 - s / 56 * (1 - s / 90 * (1 - s / 132 * (1 - s / 182 * (1 - s / 240)))))));
  switch (static_cast<int>(static_cast<long long>(quarters) & 3)) {
    case 0:
      return {cosine, sine};
    case 1:
      return {-sine, cosine};
    case 2:
      return {-cosine, -sine};
    default:
      return {sine, -cosine};
  }
}

}  // namespace meander
