#include "kernels/mesh/clip_ears.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <utility>

namespace meander {

namespace {

constexpr std::uint32_t none = ~0u;

struct PlaneTriangle {
  PlanePoint a, b, c;
  bool holds(PlanePoint q) const { return turn(a, b, q) >= 0 && turn(b, c, q) >= 0 && turn(c, a, q) >= 0; }
};

struct PlaneBox {
  PlanePoint low{INFINITY, INFINITY}, high{-INFINITY, -INFINITY};
  void hold(PlanePoint q) {
    low = {std::min(low.x, q.x), std::min(low.y, q.y)};
    high = {std::max(high.x, q.x), std::max(high.y, q.y)};
  }
  // Whether a point of the box may lie on the left of an edge. Rounding is monotone, so no point of the box
  // has a larger turn than the corner that is farthest to the left.
  bool reaches_left_of(PlanePoint a, PlanePoint b) const {
    return turn(a, b, {b.y - a.y > 0 ? low.x : high.x, b.x - a.x > 0 ? high.y : low.y}) >= 0;
  }
  bool may_meet(const PlaneTriangle& t) const {
    return reaches_left_of(t.a, t.b) && reaches_left_of(t.b, t.c) && reaches_left_of(t.c, t.a);
  }
};

// The corners of a polygon in a balanced tree of boxes, whose nodes count their held corners.
class CornerTree {
 public:
  explicit CornerTree(std::span<const PlanePoint> points)
      : points_(points), order_(points.size()), leaf_(points.size()) {
    while (leaves_ * corners_per_leaf < points.size()) leaves_ *= 2;
    box_.resize(2 * leaves_);
    held_.resize(2 * leaves_);
    std::iota(order_.begin(), order_.end(), 0u);
    build(1, 0, order_.size());
  }

  void hold(std::uint32_t corner) { count(corner, 1); }
  void drop(std::uint32_t corner) { count(corner, -1); }

  // Finds a corner for which is_blocking(corner), or none. It is asked of held corners in leaves near the
  // triangle only.
  template <class IsBlocking>
  std::uint32_t find(const PlaneTriangle& triangle, const IsBlocking& is_blocking) const {
    // Enough for one node a level, and two.
    std::array<std::size_t, 2 * std::numeric_limits<std::size_t>::digits> waiting;
    std::size_t count = 0;
    waiting[count++] = 1;
    while (count > 0) {
      const std::size_t node = waiting[--count];
      if (held_[node] == 0 || !box_[node].may_meet(triangle)) continue;
      if (node < leaves_) {
        waiting[count++] = 2 * node + 1;
        waiting[count++] = 2 * node;
        continue;
      }
      const auto [begin, end] = range_of(node);
      for (std::size_t i = begin; i < end; ++i)
        if (is_blocking(order_[i])) return order_[i];
    }
    return none;
  }

 private:
  static constexpr std::size_t corners_per_leaf = 8;

  std::pair<std::size_t, std::size_t> range_of(std::size_t leaf) const {
    const std::size_t i = leaf - leaves_;
    return {i * order_.size() / leaves_, (i + 1) * order_.size() / leaves_};
  }

  // Builds the node over the corners from `first` to `last`.
  void build(std::size_t node, std::size_t first, std::size_t last) {
    if (node >= leaves_) {
      for (std::size_t i = first; i < last; ++i) {
        box_[node].hold(points_[order_[i]]);
        leaf_[order_[i]] = static_cast<std::uint32_t>(node);
      }
      return;
    }
    PlaneBox box;
    for (std::size_t i = first; i < last; ++i) box.hold(points_[order_[i]]);
    std::size_t first_high = 2 * node + 1;
    while (first_high < leaves_) first_high *= 2;
    const std::size_t middle = range_of(first_high).first;
    const bool is_wide = box.high.x - box.low.x > box.high.y - box.low.y;
    const auto at = [&](std::size_t i) { return order_.begin() + static_cast<std::ptrdiff_t>(i); };
    std::nth_element(at(first), at(middle), at(last), [&](std::uint32_t a, std::uint32_t b) {
      const double p = is_wide ? points_[a].x : points_[a].y, q = is_wide ? points_[b].x : points_[b].y;
      return p != q ? p < q : a < b;
    });
    build(2 * node, first, middle);
    build(2 * node + 1, middle, last);
    box_[node] = box;
  }

  void count(std::uint32_t corner, int step) {
    for (std::size_t node = leaf_[corner]; node > 0; node /= 2)
      held_[node] += static_cast<std::uint32_t>(step);
  }

  std::span<const PlanePoint> points_;
  std::vector<std::uint32_t> order_, leaf_;
  std::size_t leaves_ = 1;  // node i has the halves 2 i and 2 i + 1; the leaves come last
  std::vector<PlaneBox> box_;
  std::vector<std::uint32_t> held_;
};

// A set of numbers below a bound: words with a bit a number, and above them words with a bit for each word.
class NumberSet {
 public:
  explicit NumberSet(std::size_t bound) {
    do {
      bound = (bound + 63) / 64;
      level_.emplace_back(bound);
    } while (bound > 1);
  }
  void insert(std::size_t number) {
    for (std::vector<std::uint64_t>& words : level_) {
      words[number / 64] |= std::uint64_t{1} << number % 64;
      number /= 64;
    }
  }
  void erase(std::size_t number) {
    for (std::vector<std::uint64_t>& words : level_) {
      words[number / 64] &= ~(std::uint64_t{1} << number % 64);
      if (words[number / 64] != 0) return;
      number /= 64;
    }
  }
  // The smallest member that is at least `number`, or none.
  std::uint32_t next(std::size_t number) const {
    for (std::size_t k = 0; k < level_.size() && number / 64 < level_[k].size(); ++k) {
      const std::uint64_t word = level_[k][number / 64] >> number % 64;
      if (word == 0) {
        number = number / 64 + 1;
        continue;
      }
      number += static_cast<std::size_t>(std::countr_zero(word));
      while (k > 0) number = 64 * number + static_cast<std::size_t>(std::countr_zero(level_[--k][number]));
      return static_cast<std::uint32_t>(number);
    }
    return none;
  }

