#include "kernels/mesh/bounds_tree.h"

#include <array>
#include <limits>

#include "kernels/core/parallel.h"
#include "kernels/core/radix_sort.h"
#include "kernels/curve/curve_key.h"

namespace meander {

namespace {

// Center and half of the longest side of the box around everything; the half side is 1 for a single point.
struct CubeFrame {
  Vector3 center;
  double half = 1;
};

CubeFrame cube_frame_of(std::span<const double> low, std::span<const double> high) {
  std::array<double, 3> min, max;
  min.fill(std::numeric_limits<double>::infinity());
  max.fill(-std::numeric_limits<double>::infinity());
  for (std::size_t i = 0; i < low.size(); i += 3)
    for (std::size_t k = 0; k < 3; ++k) {
      min[k] = std::min(min[k], low[i + k]);
      max[k] = std::max(max[k], high[i + k]);
    }
  CubeFrame frame;
  frame.center = {0.5 * (min[0] + max[0]), 0.5 * (min[1] + max[1]), 0.5 * (min[2] + max[2])};
  frame.half = 0.5 * std::max({max[0] - min[0], max[1] - min[1], max[2] - min[2]});
  if (!(frame.half > 0)) frame.half = 1;
  return frame;
}

std::vector<std::uint32_t> hilbert_order(std::span<const double> low, std::span<const double> high) {
  const std::size_t count = low.size() / 3;
  const CubeFrame frame = cube_frame_of(low, high);
  const double scale = 1 / frame.half;
  std::vector<KeyIndex> keys(count), scratch;
  parallel_blocks(count, sum_block, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const Vector3 middle{0.5 * (low[3 * i] + high[3 * i]), 0.5 * (low[3 * i + 1] + high[3 * i + 1]),
                           0.5 * (low[3 * i + 2] + high[3 * i + 2])};
      keys[i] = {hilbert_key_3d(scale * (middle - frame.center)), static_cast<std::uint32_t>(i)};
    }
  });
  radix_sort(keys, scratch);
  std::vector<std::uint32_t> order(count);
  for (std::size_t i = 0; i < count; ++i) order[i] = keys[i].index;
  return order;
}

// Appends the center and half-extent of [min, max].
void append_node(std::vector<double>& level, const std::array<double, 3>& min,
                 const std::array<double, 3>& max) {
  for (std::size_t k = 0; k < 3; ++k) level.push_back(0.5 * (min[k] + max[k]));
  for (std::size_t k = 0; k < 3; ++k) level.push_back(0.5 * (max[k] - min[k]));
}

}  // namespace

BoundsTree build_bounds_tree(std::span<const double> low, std::span<const double> high) {
  BoundsTree tree;
  tree.order = hilbert_order(low, high);
  const std::size_t count = tree.count();
  if (count == 0) return tree;

  std::array<double, 3> min, max;
  const auto restart = [&] {
    min.fill(std::numeric_limits<double>::infinity());
    max.fill(-std::numeric_limits<double>::infinity());
  };
  std::vector<double> level;
  for (std::size_t begin = 0; begin < count; begin += BoundsTree::leaf) {
    restart();
    for (std::size_t p = begin; p < std::min(count, begin + BoundsTree::leaf); ++p)
      for (std::size_t k = 0; k < 3; ++k) {
        min[k] = std::min(min[k], low[3 * std::size_t{tree.order[p]} + k]);
        max[k] = std::max(max[k], high[3 * std::size_t{tree.order[p]} + k]);
      }
    append_node(level, min, max);
  }
  while (level.size() > 6) {
    const std::size_t nodes = level.size() / 6;
    std::vector<double> above;
    for (std::size_t begin = 0; begin < nodes; begin += BoundsTree::fan) {
      restart();
      for (std::size_t i = begin; i < std::min(nodes, begin + BoundsTree::fan); ++i)
        for (std::size_t k = 0; k < 3; ++k) {
          min[k] = std::min(min[k], level[6 * i + k] - level[6 * i + 3 + k]);
          max[k] = std::max(max[k], level[6 * i + k] + level[6 * i + 3 + k]);
        }
      append_node(above, min, max);
    }
    tree.levels.push_back(std::move(level));
    level = std::move(above);
  }
  tree.levels.push_back(std::move(level));
  return tree;
}

}  // namespace meander
