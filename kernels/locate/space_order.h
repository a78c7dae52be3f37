// Points along the 3-D Hilbert curve.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "kernels/order/balanced_order.h"

namespace meander {

// Numbers of points along the curve, in words whose other bits are to be masked.
struct SpaceOrder {
  std::vector<std::uint64_t> words;
  std::uint64_t mask = ~std::uint64_t{0};
  std::size_t count() const { return words.size(); }
  std::size_t operator[](std::size_t i) const { return static_cast<std::size_t>(words[i] & mask); }
};

// By the keys of hilbert_key_3d, points of equal keys by their numbers; the masses do not matter. `dense`:
// most points may share a cell of the grid of coarse keys, as those of a region of the surface; it changes
// the time, not the order. O(N); 16 bytes a point. Parallel, the same for every thread count.
SpaceOrder space_order(const std::vector<MassPoint>& points, bool dense);

}  // namespace meander
