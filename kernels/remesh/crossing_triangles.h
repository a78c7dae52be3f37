// Triangles in space that run through each other.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "kernels/core/parallel.h"
#include "kernels/core/vector3.h"
#include "kernels/mesh/bounds_tree.h"

namespace meander {

using TriangleCorners = std::array<Vector3, 3>;
using TriangleVertices = std::array<std::uint32_t, 3>;

// Whether an edge of one passes through the inside of the other: signs of volumes in double, so that
// triangles that touch, or lie in one plane, may count or not.
bool triangles_cross(const TriangleCorners& a, const TriangleCorners& b);

inline bool share_a_vertex(const TriangleVertices& a, const TriangleVertices& b) {
  for (const std::uint32_t v : a)
    if (v == b[0] || v == b[1] || v == b[2]) return true;
  return false;
}

// The same of triangles that may have vertices in common: those with one cross where the edge of one opposite
// to it passes through the other, those with an edge in common where they are folded onto each other.
bool triangles_overlap(const TriangleVertices& a, const TriangleCorners& at_a, const TriangleVertices& b,
                       const TriangleCorners& at_b);

// An axis-parallel box.
struct SpaceBox {
  std::array<double, 3> low, high;
  bool meets(const SpaceBox& other) const {
    for (std::size_t k = 0; k < 3; ++k)
      if (low[k] > other.high[k] || other.low[k] > high[k]) return false;
    return true;
  }
};
SpaceBox box_of(const TriangleCorners& triangle);
// What both have; only of boxes that meet.
SpaceBox common_box(const SpaceBox& a, const SpaceBox& b);

// Boxes to ask for those near another one. 48 bytes an item and a tree over them.
class BoxSearch {
 public:
  BoxSearch() = default;
  // box(i): finite, of the items 0 .. count - 1. O(n log n), deterministic.
  template <class Box>
  BoxSearch(std::size_t count, const Box& box) : low_(3 * count), high_(3 * count) {
    parallel_blocks(count, sum_block, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        const SpaceBox b = box(i);
        std::copy(b.low.begin(), b.low.end(), low_.begin() + static_cast<std::ptrdiff_t>(3 * i));
        std::copy(b.high.begin(), b.high.end(), high_.begin() + static_cast<std::ptrdiff_t>(3 * i));
      }
    });
    tree_ = build_bounds_tree(low_, high_);
  }

  // Calls visit(item) for the items whose boxes meet this one, in an order of their own.
  template <class Visit>
  void visit_meeting(const SpaceBox& box, const Visit& visit) const {
    visit_meeting_while(box, [&](std::uint32_t item) {
      visit(item);
      return true;
    });
  }
  // The same until visit(item) returns false.
  template <class Visit>
  void visit_meeting_while(const SpaceBox& box, const Visit& visit) const {
    visit_near(tree_, box.low.data(), box.high.data(),
               [&](std::uint32_t item) { return !meets(item, box) || visit(item); });
  }
  bool meets_any(const SpaceBox& box) const {
    return !visit_near(tree_, box.low.data(), box.high.data(),
                       [&](std::uint32_t item) { return !meets(item, box); });
  }

 private:
  bool meets(std::uint32_t item, const SpaceBox& box) const {
    const double* low = low_.data() + 3 * std::size_t{item};
    const double* high = high_.data() + 3 * std::size_t{item};
    return low[0] <= box.high[0] && box.low[0] <= high[0] && low[1] <= box.high[1] && box.low[1] <= high[1] &&
           low[2] <= box.high[2] && box.low[2] <= high[2];
  }

  std::vector<double> low_, high_;
  BoundsTree tree_;
};

struct TrianglePair {
  std::uint32_t first, second;  // first < second
};

// Pairs of items, ascending by their first one, and of each first one at most `most`; with how many there are
// in all.
struct CrossingPairs {
  std::vector<TrianglePair> pairs;
  std::uint64_t count = 0;
  bool is_whole = true;  // false: the search ended at its bound, there may be more
};

// Bounds on a search, counted in pairs of boxes that meet. Triangles of a surface have some dozens of
// neighbors; those of a fan of long needles all have a common corner of their boxes.
struct CrossingSearchBound {
  std::uint64_t of_block = std::numeric_limits<std::uint64_t>::max();  // of 256 items
  std::uint64_t in_all = std::numeric_limits<std::uint64_t>::max();    // about: at most 16 blocks more
};
// Those of the items 0 .. count - 1 whose boxes meet and for which cross(t, u) says so. Calls check() now and
// then. O(n log n + pairs of boxes that meet), parallel in fixed blocks; deterministic.
template <class Box, class Cross, class Check>
CrossingPairs crossing_pairs(const BoxSearch& boxes, std::size_t count, std::size_t most,
                             const CrossingSearchBound& bound, const Box& box, const Cross& cross,
                             const Check& check) {
  constexpr std::size_t block = 256;
  constexpr std::uint64_t between_checks = 1 << 14;
  const std::size_t blocks = (count + block - 1) / block;
  // With a bound it is asked after every few blocks, whichever threads have searched them.
  const std::size_t blocks_at_once = bound.in_all == CrossingSearchBound().in_all ? blocks : 16;
  std::vector<CrossingPairs> found(blocks);
  std::vector<std::uint64_t> visits(blocks, 0);
  const auto search = [&](std::size_t b) {
    check();
    CrossingPairs& here = found[b];
    std::vector<std::uint32_t> others;
    for (std::size_t t = b * block; t < std::min(count, (b + 1) * block) && here.is_whole; ++t) {
      others.clear();
      boxes.visit_meeting_while(box(t), [&](std::uint32_t u) {
        if (++visits[b] % between_checks == 0) check();
        if (u > t && cross(t, u)) others.push_back(u);
        return here.is_whole = visits[b] < bound.of_block;
      });
      here.count += others.size();
      std::sort(others.begin(), others.end());
      if (others.size() > most) others.resize(most);
      for (const std::uint32_t u : others) here.pairs.push_back({static_cast<std::uint32_t>(t), u});
    }
  };
  CrossingPairs all;
  std::uint64_t visited = 0;
  for (std::size_t begin = 0; begin < blocks && all.is_whole; begin += blocks_at_once) {
    const std::size_t end = std::min(blocks, begin + blocks_at_once);
    parallel_tasks(end - begin, [&](std::size_t i) { search(begin + i); });
    for (std::size_t b = begin; b < end; ++b) {
      all.is_whole = all.is_whole && found[b].is_whole;
      all.count += found[b].count;
      all.pairs.insert(all.pairs.end(), found[b].pairs.begin(), found[b].pairs.end());
      visited += visits[b];
    }
    all.is_whole = all.is_whole && (visited < bound.in_all || end == blocks);
  }
  return all;
}

}  // namespace meander
