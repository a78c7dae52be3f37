#include "kernels/query/triangle_tree.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "kernels/core/parallel.h"

namespace meander {

namespace {

constexpr std::size_t fan = TriangleTree::fan;
constexpr float infinity = std::numeric_limits<float>::infinity();
constexpr std::size_t bins = 16;
// Every leaf has at least this many triangles where there are more than 8, which bounds the memory.
constexpr std::size_t least_in_leaf = 3;
// Beyond, ranges are halved, which ends after log8(2^32) levels: 8 x 40 nodes at most wait in a stack.
constexpr int heuristic_depth = 28;
// Ranges that become tasks.
constexpr std::size_t many_triangles = 16384;

struct Box {
  std::array<float, 3> low{infinity, infinity, infinity}, high{-infinity, -infinity, -infinity};

  void add(const Box& other) {
    for (std::size_t k = 0; k < 3; ++k) {
      low[k] = std::min(low[k], other.low[k]);
      high[k] = std::max(high[k], other.high[k]);
    }
  }
  // Half of it; 0 of nothing.
  float surface() const {
    if (!(high[0] >= low[0])) return 0;
    const float a = high[0] - low[0], b = high[1] - low[1], c = high[2] - low[2];
    return a * b + b * c + c * a;
  }
};

struct Item {
  Box box;
  std::uint32_t triangle = 0;

  float middle(std::size_t axis) const { return box.low[axis] + box.high[axis]; }  // twice
};

// A run of items with its box.
struct Range {
  std::size_t begin = 0, end = 0;
  Box box;

  std::size_t count() const { return end - begin; }
};

// What a range, or a subtree of many items, adds to the tree: its nodes refer to its own nodes and leaves.
struct Part {
  std::vector<TriangleTree::Node> nodes;
  std::vector<std::uint32_t> leaf_end;  // by positions
};

float rounded_down(double value) {
  const auto f = static_cast<float>(value);
  return static_cast<double>(f) > value ? std::nextafter(f, -infinity) : f;
}
float rounded_up(double value) { return -rounded_down(-value); }

class Builder {
 public:
  explicit Builder(std::vector<Item>& items) : items_(items), scratch_(items.size()) {}

  Part build(const Range& range, int depth) {
    Part part;
    add_node(range, depth, part);
    return part;
  }

  Box box_of(std::size_t begin, std::size_t end) const {
    Box box;
    for (std::size_t i = begin; i < end; ++i) box.add(items_[i].box);
    return box;
  }

 private:
  // The node of a range comes before those of its children.
  void add_node(const Range& range, int depth, Part& part) {
    std::array<Range, fan> child;
    child[0] = range;
    std::size_t count = 1;
    while (count < fan) {
      const std::size_t largest = largest_of({child.data(), count}, depth);
      if (largest == count) break;
      child[count] = split(child[largest], depth);
      ++count;
    }
    // Leaves ascend by position. Insertion: GCC 14 reports that std::sort reads beyond so few.
    for (std::size_t c = 1; c < count; ++c)
      for (std::size_t at = c; at > 0 && child[at].begin < child[at - 1].begin; --at)
        std::swap(child[at], child[at - 1]);
    const std::size_t own = part.nodes.size();
    part.nodes.emplace_back();
    for (std::size_t c = 0; c < fan; ++c) {
      TriangleTree::Node& node = part.nodes[own];
      node.child[c] = TriangleTree::no_child;
      for (std::size_t k = 0; k < 3; ++k) {
        node.low[k][c] = c < count ? child[c].box.low[k] : infinity;
        node.high[k][c] = c < count ? child[c].box.high[k] : infinity;
      }
    }
    if (range.count() > many_triangles) {
      std::array<Part, fan> below;
      parallel_tasks(count, [&](std::size_t c) {
        if (child[c].count() > fan) below[c] = build(child[c], depth + 1);
      });
      for (std::size_t c = 0; c < count; ++c)
        part.nodes[own].child[c] = child[c].count() > fan ? append(below[c], part) : add_leaf(child[c], part);
      return;
    }
    for (std::size_t c = 0; c < count; ++c) {
      const auto next = static_cast<std::uint32_t>(part.nodes.size());
      if (child[c].count() > fan) {
        part.nodes[own].child[c] = next;
        add_node(child[c], depth + 1, part);
      } else {
        part.nodes[own].child[c] = add_leaf(child[c], part);
      }
    }
  }

  // The range to split next: the largest in surface, or in items, that is no leaf. The number of ranges where
  // all are.
  static std::size_t largest_of(std::span<const Range> ranges, int depth) {
    const auto size = [&](const Range& range) {
      return depth < heuristic_depth ? range.box.surface() : static_cast<float>(range.count());
    };
    std::size_t largest = ranges.size();
    for (std::size_t c = 0; c < ranges.size(); ++c)
      if (ranges[c].count() > fan && (largest == ranges.size() || size(ranges[c]) > size(ranges[largest])))
        largest = c;
    return largest;
  }

