// Error-free sums and products of two doubles, as pairs. They rely on rounding to nearest, without
// contraction or excess precision.
#pragma once

namespace meander {

// high + low, where low is at most half a unit in the last place of high.
struct DoublePair {
  double high, low;
};

// Adds any two finite doubles whose sum is finite (Knuth 1969).
inline DoublePair two_sum(double a, double b) {
  const double sum = a + b;
  const double b_part = sum - a;
  return {sum, (a - (sum - b_part)) + (b - b_part)};
}

// Adds a and b where |a| >= |b| or a = 0 (Dekker 1971).
inline DoublePair fast_two_sum(double a, double b) {
  const double sum = a + b;
  return {sum, b - (sum - a)};
}

// Multiplies doubles below 2^996 whose product is 0 or above 2^-969 (Dekker 1971).
inline DoublePair two_product(double a, double b) {
  const auto split = [](double x) {
    const double scaled = 134217729.0 * x;  // 2^27 + 1
    const double high = scaled - (scaled - x);
    return DoublePair{high, x - high};
  };
  const double product = a * b;
  const DoublePair x = split(a), y = split(b);
  const double error = ((product - x.high * y.high) - x.low * y.high) - x.high * y.low;
  return {product, x.low * y.low - error};
}

}  // namespace meander
