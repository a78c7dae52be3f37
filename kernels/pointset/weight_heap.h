// Internal to kernels/pointset: the order in which points are eliminated.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

namespace meander {

// A binary heap of points by weight, the largest first; equal weights by number, so that the order is one.
class WeightHeap {
 public:
  explicit WeightHeap(std::vector<double> weights)
      : weight_(std::move(weights)), heap_(weight_.size()), place_(weight_.size()) {
    std::iota(heap_.begin(), heap_.end(), 0u);
    std::iota(place_.begin(), place_.end(), 0u);
    for (std::size_t i = heap_.size() / 2; i-- > 0;) sink(i);
  }
  std::uint32_t pop() {
    const std::uint32_t top = heap_[0];
    put(0, heap_.back());
    heap_.pop_back();
    if (!heap_.empty()) sink(0);
    return top;
  }
  void lessen(std::uint32_t point, double amount) {
    weight_[point] -= amount;
    sink(place_[point]);
  }

 private:
  bool before(std::uint32_t a, std::uint32_t b) const {
    return weight_[a] > weight_[b] || (weight_[a] == weight_[b] && a < b);
  }
  void put(std::size_t place, std::uint32_t point) {
    heap_[place] = point;
    place_[point] = static_cast<std::uint32_t>(place);
  }
  void sink(std::size_t i) {
    const std::uint32_t point = heap_[i];
    for (;;) {
      std::size_t child = 2 * i + 1;
      if (child >= heap_.size()) break;
      if (child + 1 < heap_.size() && before(heap_[child + 1], heap_[child])) ++child;
      if (!before(heap_[child], point)) break;
      put(i, heap_[child]);
      i = child;
    }
    put(i, point);
  }

  std::vector<double> weight_;
  std::vector<std::uint32_t> heap_, place_;
};

// The weight of a pair in weighted sample elimination (Yuksel 2015), with his parameters alpha 8, beta 0.65,
// gamma 1.5: it falls to 0 at `reach`, twice the largest radius that `count` disjoint discs on that area can
// have; pairs nearer than a bound weigh the same, so that dense clumps do not go first.
struct EliminationWeight {
  double reach = 0, near = 0;

  EliminationWeight(double area, double count, double candidates)
      : reach(2 * std::sqrt(area / (2 * std::sqrt(3.0) * count))),
        near(0.65 * reach * (1 - std::pow(count / candidates, 1.5))) {}
  double operator()(double distance) const {
    const double d = std::max(near, distance);
    if (d >= reach) return 0.0;
    const double w = 1 - d / reach, w2 = w * w, w4 = w2 * w2;
    return w4 * w4;
  }
};

}  // namespace meander
