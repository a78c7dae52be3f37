#include "kernels/analyse/point_index.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "kernels/core/parallel.h"
#include "kernels/core/radix_sort.h"
#include "kernels/curve/curve_key.h"

namespace meander {

namespace {

// Nodes nearer than this to a face are looked at point by point: above all rounding of the bounds.
constexpr double margin = 1e-12;

template <std::size_t D>
PointIndex<D> build(const std::array<std::span<const double>, D>& points) {
  const std::size_t count = points[0].size();
  for (const auto& coordinate : points)
    if (coordinate.size() != count) throw std::invalid_argument("coordinates of different lengths");
  std::vector<KeyIndex> keys(count), scratch;
  parallel_blocks(count, sum_block, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      std::uint64_t key = 0;
      if constexpr (D == 2)
        key = curve_key(CurveKind::hilbert, points[0][i], points[1][i]) >> 20;  // the sort skips digits
      else
        key = hilbert_key_3d({points[0][i], points[1][i], points[2][i]}) >> 19;
      keys[i] = {key, static_cast<std::uint32_t>(i)};
    }
  });
  radix_sort(keys, scratch);
  PointIndex<D> index;
  for (std::size_t k = 0; k < D; ++k) {
    index.at[k].resize(count);
    for (std::size_t i = 0; i < count; ++i) index.at[k][i] = points[k][keys[i].index];
  }
  if (count == 0) return index;

  std::array<double, D> least, most;
  const auto restart = [&] {
    least.fill(std::numeric_limits<double>::infinity());
    most.fill(-std::numeric_limits<double>::infinity());
  };
  const auto append = [&](std::vector<double>& level) {
    for (std::size_t k = 0; k < D; ++k) level.push_back(0.5 * (least[k] + most[k]));
    for (std::size_t k = 0; k < D; ++k) level.push_back(0.5 * (most[k] - least[k]));
  };
  std::vector<double> level;
  for (std::size_t begin = 0; begin < count; begin += PointIndex<D>::leaf) {
    restart();
    for (std::size_t i = begin; i < std::min(count, begin + PointIndex<D>::leaf); ++i)
      for (std::size_t k = 0; k < D; ++k) {
        least[k] = std::min(least[k], index.at[k][i]);
        most[k] = std::max(most[k], index.at[k][i]);
      }
    append(level);
  }
  while (level.size() > 2 * D) {
    const std::size_t nodes = level.size() / (2 * D);
    std::vector<double> above;
    for (std::size_t begin = 0; begin < nodes; begin += PointIndex<D>::fan) {
      restart();
      for (std::size_t i = begin; i < std::min(nodes, begin + PointIndex<D>::fan); ++i)
        for (std::size_t k = 0; k < D; ++k) {
          const double* node = level.data() + 2 * D * i;
          least[k] = std::min(least[k], node[k] - node[D + k]);
          most[k] = std::max(most[k], node[k] + node[D + k]);
        }
      append(above);
    }
    index.levels.push_back(std::move(level));
    level = std::move(above);
  }
  index.levels.push_back(std::move(level));
  return index;
}

template <std::size_t D>
struct Counter {
  const PointIndex<D>& points;
  std::span<const HalfSpace<D>> shape;

  // `open`: the half-spaces, one bit each, that the node is not known to be inside.
  std::size_t count(std::size_t level, std::size_t node, unsigned open) const {
    const double* box = points.levels[level].data() + 2 * D * node;
    for (std::size_t s = 0; s < shape.size(); ++s) {
      if ((open >> s & 1) == 0) continue;
      const HalfSpace<D>& half_space = shape[s];
      double beyond = -half_space.offset, reach = 0;
      for (std::size_t k = 0; k < D; ++k) {
        beyond += half_space.normal[k] * box[k];
        reach += std::abs(half_space.normal[k]) * box[D + k];
      }
      if (beyond - reach > margin) return 0;
      if (beyond + reach < -margin) open &= ~(1u << s);
    }
    if (open != 0 && level > 0) {
      const std::size_t below = points.levels[level - 1].size() / (2 * D);
      const std::size_t last = std::min(below, PointIndex<D>::fan * (node + 1));
      std::size_t sum = 0;
      for (std::size_t child = PointIndex<D>::fan * node; child < last; ++child)
        sum += count(level - 1, child, open);
      return sum;
    }
    std::size_t run = PointIndex<D>::leaf;
    for (std::size_t l = 0; l < level; ++l) run *= PointIndex<D>::fan;
    const std::size_t begin = node * run, end = std::min(points.count(), begin + run);
    return open == 0 ? end - begin : count_leaf(begin, end, open);
  }

