#include <cmath>
#include <numeric>

#include "kernels/pointset/bucket_grid.h"
#include "kernels/pointset/iterative_points.h"

namespace meander {

namespace {

constexpr std::uint32_t candidates_per_point = 5;

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

}  // namespace

PlanarPoints poisson_disk_points(std::uint32_t count, RandomKey key) {
  const std::size_t candidates = std::size_t{candidates_per_point} * count;
  std::vector<double> x(candidates), y(candidates);
  for (std::size_t i = 0; i < candidates; ++i) {
    const UnitPair p = random_pair(key, Stream::point_set, i);
    x[i] = p.first;
    y[i] = p.second;
  }
  // The largest possible radius of `count` disks of area 1 in all (his equation for the plane), and the
  // distance below which all pairs weigh the same, so that dense clumps do not go first.
  const double reach = 2 * std::sqrt(1 / (2 * std::sqrt(3.0) * count));
  const double near = 0.65 * reach * (1 - std::pow(1.0 / candidates_per_point, 1.5));
  const auto weight = [&](std::size_t i, std::size_t j) {
    const double d = std::max(near, std::hypot(x[i] - x[j], y[i] - y[j]));
    if (d >= reach) return 0.0;
    const double w = 1 - d / reach, w2 = w * w, w4 = w2 * w2;
    return w4 * w4;
  };
  const BucketGrid grid = bucket_points(x, y, static_cast<std::uint32_t>(1 / reach));
  const auto visit = [&](std::size_t i, const auto& body) {
    const std::uint32_t cx = grid.cell_of(x[i]), cy = grid.cell_of(y[i]);
    for (std::uint32_t v = cy - (cy > 0); v <= std::min(cy + 1, grid.side - 1); ++v)
      for (std::uint32_t u = cx - (cx > 0); u <= std::min(cx + 1, grid.side - 1); ++u) {
        const std::size_t cell = u + std::size_t{grid.side} * v;
        for (std::uint32_t k = grid.begin[cell]; k < grid.begin[cell + 1]; ++k)
          if (grid.points[k] != i) body(grid.points[k]);
      }
  };
  std::vector<double> weights(candidates, 0.0);
  for (std::size_t i = 0; i < candidates; ++i) visit(i, [&](std::uint32_t j) { weights[i] += weight(i, j); });

  WeightHeap heap(std::move(weights));
  std::vector<std::uint8_t> kept(candidates, 1);
  for (std::size_t gone = 0; gone < candidates - count; ++gone) {
    const std::uint32_t i = heap.pop();
    kept[i] = 0;
    visit(i, [&](std::uint32_t j) {
      if (kept[j] == 0) return;
      if (const double w = weight(i, j); w > 0) heap.lessen(j, w);
    });
  }
  PlanarPoints points;
  for (std::size_t i = 0; i < candidates; ++i)
    if (kept[i] != 0) {
      points.x.push_back(x[i]);
      points.y.push_back(y[i]);
    }
  return points;
}

}  // namespace meander
