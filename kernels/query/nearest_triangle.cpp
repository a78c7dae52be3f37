#include "kernels/query/nearest_triangle.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <stdexcept>

#include "kernels/core/instruction_set.h"
#include "kernels/core/nearest_on_triangle.h"
#include "kernels/core/parallel.h"
#include "kernels/query/lanes.h"

namespace meander {

namespace {

constexpr std::size_t query_block = 512;
// Points farther than this are searched in double: in float all of the mesh is equally far from them.
constexpr double far_extent = 16;

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
MEANDER_INLINE bool look_at(const TriangleTree& tree, Vector3 point, std::size_t position, Found& found) {
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

// Points that lie beside each other along the curve and are searched for together: they visit much the same
// boxes, so that what a visit costs beside its arithmetic, waiting for memory and branches that no processor
// foresees, is paid once for all of them.
constexpr std::size_t group_size = lanes::count;

struct Group {
  std::array<Vector3, group_size> point;
  std::array<std::array<float, group_size>, 3> at;  // the points in float
  std::array<float, group_size> reach;              // below 0 in lanes without a point
  std::array<double, group_size> slack;
  std::array<Found, group_size> found;
};

struct Waiting {
  float squared;  // from the nearest point to the box
  std::uint32_t node, lane;
};

// A bit for each point that is within its reach of the box of a child.
template <class Floats>
MEANDER_INLINE unsigned points_near(const TriangleTree::Node& node, std::size_t c, const Group& group) {
  auto squared = lanes::all<Floats>(0.0f);
#pragma GCC unroll 3
  for (std::size_t k = 0; k < 3; ++k) {
    const auto at = lanes::load<Floats>(group.at[k].data());
    const Floats gap = at - lanes::larger(lanes::all<Floats>(node.low[k][c]),
                                          lanes::smaller(lanes::all<Floats>(node.high[k][c]), at));
    squared = squared + gap * gap;
  }
  return lanes::bits_of(squared <= lanes::load<Floats>(group.reach.data()));
}

// Adds the children of a node that are within reach of one of the points `of`, the nearest last.
template <class Floats>
MEANDER_INLINE std::size_t add_children(const TriangleTree& tree, std::uint32_t number, const Group& group,
                                        unsigned of, Waiting* stack, std::size_t waiting) {
  const TriangleTree::Node& node = tree.nodes[number];
  auto least = lanes::all<Floats>(std::numeric_limits<float>::infinity());
  unsigned near = 0;
  for (; of != 0; of &= of - 1) {
    const auto p = static_cast<std::size_t>(std::countr_zero(of));
    auto squared = lanes::all<Floats>(0.0f);
#pragma GCC unroll 3
    for (std::size_t k = 0; k < 3; ++k) {
      const auto at = lanes::all<Floats>(group.at[k][p]);
      const Floats gap = at - lanes::larger(lanes::load<Floats>(node.low[k].data()),
                                            lanes::smaller(lanes::load<Floats>(node.high[k].data()), at));
      squared = squared + gap * gap;
    }
    near |= lanes::bits_of(squared <= lanes::all<Floats>(group.reach[p]));
    least = lanes::smaller(squared, least);
  }
  std::array<float, lanes::count> gaps;
  lanes::store(least, gaps.data());
  const std::size_t first = waiting;
  for (; near != 0; near &= near - 1) {
    const auto lane = static_cast<std::uint32_t>(std::countr_zero(near));
    std::size_t place = waiting++;
    for (; place > first && stack[place - 1].squared < gaps[lane]; --place) stack[place] = stack[place - 1];
    stack[place] = {gaps[lane], number, lane};
  }
  return waiting;
}

// Looks at the triangles of a leaf that are within reach of a point.
template <class Floats>
MEANDER_INLINE void look_at_leaf(const TriangleTree& tree, std::size_t leaf, Group& group, std::size_t p) {
  const TriangleTree::Leaf& bounds = tree.leaves[leaf];
  const std::size_t begin = tree.leaf_begin[leaf], count = tree.leaf_begin[leaf + 1] - begin;
  const float x = group.at[0][p], y = group.at[1][p], z = group.at[2][p];
  const auto zero = lanes::all<Floats>(0.0f);
  Floats offset[4];
#pragma GCC unroll 4
  for (std::size_t k = 0; k < 4; ++k) {
    const auto& plane = bounds.plane[k];
    offset[k] = lanes::load<Floats>(plane[0].data()) * x + lanes::load<Floats>(plane[1].data()) * y +
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
  unsigned near = lanes::bits_of(squared <= lanes::all<Floats>(group.reach[p])) & ((1u << count) - 1);
  std::array<float, lanes::count> gaps;
  lanes::store(squared, gaps.data());
  // The nearest first, which leaves out most of the others.
  while (near != 0) {
    auto lane = static_cast<std::size_t>(std::countr_zero(near));
    for (unsigned rest = near & (near - 1); rest != 0; rest &= rest - 1) {
      const auto other = static_cast<std::size_t>(std::countr_zero(rest));
      if (gaps[other] < gaps[lane]) lane = other;
    }
    if (gaps[lane] > group.reach[p]) break;
    near &= ~(1u << lane);
    if (look_at(tree, group.point[p], begin + lane, group.found[p]))
      group.reach[p] = reach_of(group.found[p], group.slack[p]);
  }
}

// The nearest triangles of all points of the group, `of` a bit for each.
template <class Floats>
MEANDER_INLINE void search(const TriangleTree& tree, Group& group, unsigned of) {
  Waiting stack[TriangleTree::max_waiting];
  std::size_t waiting = add_children<Floats>(tree, 0, group, of, stack, 0);
  while (waiting > 0) {
    const Waiting next = stack[--waiting];
    const TriangleTree::Node& node = tree.nodes[next.node];
    of = points_near<Floats>(node, next.lane, group);
    const std::uint32_t child = node.child[next.lane];
    if (of == 0) continue;
    if ((child & TriangleTree::leaf_bit) == 0) {
      waiting = add_children<Floats>(tree, child, group, of, stack, waiting);
    } else {
      for (; of != 0; of &= of - 1)
        look_at_leaf<Floats>(tree, child & ~TriangleTree::leaf_bit, group,
                             static_cast<std::size_t>(std::countr_zero(of)));
    }
  }
}

using GroupSearch = void (*)(const TriangleTree& tree, Group& group, unsigned of);

void search_by_pairs(const TriangleTree& tree, Group& group, unsigned of) {
  search<lanes::Pairs::Floats>(tree, group, of);
}
MEANDER_TARGET("avx2") void search_avx2(const TriangleTree& tree, Group& group, unsigned of) {
  search<lanes::Wide::Floats>(tree, group, of);
}
// Both find the same.
GroupSearch search_of(InstructionSet set) { return takes_avx2(set) ? search_avx2 : search_by_pairs; }

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

// The points from `first` to `end`.
void search_run(const TriangleTree& tree, std::span<const double> points, std::size_t first, std::size_t end,
                GroupSearch search_group, NearestTriangles& out) {
  std::size_t position = 0;
  Group group{};
  for (std::size_t begin = first; begin < end; begin += group_size) {
    const std::size_t count = std::min(group_size, end - begin);
    unsigned near = 0;
    group.reach.fill(-1);
    for (std::size_t p = 0; p < count; ++p) {
      const std::size_t i = begin + p;
      const Vector3 point{points[3 * i], points[3 * i + 1], points[3 * i + 2]};
      const double extent = std::max({std::abs(point.x), std::abs(point.y), std::abs(point.z)});
      Found& found = group.found[p];
      found = {};
      found.triangle = TriangleTree::no_child;
      look_at(tree, point, position, found);
      if (extent > far_extent) {
        search_far(tree, point, extent, found);
        continue;
      }
      near |= 1u << p;
      group.point[p] = point;
      group.at[0][p] = static_cast<float>(point.x);
      group.at[1][p] = static_cast<float>(point.y);
      group.at[2][p] = static_cast<float>(point.z);
      group.slack[p] = float_slack(extent);
      group.reach[p] = reach_of(found, group.slack[p]);
    }
    if (near != 0) search_group(tree, group, near);
    for (std::size_t p = 0; p < count; ++p) {
      const std::size_t i = begin + p;
      const Found& found = group.found[p];
      out.distance[i] = std::sqrt(found.place.squared);
      out.triangle[i] = found.triangle;
      out.weights[2 * i] = found.place.weight1;
      out.weights[2 * i + 1] = found.place.weight2;
      position = found.position;
    }
  }
}

}  // namespace

NearestTriangles nearest_triangles(const TriangleTree& tree, std::span<const double> points,
                                   const CancelToken& cancel, InstructionSet set) {
  if (points.size() % 3 != 0) throw std::invalid_argument("nearest_triangles: three coordinates a point");
  for (const double c : points)
    if (!(std::abs(c) <= farthest_point))
      throw std::invalid_argument("nearest_triangles: points must be finite, and not too far from the mesh");
  const std::size_t count = points.size() / 3;
  const GroupSearch search_group = search_of(set);
  NearestTriangles out;
  out.distance.resize(count);
  out.triangle.resize(count);
  out.weights.resize(2 * count);
  parallel_blocks(count, query_block, [&](std::size_t begin, std::size_t end) {
    cancel.check();
    search_run(tree, points, begin, end, search_group, out);
  });
  return out;
}

}  // namespace meander
