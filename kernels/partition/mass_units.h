// Masses as multiples of 2^-61 of the power of two above their total, so that sums stay below 2^61.
#pragma once

#include <array>
#include <cmath>

namespace meander {

// In two factors, as one may be beyond the range of double.
struct MassUnits {
  std::array<double, 2> to{}, from{};

  MassUnits() = default;
  // `total` > 0 and finite.
  explicit MassUnits(double total) {
    int exponent = 0;
    std::frexp(total, &exponent);
    const int bits = 61 - exponent, part = bits / 2;
    to = {std::ldexp(1.0, part), std::ldexp(1.0, bits - part)};
    from = {std::ldexp(1.0, -part), std::ldexp(1.0, part - bits)};
  }
  double of(double mass) const { return mass * to[0] * to[1]; }
};

}  // namespace meander
