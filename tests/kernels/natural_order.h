// The order of elimination that changes nothing.
#pragma once

#include <cstdint>
#include <numeric>
#include <vector>

namespace meander::test {

inline std::vector<std::uint32_t> natural_order(std::size_t count) {
  std::vector<std::uint32_t> order(count);
  std::iota(order.begin(), order.end(), 0u);
  return order;
}

}  // namespace meander::test
