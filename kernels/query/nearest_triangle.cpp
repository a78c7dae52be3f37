#include "kernels/query/nearest_triangle.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <stdexcept>

#include "kernels/core/nearest_on_triangle.h"
#include "kernels/core/parallel.h"
#include "kernels/core/radix_sort.h"
#include "kernels/curve/curve_key.h"
#include "kernels/query/lanes.h"

namespace meander {

namespace {

constexpr std::size_t query_block = 512;
// Points farther than this are searched in double: in float all of the mesh is equally far from them.
constexpr double far_extent = 16;

// The order of points takes those beyond as lying there, so that few of them do not spoil that of the others.
constexpr double curve_extent = 1.5;

using lanes::Floats;

struct Found {
  TrianglePlace place;
  std::uint32_t triangle = 0;
  std::size_t position = 0;

  // No two triangles are equal in this order.
  bool offer(const TrianglePlace& other, std::uint32_t other_triangle, std::size_t other_position) {
    if (other.squared > place.squared || (other.squared == place.squared && other_triangle >= triangle))
      return false;
    place = other;
    triangle = other_triangle;
    position = other_position;
    return true;
  }
};

// The triangle found is the same by a second look.
bool look_at(const TriangleTree& tree, Vector3 point, std::size_t position, Found& found) {
  if (found.triangle == tree.order[position]) return false;
  return found.offer(nearest_on_triangle(point, tree.corner(position, 0), tree.corner(position, 1),
                                         tree.corner(position, 2)),
                     tree.order[position], position);
}

// Squared distances to boxes and planes below this one may be those of triangles as near as the best.
float reach_of(const Found& found, double slack) {
  const double reach = (std::sqrt(found.place.squared) + slack) * (1 + 4e-6);
  return static_cast<float>(reach * reach);
}

struct Waiting {
  float squared;
  std::uint32_t child;
};

MEANDER_INLINE void search(const TriangleTree& tree, Vector3 point, double extent, Found& found) {
  const float x = static_cast<float>(point.x), y = static_cast<float>(point.y),
              z = static_cast<float>(point.z);
  const double slack = float_slack(extent);
  float reach = reach_of(found, slack);
  Waiting stack[TriangleTree::max_waiting];
  std::size_t waiting = 0;
  std::uint32_t at = 0;
  const auto zero = lanes::all<Floats>(0.0f);
  for (;;) {
    if ((at & TriangleTree::leaf_bit) == 0) {
      const TriangleTree::Node& node = tree.nodes[at];
      Floats squared = zero;
      const float coordinate[3] = {x, y, z};
#pragma GCC unroll 3
      for (std::size_t k = 0; k < 3; ++k) {
        const Floats below = lanes::load<Floats>(node.low[k].data()) - coordinate[k],
                     above = coordinate[k] - lanes::load<Floats>(node.high[k].data());
        const Floats gap = lanes::larger(lanes::larger(below, above), zero);
        squared = squared + gap * gap;
      }
      unsigned near = lanes::bits_of(squared <= reach);
      float gaps[lanes::count];
      lanes::store(squared, gaps);
      // The nearest child is taken next: it comes last.
      const std::size_t first = waiting;
      for (; near != 0; near &= near - 1) {
        const auto lane = static_cast<std::size_t>(std::countr_zero(near));
        std::size_t place = waiting++;
        for (; place > first && stack[place - 1].squared < gaps[lane]; --place)
          stack[place] = stack[place - 1];
        stack[place] = {gaps[lane], node.child[lane]};
      }
    } else {
      const std::size_t leaf = at & ~TriangleTree::leaf_bit;
      const TriangleTree::Leaf& bounds = tree.leaves[leaf];
      const std::size_t begin = tree.leaf_begin[leaf], count = tree.leaf_begin[leaf + 1] - begin;
      Floats offset[4];
#pragma GCC unroll 4
      for (std::size_t p = 0; p < 4; ++p) {
        const auto& plane = bounds.plane[p];
        offset[p] = lanes::load<Floats>(plane[0].data()) * x + lanes::load<Floats>(plane[1].data()) * y +
                    lanes::load<Floats>(plane[2].data()) * z - lanes::load<Floats>(plane[3].data());
      }
      Floats beyond = lanes::larger(lanes::larger(lanes::larger(offset[1], offset[2]), offset[3]), zero);
      // Beyond the ball, along the plane.
      const Floats dx = lanes::load<Floats>(bounds.center[0].data()) - x,
                   dy = lanes::load<Floats>(bounds.center[1].data()) - y,
                   dz = lanes::load<Floats>(bounds.center[2].data()) - z, height = offset[0] * offset[0];
      const Floats along = lanes::root(lanes::larger(dx * dx + dy * dy + dz * dz - height, zero));
      beyond = lanes::larger(beyond, along - lanes::load<Floats>(bounds.radius.data()));
      const Floats squared = height + beyond * beyond;
      unsigned near = lanes::bits_of(squared <= reach) & ((1u << count) - 1);
      float gaps[lanes::count];
      lanes::store(squared, gaps);
      // The nearest first, which leaves out most of the others.
      while (near != 0) {
        auto lane = static_cast<std::size_t>(std::countr_zero(near));
        for (unsigned rest = near & (near - 1); rest != 0; rest &= rest - 1) {
          const auto other = static_cast<std::size_t>(std::countr_zero(rest));
          if (gaps[other] < gaps[lane]) lane = other;
        }
        if (gaps[lane] > reach) break;
        near &= ~(1u << lane);
        if (look_at(tree, point, begin + lane, found)) reach = reach_of(found, slack);
      }
    }
    do {
      if (waiting == 0) return;
      --waiting;
    } while (stack[waiting].squared > reach);
    at = stack[waiting].child;
  }
}

// The same for points that are far away, in double.
void search_far(const TriangleTree& tree, Vector3 point, double extent, Found& found) {
  std::vector<std::uint32_t> waiting{0};
  const std::array<double, 3> at{point.x, point.y, point.z};
  while (!waiting.empty()) {
    const std::uint32_t child = waiting.back();
    waiting.pop_back();
    if ((child & TriangleTree::leaf_bit) != 0) {
      const std::size_t leaf = child & ~TriangleTree::leaf_bit;
      for (std::size_t p = tree.leaf_begin[leaf]; p < tree.leaf_begin[leaf + 1]; ++p)
        look_at(tree, point, p, found);
      continue;
    }
    const TriangleTree::Node& node = tree.nodes[child];
    const double reach = std::sqrt(found.place.squared) + 1e-14 * (1 + extent);
    for (std::size_t c = 0; c < lanes::count && node.child[c] != TriangleTree::no_child; ++c) {
      double squared = 0;
      for (std::size_t k = 0; k < 3; ++k) {
        const double gap = std::max({node.low[k][c] - at[k], at[k] - node.high[k][c], 0.0});
        squared += gap * gap;
      }
      if (std::sqrt(squared) <= reach) waiting.push_back(node.child[c]);
    }
  }
}

// The points in their order from `begin` to `end`.
void search_run(const TriangleTree& tree, std::span<const double> points, std::span<const std::uint32_t> run,
                NearestTriangles& out) {
  std::size_t position = 0;
  for (std::size_t r = 0; r < run.size(); ++r) {
    const std::uint32_t i = run[r];
    if (r + lanes::ahead < run.size()) {
      const std::size_t next = run[r + lanes::ahead];
      __builtin_prefetch(points.data() + 3 * next);
      __builtin_prefetch(points.data() + 3 * next + 2);
      __builtin_prefetch(out.distance.data() + next, 1);
      __builtin_prefetch(out.triangle.data() + next, 1);
      __builtin_prefetch(out.weights.data() + 2 * next, 1);
    }
    const Vector3 point{points[3 * std::size_t{i}], points[3 * std::size_t{i} + 1],
                        points[3 * std::size_t{i} + 2]};
    const double extent = std::max({std::abs(point.x), std::abs(point.y), std::abs(point.z)});
    Found found;
    found.triangle = TriangleTree::no_child;
    look_at(tree, point, position, found);
    if (extent > far_extent)
      search_far(tree, point, extent, found);
    else
      search(tree, point, extent, found);
    position = found.position;
    out.distance[i] = std::sqrt(found.place.squared);
    out.triangle[i] = found.triangle;
    out.weights[2 * std::size_t{i}] = found.place.weight1;
    out.weights[2 * std::size_t{i} + 1] = found.place.weight2;
  }
}

}  // namespace

std::vector<std::uint32_t> order_along_curve(std::span<const double> points) {
  const std::size_t count = points.size() / 3;
  std::array<double, 3> low, high;
  low.fill(curve_extent);
  high.fill(-curve_extent);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double at = std::clamp(points[i], -curve_extent, curve_extent);
    low[i % 3] = std::min(low[i % 3], at);
    high[i % 3] = std::max(high[i % 3], at);
  }
  const double half = 0.5 * std::max({high[0] - low[0], high[1] - low[1], high[2] - low[2]});
  const double scale = half > 0 ? 1 / half : 0;
  std::vector<KeyIndex> keys(count), scratch;
  parallel_blocks(count, sum_block, [&](std::size_t begin, std::size_t end) {
    std::vector<float> unit(3 * (end - begin));
    std::vector<std::uint64_t> key(end - begin);
    for (std::size_t i = 0; i < unit.size(); ++i) {
      const std::size_t k = i % 3;
      const double at = std::clamp(points[3 * begin + i], -curve_extent, curve_extent);
      unit[i] = static_cast<float>(scale * (at - 0.5 * (low[k] + high[k])));
    }
    coarse_hilbert_keys_3d({unit.data(), 3}, key);
    for (std::size_t i = begin; i < end; ++i) keys[i] = {key[i - begin], static_cast<std::uint32_t>(i)};
  });
  radix_sort(keys, scratch);
  std::vector<std::uint32_t> order(count);
  for (std::size_t i = 0; i < count; ++i) order[i] = keys[i].index;
  return order;
}

NearestTriangles nearest_triangles(const TriangleTree& tree, std::span<const double> points,
                                   const CancelToken& cancel) {
  if (points.size() % 3 != 0) throw std::invalid_argument("nearest_triangles: three coordinates a point");
  if (points.size() / 3 > TriangleTree::no_child)
    throw std::invalid_argument("nearest_triangles: at most 2^32 - 1 points");
  for (const double c : points)
    if (!(std::abs(c) <= farthest_point))
      throw std::invalid_argument("nearest_triangles: points must be finite, and not too far from the mesh");
  const std::size_t count = points.size() / 3;
  NearestTriangles out;
  out.distance.resize(count);
  out.triangle.resize(count);
  out.weights.resize(2 * count);
  out.order = order_along_curve(points);
  parallel_blocks(count, query_block, [&](std::size_t begin, std::size_t end) {
    cancel.check();
    search_run(tree, points, std::span(out.order).subspan(begin, end - begin), out);
  });
  return out;
}

}  // namespace meander
