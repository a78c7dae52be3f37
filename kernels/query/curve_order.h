// Many points along a space-filling curve, as queries take them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace meander {

// n points in an order in which neighbors follow each other.
struct CurvePoints {
  std::vector<double> points;        // 3 n
  std::vector<std::uint32_t> order;  // n: the number that a point was given with

  // Values of the points along the curve, `width` each, in the order in which the points were given.
  template <class Value>
  std::vector<Value> as_given(const std::vector<Value>& values, std::size_t width = 1) const {
    std::vector<Value> given(values.size());
    if (values.empty()) return given;
    for (std::size_t i = 0; i < order.size(); ++i)
      for (std::size_t k = 0; k < width; ++k)
        given[width * std::size_t{order[i]} + k] = values[width * i + k];
    return given;
  }
};

// The numbers of 3 n coordinates along the 3-D Hilbert curve over their box, as far as it lies around a mesh
// in [-1, 1]. O(n); the same for every thread count. At most 2^32 - 1 points (else
// std::invalid_argument).
std::vector<std::uint32_t> order_along_curve(std::span<const double> points);

// The points themselves in this order: memory far apart is read here alone.
CurvePoints along_curve(std::span<const double> points);

// Upper bound of the bytes of a point meanwhile, and later.
inline constexpr double curve_order_bytes = 20, curve_points_bytes = 28;

}  // namespace meander
