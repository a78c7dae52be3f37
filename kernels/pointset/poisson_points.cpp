#include <cmath>

#include "kernels/pointset/bucket_grid.h"
#include "kernels/pointset/iterative_points.h"
#include "kernels/pointset/weight_heap.h"

namespace meander {

namespace {

constexpr std::uint32_t candidates_per_point = 5;

}  // namespace

PlanarPoints poisson_disk_points(std::uint32_t count, RandomKey key) {
  const std::size_t candidates = std::size_t{candidates_per_point} * count;
  std::vector<double> x(candidates), y(candidates);
  for (std::size_t i = 0; i < candidates; ++i) {
    const UnitPair p = random_pair(key, Stream::point_set, i);
    x[i] = p.first;
    y[i] = p.second;
  }
  const EliminationWeight weight_at(1, count, static_cast<double>(candidates));
  const auto weight = [&](std::size_t i, std::size_t j) {
    return weight_at(std::hypot(x[i] - x[j], y[i] - y[j]));
  };
  const BucketGrid grid = bucket_points(x, y, static_cast<std::uint32_t>(1 / weight_at.reach));
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