  static std::uint32_t add_leaf(const Range& range, Part& part) {
    part.leaf_end.push_back(static_cast<std::uint32_t>(range.end));
    return TriangleTree::leaf_bit | static_cast<std::uint32_t>(part.leaf_end.size() - 1);
  }

  static std::uint32_t append(const Part& below, Part& part) {
    const auto nodes = static_cast<std::uint32_t>(part.nodes.size()),
               leaves = static_cast<std::uint32_t>(part.leaf_end.size());
    for (TriangleTree::Node node : below.nodes) {
      for (std::uint32_t& child : node.child)
        if (child != TriangleTree::no_child) child += (child & TriangleTree::leaf_bit) != 0 ? leaves : nodes;
      part.nodes.push_back(node);
    }
    part.leaf_end.insert(part.leaf_end.end(), below.leaf_end.begin(), below.leaf_end.end());
    return nodes;
  }

  // Leaves the first part in `range` and returns the second; neither is empty.
  Range split(Range& range, int depth) {
    std::size_t middle = range.begin;
    if (depth < heuristic_depth) middle = partition(range);
    if (middle == range.begin || middle == range.end) middle = range.begin + range.count() / 2;
    const Range second{middle, range.end, box_of(middle, range.end)};
    range = {range.begin, middle, box_of(range.begin, middle)};
    return second;
  }

  // Moves the items of the cheaper side to the front, in their order, and returns where the others begin; one
  // of the ends where no plane divides them.
  std::size_t partition(const Range& range) {
    std::array<float, 3> least, most;
    least.fill(infinity);
    most.fill(-infinity);
    for (std::size_t i = range.begin; i < range.end; ++i)
      for (std::size_t k = 0; k < 3; ++k) {
        const float middle = items_[i].middle(k);
        least[k] = std::min(least[k], middle);
        most[k] = std::max(most[k], middle);
      }
    float best_cost = infinity;
    std::size_t best_axis = 3, best_bin = 0;
    std::array<float, 3> scale{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const float extent = most[axis] - least[axis];
      if (!(extent > 0)) continue;
      scale[axis] = static_cast<float>(bins) / extent;
      if (!std::isfinite(scale[axis])) continue;
      std::array<Box, bins> box;
      std::array<std::size_t, bins> number{};
      for (std::size_t i = range.begin; i < range.end; ++i) {
        const std::size_t bin = bin_of(items_[i], axis, least[axis], scale[axis]);
        box[bin].add(items_[i].box);
        ++number[bin];
      }
      // Costs of the sides of the planes: below bin b, and from it on.
      std::array<float, bins> above{};
      Box all;
      std::size_t count = 0;
      for (std::size_t b = bins - 1; b > 0; --b) {
        all.add(box[b]);
        count += number[b];
        above[b] = all.surface() * static_cast<float>(count);
      }
      all = {};
      count = 0;
      for (std::size_t b = 1; b < bins; ++b) {
        all.add(box[b - 1]);
        count += number[b - 1];
        if (count < least_in_leaf || count + least_in_leaf > range.count()) continue;
        const float cost = all.surface() * static_cast<float>(count) + above[b];
        if (cost < best_cost) {
          best_cost = cost;
          best_axis = axis;
          best_bin = b;
        }
      }
    }
    if (best_axis == 3) return range.begin;
    std::size_t front = range.begin, back = range.begin;
    for (std::size_t i = range.begin; i < range.end; ++i) {
      const bool first = bin_of(items_[i], best_axis, least[best_axis], scale[best_axis]) < best_bin;
      if (first)
        items_[front++] = items_[i];
      else
        scratch_[back++] = items_[i];
    }
    std::copy(scratch_.begin() + static_cast<std::ptrdiff_t>(range.begin),
              scratch_.begin() + static_cast<std::ptrdiff_t>(back),
              items_.begin() + static_cast<std::ptrdiff_t>(front));
    return front;
  }

  static std::size_t bin_of(const Item& item, std::size_t axis, float least, float scale) {
    return std::min(bins - 1, static_cast<std::size_t>((item.middle(axis) - least) * scale));
  }

