#include "kernels/core/portable_angles.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "support/catch.h"

using namespace meander;

TEST_CASE("portable angles: match the C library, for vectors from 1e-150 to 1e150 and a thousand turns") {
  double worst_angle = 0, worst_direction = 0;
  for (int i = 0; i <= 20000; ++i) {
    const double angle = std::numbers::pi * i / 20000;
    for (const double length : {1e-150, 1.0, 1e150})
      worst_angle = std::max(
          worst_angle,
          std::abs(upper_angle(length * std::abs(std::sin(angle)), length * std::cos(angle)) - angle));
    const double turned = (i - 10000) * 0.7;
    const Direction direction = direction_of(turned);
    worst_direction = std::max({worst_direction, std::abs(direction.cosine - std::cos(turned)),
                                std::abs(direction.sine - std::sin(turned))});
  }
  CHECK(worst_angle < 2e-15);
  CHECK(worst_direction < 1e-15 + 2e-16 * 7000 / (2 * std::numbers::pi));
  CHECK(upper_angle(0, 0) == 0);
}

TEST_CASE("portable angles: non-finite and very large angles have no direction") {
  for (const double angle :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(),
        -std::numeric_limits<double>::infinity(), 1e15, -1e300}) {
    INFO(angle);
    CHECK(std::isnan(direction_of(angle).cosine));
    CHECK(std::isnan(direction_of(angle).sine));
  }
}
