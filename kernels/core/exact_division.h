// Division by a power of two, done as multiplications.
#pragma once

namespace meander {

// Gives x / divisor bit for bit where the divisor is a power of two, even where 1 / divisor overflows double
// (divisors below 2^-1023).
class ExactDivision {
 public:
  explicit ExactDivision(double divisor)
      : first_(divisor < 0x1p-1000 ? 0x1p80 : 1.0), second_(1 / (divisor * first_)) {}
  double operator()(double x) const { return x * first_ * second_; }

 private:
  double first_, second_;
};

}  // namespace meander