  std::vector<Item>& items_;
  std::vector<Item> scratch_;
};

// The middle of the smallest ball around a triangle.
Vector3 ball_center(const std::array<Vector3, 3>& corner) {
  for (std::size_t k = 0; k < 3; ++k) {
    const Vector3 a = corner[k], b = corner[(k + 1) % 3], c = corner[(k + 2) % 3], middle = 0.5 * (a + b);
    if (dot(c - a, c - b) <= 0) return middle;
  }
  const Vector3 b = corner[1] - corner[0], c = corner[2] - corner[0], normal = cross(b, c);
  const Vector3 scaled = dot(c, c) * cross(normal, b) + dot(b, b) * cross(c, normal);
  return corner[0] + (1 / (2 * dot(normal, normal))) * scaled;
}

// The bounds of a triangle: a, b, c its corners.
void set_bounds(TriangleTree::Leaf& leaf, std::size_t lane, Vector3 a, Vector3 b, Vector3 c) {
  const auto set = [&](std::size_t plane, Vector3 normal, Vector3 through) {
    auto& at = leaf.plane[plane];
    at[0][lane] = static_cast<float>(normal.x);
    at[1][lane] = static_cast<float>(normal.y);
    at[2][lane] = static_cast<float>(normal.z);
    at[3][lane] = static_cast<float>(dot(normal, through));
  };
  const std::array<Vector3, 3> corner{a, b, c};
  Vector3 center = ball_center(corner);
  if (!(norm(center) <= 2)) center = 1.0 / 3 * (a + b + c);
  leaf.center[0][lane] = static_cast<float>(center.x);
  leaf.center[1][lane] = static_cast<float>(center.y);
  leaf.center[2][lane] = static_cast<float>(center.z);
  leaf.radius[lane] = rounded_up(std::max({distance(center, a), distance(center, b), distance(center, c)}));
  const Vector3 twice = cross(b - a, c - a);
  const double area = norm(twice), longest = std::max({distance(a, b), distance(b, c), distance(c, a)});
  // The direction of `twice` is certain to 1e-16 longest^2 / area.
  if (!(area > 1e-8 * longest * longest)) return;
  const Vector3 normal = (1 / area) * twice;
  set(0, normal, a);
  for (std::size_t k = 0; k < 3; ++k) {
    const Vector3 edge = corner[(k + 1) % 3] - corner[k];
    set(1 + k, (1 / norm(edge)) * cross(edge, normal), corner[k]);
  }
}

}  // namespace

TriangleTree build_triangle_tree(std::span<const double> x, std::span<const double> y,
                                 std::span<const double> z, std::span<const std::uint32_t> triangles) {
  if (x.size() != y.size() || x.size() != z.size())
    throw std::invalid_argument("build_triangle_tree: as many x as y and z of vertices");
  if (triangles.empty() || triangles.size() % 3 != 0)
    throw std::invalid_argument(
        "build_triangle_tree: three vertex numbers a triangle, and at least one triangle");
  for (const std::uint32_t v : triangles)
    if (v >= x.size() || !(std::abs(x[v]) <= 1 && std::abs(y[v]) <= 1 && std::abs(z[v]) <= 1))
      throw std::invalid_argument("build_triangle_tree: corners must be vertices within [-1, 1]");
  const std::size_t count = triangles.size() / 3;
  std::vector<Item> items(count);
  parallel_blocks(count, sum_block, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) {
      Item& item = items[t];
      item.triangle = static_cast<std::uint32_t>(t);
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t v = triangles[3 * t + k];
        const std::array<double, 3> at{x[v], y[v], z[v]};
        for (std::size_t axis = 0; axis < 3; ++axis) {
          item.box.low[axis] = std::min(item.box.low[axis], rounded_down(at[axis]));
          item.box.high[axis] = std::max(item.box.high[axis], rounded_up(at[axis]));
        }
      }
    }
  });
  TriangleTree tree;
  {
    Builder builder(items);
    Part part = builder.build({0, count, builder.box_of(0, count)}, 0);
    tree.nodes = std::move(part.nodes);
    tree.leaf_begin.push_back(0);
    tree.leaf_begin.insert(tree.leaf_begin.end(), part.leaf_end.begin(), part.leaf_end.end());
  }
  tree.leaves.resize(tree.leaf_begin.size() - 1);
  tree.order.resize(count);
  tree.corners.resize(9 * count);
  parallel_blocks(tree.leaves.size(), sum_block, [&](std::size_t begin, std::size_t end) {
    for (std::size_t leaf = begin; leaf < end; ++leaf) {
      tree.leaves[leaf] = {};
      for (std::size_t p = tree.leaf_begin[leaf]; p < tree.leaf_begin[leaf + 1]; ++p) {
        const std::uint32_t t = items[p].triangle;
        tree.order[p] = t;
        for (std::size_t k = 0; k < 3; ++k) {
          const std::uint32_t v = triangles[3 * std::size_t{t} + k];
          double* const at = tree.corners.data() + 9 * p + 3 * k;
          at[0] = x[v];
          at[1] = y[v];
          at[2] = z[v];
        }
        set_bounds(tree.leaves[leaf], p - tree.leaf_begin[leaf], tree.corner(p, 0), tree.corner(p, 1),
                   tree.corner(p, 2));
      }
    }
  });
  return tree;
}

}  // namespace meander
