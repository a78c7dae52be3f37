#include "kernels/flatten/orient2d.h"

#include <array>
#include <cmath>
#include <cstddef>

#include "kernels/core/exact_sums.h"

namespace meander {

namespace {

// A sum of doubles that do not overlap, smallest first; adding another keeps it exact (grow-expansion).
class Expansion {
 public:
  void add(double value) {
    double carry = value;
    std::size_t kept = 0;
    for (std::size_t i = 0; i < count_; ++i) {
      const DoublePair sum = two_sum(carry, terms_[i]);
      carry = sum.high;
      if (sum.low != 0) terms_[kept++] = sum.low;
    }
    count_ = kept;
    if (carry != 0) terms_[count_++] = carry;
  }
  void add_product(double a, double b) {
    const DoublePair product = two_product(a, b);
    add(product.low);
    add(product.high);
  }
  // The last term is the largest, and outweighs all others together.
  double estimate() const { return count_ == 0 ? 0.0 : terms_[count_ - 1]; }

 private:
  std::array<double, 16> terms_{};
  std::size_t count_ = 0;
};

double orient2d_exact(double ax, double ay, double bx, double by, double cx, double cy) {
  Expansion sum;
  sum.add_product(ax, by);
  sum.add_product(-ay, bx);
  sum.add_product(bx, cy);
  sum.add_product(-by, cx);
  sum.add_product(cx, ay);
  sum.add_product(-cy, ax);
  return sum.estimate();
}

}  // namespace

double orient2d(double ax, double ay, double bx, double by, double cx, double cy) {
  const double left = (ax - cx) * (by - cy), right = (ay - cy) * (bx - cx);
  const double determinant = left - right;
  // (3 + 16 e) e with e = 2^-53 bounds the relative rounding error of the determinant.
  constexpr double bound = (3.0 + 16.0 * 0x1p-53) * 0x1p-53;
  if (std::abs(determinant) > bound * (std::abs(left) + std::abs(right))) return determinant;
  return orient2d_exact(ax, ay, bx, by, cx, cy);
}

}  // namespace meander
