#include "kernels/query/segment_crossings.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "kernels/query/lanes.h"

namespace meander {

namespace {

using lanes::Floats;

double largest_of(Vector3 v) { return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)}); }

// The sign of det(u, v, w), vectors being differences that were rounded once; 0 where it is not certain.
int volume_sign(Vector3 u, Vector3 v, Vector3 w) {
  const double volume = dot(u, cross(v, w));
  const double error = 1e-14 * largest_of(u) * largest_of(v) * largest_of(w);
  return volume > error ? 1 : volume < -error ? -1 : 0;
}

// 1: along the normal, -1: against it, 0: none; nothing is sure where `sure` becomes false.
int crossing(const TriangleTree& tree, std::size_t position, Vector3 a, Vector3 b, bool& sure) {
  const Vector3 p = tree.corner(position, 0) - a, q = tree.corner(position, 1) - a,
                r = tree.corner(position, 2) - a, along = b - a;
  // The edges seen along the segment.
  const int first = volume_sign(along, p, q), second = volume_sign(along, q, r),
            third = volume_sign(along, r, p);
  const bool plus = first > 0 || second > 0 || third > 0, minus = first < 0 || second < 0 || third < 0;
  if (plus && minus) return 0;
  const int behind = volume_sign(p, q, r), before = volume_sign(p - along, q - along, r - along);
  if (behind * before > 0) return 0;
  if (behind * before < 0 && first != 0 && second != 0 && third != 0) return behind;
  // Uncertain, unless it lies aside altogether.
  for (const auto axis : {&Vector3::x, &Vector3::y, &Vector3::z}) {
    const double low = std::min({p.*axis, q.*axis, r.*axis}), high = std::max({p.*axis, q.*axis, r.*axis});
    if (low > std::max(0.0, along.*axis) + 1e-12 || high < std::min(0.0, along.*axis) - 1e-12) return 0;
  }
  sure = false;
  return 0;
}

template <bool all>
SegmentCrossings find_crossings(const TriangleTree& tree, std::span<const std::uint8_t> flipped, Vector3 a,
                                Vector3 b) {
  const double extent = std::max(largest_of(a), largest_of(b));
  const auto slack = static_cast<float>(float_slack(extent));
  const float from[3] = {static_cast<float>(a.x), static_cast<float>(a.y), static_cast<float>(a.z)};
  const float to[3] = {static_cast<float>(b.x), static_cast<float>(b.y), static_cast<float>(b.z)};
  float low[3], high[3];
  for (std::size_t k = 0; k < 3; ++k) {
    low[k] = std::min(from[k], to[k]) - slack;
    high[k] = std::max(from[k], to[k]) + slack;
  }
  SegmentCrossings result{0, 0, true};
  std::uint32_t stack[TriangleTree::max_waiting];
  std::size_t waiting = 0;
  std::uint32_t at = 0;
  for (;;) {
    if ((at & TriangleTree::leaf_bit) == 0) {
      const TriangleTree::Node& node = tree.nodes[at];
      const auto meets = (lanes::load<Floats>(node.low[0].data()) <= high[0]) &
                         (lanes::load<Floats>(node.high[0].data()) >= low[0]) &
                         (lanes::load<Floats>(node.low[1].data()) <= high[1]) &
                         (lanes::load<Floats>(node.high[1].data()) >= low[1]) &
                         (lanes::load<Floats>(node.low[2].data()) <= high[2]) &
                         (lanes::load<Floats>(node.high[2].data()) >= low[2]);
      for (unsigned bits = lanes::bits_of(meets); bits != 0; bits &= bits - 1)
        stack[waiting++] = node.child[static_cast<std::size_t>(std::countr_zero(bits))];
    } else {
      const std::size_t leaf = at & ~TriangleTree::leaf_bit;
      const TriangleTree::Leaf& bounds = tree.leaves[leaf];
      const std::size_t begin = tree.leaf_begin[leaf], count = tree.leaf_begin[leaf + 1] - begin;
      unsigned aside = 0;
#pragma GCC unroll 4
      for (std::size_t p = 0; p < 4; ++p) {
        const auto& plane = bounds.plane[p];
        const Floats nx = lanes::load<Floats>(plane[0].data()), ny = lanes::load<Floats>(plane[1].data()),
                     nz = lanes::load<Floats>(plane[2].data()), offset = lanes::load<Floats>(plane[3].data());
        const Floats start = nx * from[0] + ny * from[1] + nz * from[2] - offset,
                     end = nx * to[0] + ny * to[1] + nz * to[2] - offset;
        aside |= lanes::bits_of((start > slack) & (end > slack));
        if (p == 0) aside |= lanes::bits_of((start < -slack) & (end < -slack));
      }
      unsigned near = ~aside & ((1u << count) - 1);
      for (; near != 0; near &= near - 1) {
        const std::size_t position = begin + static_cast<std::size_t>(std::countr_zero(near));
        const int outward = crossing(tree, position, a, b, result.sure);
        if (!result.sure) return result;
        const bool turned = !flipped.empty() && flipped[tree.order[position]] != 0;
        result.outward += turned ? -outward : outward;
        result.count += outward != 0;
        if (!all && result.count > 0) return result;
      }
    }
    if (waiting == 0) return result;
    at = stack[--waiting];
  }
}

}  // namespace

SegmentCrossings segment_crossings(const TriangleTree& tree, std::span<const std::uint8_t> flipped, Vector3 a,
                                   Vector3 b) {
  return find_crossings<true>(tree, flipped, a, b);
}

bool is_free_segment(const TriangleTree& tree, Vector3 a, Vector3 b, std::span<const std::uint32_t> likely) {
  for (const std::uint32_t position : likely) {
    bool sure = true;
    if (crossing(tree, position, a, b, sure) != 0 || !sure) return false;
  }
  const SegmentCrossings found = find_crossings<false>(tree, {}, a, b);
  return found.sure && found.count == 0;
}

}  // namespace meander