  std::size_t count_leaf(std::size_t begin, std::size_t end, unsigned open) const {
    std::array<std::uint8_t, PointIndex<D>::leaf> inside;
    inside.fill(1);
    for (std::size_t s = 0; s < shape.size(); ++s) {
      if ((open >> s & 1) == 0) continue;
      for (std::size_t i = begin; i < end; ++i) {
        std::array<double, D> p;
        for (std::size_t k = 0; k < D; ++k) p[k] = points.at[k][i];
        inside[i - begin] &= static_cast<std::uint8_t>(contains(shape[s], p));
      }
    }
    std::size_t sum = 0;
    for (std::size_t i = begin; i < end; ++i) sum += inside[i - begin];
    return sum;
  }
};

template <std::size_t D>
std::size_t count_points(const PointIndex<D>& points, std::span<const HalfSpace<D>> shape) {
  if (shape.size() > 8) throw std::invalid_argument("a shape has at most 8 half-spaces");
  if (points.count() == 0) return 0;
  return Counter<D>{points, shape}.count(points.levels.size() - 1, 0, (1u << shape.size()) - 1);
}

struct DiskCounter {
  const PointIndex<2>& points;
  std::array<double, 2> center;
  double radius;

  std::size_t count(std::size_t level, std::size_t node) const {
    const double* box = points.levels[level].data() + 4 * node;
    double nearest = 0, farthest = 0;  // squared distances of the box
    for (std::size_t k = 0; k < 2; ++k) {
      const double d = std::abs(box[k] - center[k]);
      const double low = std::max(0.0, d - box[2 + k] - margin), high = d + box[2 + k] + margin;
      nearest += low * low;
      farthest += high * high;
    }
    if (nearest > radius * radius * (1 + margin)) return 0;
    const bool inside = farthest < radius * radius * (1 - margin);
    if (!inside && level > 0) {
      const std::size_t below = points.levels[level - 1].size() / 4;
      const std::size_t last = std::min(below, PointIndex<2>::fan * (node + 1));
      std::size_t sum = 0;
      for (std::size_t child = PointIndex<2>::fan * node; child < last; ++child)
        sum += count(level - 1, child);
      return sum;
    }
    std::size_t run = PointIndex<2>::leaf;
    for (std::size_t l = 0; l < level; ++l) run *= PointIndex<2>::fan;
    const std::size_t begin = node * run, end = std::min(points.count(), begin + run);
    if (inside) return end - begin;
    std::size_t sum = 0;
    for (std::size_t i = begin; i < end; ++i) {
      const double dx = points.at[0][i] - center[0], dy = points.at[1][i] - center[1];
      sum += dx * dx + dy * dy <= radius * radius;
    }
    return sum;
  }
};

}  // namespace

PointIndex<2> build_point_index(std::span<const double> x, std::span<const double> y) {
  return build<2>({x, y});
}

PointIndex<3> build_point_index(std::span<const double> x, std::span<const double> y,
                                std::span<const double> z) {
  return build<3>({x, y, z});
}

std::size_t count_inside(const PointIndex<2>& points, std::span<const HalfSpace<2>> shape) {
  return count_points<2>(points, shape);
}

std::size_t count_inside(const PointIndex<3>& points, std::span<const HalfSpace<3>> shape) {
  return count_points<3>(points, shape);
}

std::size_t count_in_disk(const PointIndex<2>& points, const std::array<double, 2>& center, double radius) {
  if (points.count() == 0) return 0;
  return DiskCounter{points, center, radius}.count(points.levels.size() - 1, 0);
}

}  // namespace meander
