// Points along the 3-D Hilbert curve.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "kernels/partition/balanced_order.h"

namespace meander {

// Numbers of points along the curve, in words whose other bits are to be masked.
struct SpaceOrder {
  std::vector<std::uint64_t> words;
  std::uint64_t mask = ~std::uint64_t{0};
  std::size_t count() const { return words.size(); }
  std::size_t operator[](std::size_t i) const { return static_cast<std::size_t>(words[i] & mask); }
};

// By their 3-D Hilbert keys, points of equal keys by their numbers; the masses do not matter. `dense`: most
// points may share a cell of the grid of coarse keys, as those of a region of the surface; they are then
// ordered by whole keys. Else the leading bits of keys are computed in single precision, so that points at
// the borders of cells may be in the cell beside. O(N); 16 bytes a point, dense 24, above 2^28 points 48.
// Parallel, the same for every thread count.
SpaceOrder space_order(const std::vector<MassPoint>& points, bool dense);

}  // namespace meander