 private:
  std::vector<std::vector<std::uint64_t>> level_;
};

class EarClipper {
 public:
  explicit EarClipper(std::span<const PlanePoint> points)
      : points_(points), corner_(points.size()), candidates_(points.size()) {
    const auto count = static_cast<std::uint32_t>(points.size());
    for (std::uint32_t i = 0; i < count; ++i) {
      corner_[i].before = i > 0 ? i - 1 : count - 1;
      corner_[i].after = i + 1 < count ? i + 1 : 0;
    }
    if (count > few_corners) tree_.emplace(points);
    for (std::uint32_t i = 0; i < count; ++i) {
      candidates_.insert(i);
      if (!turns_left(i)) set_reflex(i, true);
    }
  }

  void clip(std::vector<std::uint32_t>& triangles, const CancelToken& cancel) {
    std::size_t left = points_.size();
    std::uint32_t at = 0, first = 0;
    for (std::uint32_t tests = 1; left > 3; ++tests) {
      if (tests % 256 == 0) cancel.check();
      // Corners in between that are not candidates are known not to be ears.
      std::uint32_t i = candidates_.next(at);
      if (i == none) i = candidates_.next(0);
      if (i == none) break;
      candidates_.erase(i);
      const auto [before, after] = std::pair(corner_[i].before, corner_[i].after);
      if (!is_ear(i)) {
        at = after;
        continue;
      }
      triangles.insert(triangles.end(), {before, i, after});
      remove(i);
      if (i == first) first = after;
      --left;
      at = corner_[after].after;
    }
    for (std::uint32_t i = corner_[first].after; corner_[i].after != first; i = corner_[i].after)
      triangles.insert(triangles.end(), {first, i, corner_[i].after});
  }

 private:
  // Polygons with fewer corners are searched one by one.
  static constexpr std::size_t few_corners = 32;

  // Corners are in linked lists by index. A corner that is not an ear waits for the reflex corner in its
  // triangle to go.
  struct Corner {
    std::uint32_t before, after;
    std::uint32_t first_waiting = none, next_waiting = none, previous_waiting = none, waits_for = none;
    bool is_reflex = false;
  };

  bool turns_left(std::uint32_t i) const {
    return turn(points_[corner_[i].before], points_[i], points_[corner_[i].after]) > 0;
  }

  void set_reflex(std::uint32_t i, bool reflex) {
    if (corner_[i].is_reflex == reflex) return;
    corner_[i].is_reflex = reflex;
    if (tree_) reflex ? tree_->hold(i) : tree_->drop(i);
    if (reflex) return;
    while (corner_[i].first_waiting != none) test_again(corner_[i].first_waiting);
  }

  void test_again(std::uint32_t i) {
    Corner& corner = corner_[i];
    candidates_.insert(i);
    if (corner.waits_for == none) return;
    (corner.previous_waiting == none ? corner_[corner.waits_for].first_waiting
                                     : corner_[corner.previous_waiting].next_waiting) = corner.next_waiting;
    if (corner.next_waiting != none) corner_[corner.next_waiting].previous_waiting = corner.previous_waiting;
    corner.waits_for = corner.next_waiting = corner.previous_waiting = none;
  }

  void wait(std::uint32_t i, std::uint32_t reflex) {
    const std::uint32_t next = corner_[reflex].first_waiting;
    corner_[i].waits_for = reflex;
    corner_[i].next_waiting = next;
    if (next != none) corner_[next].previous_waiting = i;
    corner_[reflex].first_waiting = i;
  }

  // An ear is a left turn whose triangle holds no other reflex corner.
  bool is_ear(std::uint32_t i) {
    if (corner_[i].is_reflex) return false;
    const PlaneTriangle triangle{points_[corner_[i].before], points_[i], points_[corner_[i].after]};
    // A bridge to a hole visits its ends twice: a copy of the ear's own corner does not block it.
    const auto is_blocking = [&](std::uint32_t j) {
      const auto same = [q = points_[j]](PlanePoint p) { return p.x == q.x && p.y == q.y; };
      return corner_[j].is_reflex && triangle.holds(points_[j]) && !same(triangle.a) && !same(triangle.b) &&
             !same(triangle.c);
    };
    std::uint32_t blocking = none;
    if (tree_) {
      blocking = tree_->find(triangle, is_blocking);
    } else {
      for (std::uint32_t j = corner_[i].after; j != i && blocking == none; j = corner_[j].after)
        if (is_blocking(j)) blocking = j;
    }
    if (blocking != none) wait(i, blocking);
    return blocking == none;
  }

  void remove(std::uint32_t i) {
    const auto [before, after] = std::pair(corner_[i].before, corner_[i].after);
    corner_[before].after = after;
    corner_[after].before = before;
    for (const std::uint32_t neighbor : {before, after}) {
      test_again(neighbor);
      set_reflex(neighbor, !turns_left(neighbor));
    }
  }

  std::span<const PlanePoint> points_;
  std::vector<Corner> corner_;
  NumberSet candidates_;
  std::optional<CornerTree> tree_;
};

}  // namespace

void clip_ears(std::span<const PlanePoint> polygon, std::vector<std::uint32_t>& triangles,
               const CancelToken& cancel) {
  EarClipper(polygon).clip(triangles, cancel);
}

}  // namespace meander
