#include "kernels/pointset/sample_elimination.h"

#include <array>
#include <cmath>
#include <stdexcept>

#include "kernels/analyse/kd_tree.h"
#include "kernels/core/parallel.h"
#include "kernels/pointset/weight_heap.h"

namespace meander {

namespace {

struct Neighbor {
  std::uint32_t point;
  float weight;
};

}  // namespace

std::vector<std::uint32_t> eliminate_samples(std::span<const double> points, std::uint32_t count,
                                             double area) {
  const std::size_t candidates = points.size() / 3;
  if (points.size() % 3 != 0 || count == 0 || count > candidates || !(area > 0))
    throw std::invalid_argument("sample elimination needs an area and at least as many points as samples");
  const EliminationWeight weight(area, count, static_cast<double>(candidates));
  const KdTree<3> tree(points);
  std::vector<std::vector<Neighbor>> around(candidates);
  parallel_blocks(candidates, 1024, [&](std::size_t begin, std::size_t end) {
    for (std::size_t position = begin; position < end; ++position) {
      const std::uint32_t own = tree.index(position);
      const std::array<double, 3>& at = tree.point(position);
      tree.in_ball(at, weight.reach * weight.reach, [&](std::uint32_t other, const auto& p) {
        if (other == own) return;
        const double w = weight(std::hypot(p[0] - at[0], p[1] - at[1], p[2] - at[2]));
        if (w > 0) around[own].push_back({other, static_cast<float>(w)});
      });
    }
  });
  std::vector<double> weights(candidates, 0.0);
  for (std::size_t i = 0; i < candidates; ++i)
    for (const Neighbor& neighbor : around[i]) weights[i] += static_cast<double>(neighbor.weight);

  WeightHeap heap(std::move(weights));
  std::vector<std::uint8_t> kept(candidates, 1);
  for (std::size_t gone = 0; gone < candidates - count; ++gone) {
    const std::uint32_t i = heap.pop();
    kept[i] = 0;
    for (const Neighbor& neighbor : around[i])
      if (kept[neighbor.point] != 0) heap.lessen(neighbor.point, static_cast<double>(neighbor.weight));
  }
  std::vector<std::uint32_t> remaining;
  for (std::uint32_t i = 0; i < candidates; ++i)
    if (kept[i] != 0) remaining.push_back(i);
  return remaining;
}

}  // namespace meander
