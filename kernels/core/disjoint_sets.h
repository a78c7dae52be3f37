// Disjoint sets of numbers that only ever join (Tarjan and van Leeuwen 1984: path halving).
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <vector>

namespace meander {

// Sets of 0 .. count - 1, each number alone at first. The smallest number of a set represents it, whatever
// the order of the joins. O(log n) a call amortized, in practice a few steps.
class DisjointSets {
 public:
  explicit DisjointSets(std::size_t count) : parent_(count) {
    std::iota(parent_.begin(), parent_.end(), std::uint32_t{0});
  }

  std::uint32_t find(std::uint32_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }

  // Returns false when both were in one set already.
  bool join(std::uint32_t a, std::uint32_t b) {
    a = find(a);
    b = find(b);
    parent_[std::max(a, b)] = std::min(a, b);
    return a != b;
  }

  bool is_representative(std::uint32_t i) const { return parent_[i] == i; }

 private:
  std::vector<std::uint32_t> parent_;
};

}  // namespace meander
