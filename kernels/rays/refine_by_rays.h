// The loop that both Embree locators share: cast through the new leaves of a tree, split, go one level down.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "kernels/core/parallel.h"
#include "kernels/curve/curve_frames.h"
#include "kernels/curve/curve_tree.h"
#include "kernels/rays/chart_scene.h"

namespace meander {

inline constexpr std::size_t rays_at_once = 65536;
inline constexpr std::uint64_t any_number_of_leaves = std::uint64_t{1} << 62;

// In levels of the tree's kind.
struct DepthRange {
  int least = 0, most = 0;
};

// Leaves above depth.least are split without a ray. One ray is cast through every other leaf, at the point
// point_of(nodes, i), a pair of doubles; `visit(nodes, i, u, v, hits, may_split)` is called for the rays of
// each level in curve order, in the calling thread, with the float32 point that was cast, and returns true to
// split the leaf (if it may be). A leaf that it does not split is final. Once there are most_leaves leaves,
// none is split. Returns the number of rays.
template <class PointOf, class Visit>
std::uint64_t refine_by_rays(CurveTree& tree, const ChartScene& scene, DepthRange depths,
                             std::uint64_t most_leaves, const CancelToken& cancel, const PointOf& point_of,
                             const Visit& visit) {
  std::uint64_t rays = 0, all_leaves = tree.leaf_count();
  const auto branching = static_cast<std::uint64_t>(frame_table(tree.kind).branching);
  const std::uint64_t more_by_split = branching * branching - 1;
  std::vector<CurveLevel> levels;
  levels.push_back({std::move(tree), {}});
  RayHits hits;
  std::vector<float> u, v;
  std::vector<std::uint32_t> leaves;
  for (bool grown = true; grown;) {
    cancel.check();
    CurveLevel& level = levels.back();
    const CurveTree& nodes = level.nodes;
    level.split.assign(nodes.leaf_count(), 1);
    leaves.clear();
    for (std::uint32_t i = 0; i < nodes.leaf_count(); ++i)
      if (nodes.depth[i] >= depths.least) leaves.push_back(i);
    all_leaves += more_by_split * (nodes.leaf_count() - leaves.size());
    rays += leaves.size();
    // Not all at once: a level may have millions of leaves, and a ray most_hits_per_ray hits.
    for (std::size_t first = 0; first < leaves.size(); first += rays_at_once) {
      const std::size_t count = std::min(rays_at_once, leaves.size() - first);
      u.resize(count);
      v.resize(count);
      parallel_blocks(count, 4096, [&](std::size_t begin, std::size_t end) {
        for (std::size_t r = begin; r < end; ++r) {
          const std::pair<double, double> point = point_of(nodes, leaves[first + r]);
          u[r] = static_cast<float>(point.first);
          v[r] = static_cast<float>(point.second);
        }
      });
      scene.cast(u, v, hits, cancel);
      for (std::size_t r = 0; r < count; ++r) {
        const std::size_t i = leaves[first + r];
        const bool may_split = nodes.depth[i] < depths.most && all_leaves + more_by_split <= most_leaves;
        level.split[i] = visit(nodes, i, u[r], v[r], hits.of(r), may_split) && may_split;
        if (level.split[i] != 0) all_leaves += more_by_split;
      }
    }
    CurveTree children = children_of(nodes, level.split);
    grown = children.leaf_count() > 0;
    if (grown) levels.push_back({std::move(children), {}});
  }
  tree = join_levels(levels);
  return rays;
}

}  // namespace meander
