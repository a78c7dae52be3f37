// The digits of samples in the cells of balanced bisection: a digital net under one random shift
// (docs/METHODS.md 7.7).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "kernels/core/random.h"
#include "kernels/partition/cut_history.h"

namespace meander {

// The digital shift that all samples of a set share: bit k of axis a is added to the k-th binary digit of a
// sample along a, counted from the root of the tree.
struct DigitalShift {
  std::array<std::uint64_t, 3> bits{};
  std::uint32_t digit(std::size_t axis, std::size_t number) const {
    return static_cast<std::uint32_t>(bits[axis] >> (number % 64) & 1u);
  }
};
// Uniform, of different numbers independent. Pure.
DigitalShift digital_shift(RandomKey key, std::uint32_t number = 0);

// Binary digit j of a sample along an axis, below a cell whose history has these sides across the others.
inline std::uint32_t net_digit(std::uint32_t sides_across_others, std::uint32_t j) {
  const std::uint32_t s = sides_across_others >> j;
  return (s ^ s >> 1 ^ s >> 2) & 1u;
}

// Digits of the net in a cell along its largest extent, and along the largest of what is left then.
inline constexpr std::uint32_t net_digits_in_cell = 2;

// Those of a cell along one axis, from its digit `past` on.
class CellDigits {
 public:
  CellDigits(const CutHistory& history, const DigitalShift& shift, std::size_t axis, std::uint32_t past = 0)
      : sides_(history.side_across_others[axis]),
        shift_(shift.bits[axis] >> (history.cuts[axis] % 64)),
        past_(past) {}
  std::uint32_t operator()(std::uint32_t j) const {
    return net_digit(sides_, past_ + j) ^ static_cast<std::uint32_t>(shift_ >> (past_ + j) & 1u);
  }
  // The share of the cell below the sample along the axis, in [0, 1): two digits, then those of `rest` in [0,
  // 1).
  double share(double rest) const {
    for (std::uint32_t j = net_digits_in_cell; j > 0; --j) rest = ((*this)(j - 1) + rest) / 2;
    return rest;
  }

 private:
  std::uint32_t sides_;
  std::uint64_t shift_;
  std::uint32_t past_;
};

}  // namespace meander
