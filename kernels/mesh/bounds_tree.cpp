#include "kernels/mesh/bounds_tree.h"

#include <array>
#include <limits>

#include "kernels/core/parallel.h"
#include "kernels/core/radix_sort.h"
#include "kernels/curve/curve_key.h"

namespace meander {

namespace {

// Centre and longest half side of the box around everything; the half side is 1 for a single point.
struct CubeFrame {
  Vector3 centre;
  double half = 1;
};

CubeFrame cube_frame_of(std::span<const double> low, std::span<const double> high) {
  std::array<double, 3> least, most;
  least.fill(std::numeric_limits<double>::infinity());
  most.fill(-std::numeric_limits<double>::infinity());
  for (std::size_t i = 0; i < low.size(); i += 3)
    for (std::size_t k = 0; k < 3; ++k) {
      least[k] = std::min(least[k], low[i + k]);
      most[k] = std::max(most[k], high[i + k]);
    }
  CubeFrame frame;
  frame.centre = {0.5 * (least[0] + most[0]), 0.5 * (least[1] + most[1]), 0.5 * (least[2] + most[2])};
  frame.half = 0.5 * std::max({most[0] - least[0], most[1] - least[1], most[2] - least[2]});
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
      keys[i] = {hilbert_key_3d(scale * (middle - frame.centre)), static_cast<std::uint32_t>(i)};
    }
  });
  radix_sort(keys, scratch);
  std::vector<std::uint32_t> order(count);
  for (std::size_t i = 0; i < count; ++i) order[i] = keys[i].index;
  return order;
}

// Appends the centre and half-extent of [least, most].
void append_node(std::vector<double>& level, const std::array<double, 3>& least,
                 const std::array<double, 3>& most) {
  for (std::size_t k = 0; k < 3; ++k) level.push_back(0.5 * (least[k] + most[k]));
  for (std::size_t k = 0; k < 3; ++k) level.push_back(0.5 * (most[k] - least[k]));
}

}  // namespace

BoundsTree build_bounds_tree(std::span<const double> low, std::span<const double> high) {
  BoundsTree tree;
  tree.order = hilbert_order(low, high);
  const std::size_t count = tree.count();
  if (count == 0) return tree;

  std::array<double, 3> least, most;
  const auto restart = [&] {
    least.fill(std::numeric_limits<double>::infinity());
    most.fill(-std::numeric_limits<double>::infinity());
  };
  std::vector<double> level;
  for (std::size_t begin = 0; begin < count; begin += BoundsTree::leaf) {
    restart();
    for (std::size_t p = begin; p < std::min(count, begin + BoundsTree::leaf); ++p)
      for (std::size_t k = 0; k < 3; ++k) {
        least[k] = std::min(least[k], low[3 * std::size_t{tree.order[p]} + k]);
        most[k] = std::max(most[k], high[3 * std::size_t{tree.order[p]} + k]);
      }
    append_node(level, least, most);
  }
  while (level.size() > 6) {
    const std::size_t nodes = level.size() / 6;
    std::vector<double> above;
    for (std::size_t begin = 0; begin < nodes; begin += BoundsTree::fan) {
      restart();
      for (std::size_t i = begin; i < std::min(nodes, begin + BoundsTree::fan); ++i)
        for (std::size_t k = 0; k < 3; ++k) {
          least[k] = std::min(least[k], level[6 * i + k] - level[6 * i + 3 + k]);
          most[k] = std::max(most[k], level[6 * i + k] + level[6 * i + 3 + k]);
        }
      append_node(above, least, most);
    }
    tree.levels.push_back(std::move(level));
    level = std::move(above);
  }
  tree.levels.push_back(std::move(level));
  return tree;
}

}  // namespace meander
