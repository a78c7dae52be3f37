// Cuts that join singularities (declared in singularities.h).
#include <algorithm>
#include <cmath>
#include <utility>

#include "kernels/core/disjoint_sets.h"
#include "kernels/core/parallel.h"
#include "kernels/core/radix_heap.h"
#include "kernels/mesh/vertex_corners.h"
#include "kernels/tensor/deviator.h"
#include "kernels/tensor/singularities.h"
#include "kernels/tensor/tensor_blocks.h"

namespace meander {

namespace {

// The cost of each half-edge: |e| (1 + c sin^2 a), the mean over both sides with area. Boundary half-edges
// are not used.
std::vector<double> edge_costs(const PreparedMesh& mesh, const TensorField& field, double bend) {
  std::vector<double> share(mesh.triangles.size(), -1.0);
  parallel_blocks(mesh.triangle_count(), tensor_block, [&](std::size_t begin, std::size_t end) {
    for (std::size_t h = 3 * begin; h < 3 * end; ++h) {
      const auto t = static_cast<std::uint32_t>(h / 3);
      if (!(mesh.area[t] > 0)) continue;
      const std::uint32_t next = next_half_edge(static_cast<std::uint32_t>(h));
      const TangentFrame frame = triangle_frame(mesh, t);
      const Vector3 e = mesh.position(mesh.triangles[next]) - mesh.position(mesh.triangles[h]);
      const double x = dot(e, frame.x), y = dot(e, frame.y), squared = x * x + y * y;
      const Deviator d = deviator(field.corner[h] + field.corner[next]);
      const double size = squared * length(d);
      const double cosine = size > 0 ? (d.x * (x * x - y * y) + d.y * 2 * x * y) / size : 0;
      share[h] = 0.5 * (1 - std::clamp(cosine, -1.0, 1.0));  // sin^2
    }
  });
  std::vector<double> cost(share.size());
  for (std::uint32_t h = 0; h < cost.size(); ++h) {
    const double here = share[h], there = mesh.opposite[h] == no_index ? -1 : share[mesh.opposite[h]];
    const double mean = here < 0 && there < 0 ? 0.5
                        : here < 0            ? there
                        : there < 0           ? here
                                              : 0.5 * (here + there);
    cost[h] = distance(mesh.position(mesh.triangles[h]), mesh.position(mesh.triangles[next_half_edge(h)])) *
              (1 + bend * mean);
  }
  return cost;
}

// Boruvka's spanning forest between groups of vertices along shortest paths (Mehlhorn 1988), as long as
// groups are open.
class GroupJoiner {
 public:
  GroupJoiner(const PreparedMesh& mesh, std::vector<double> cost, std::span<const Singularity> singularities)
      : mesh_(mesh),
        around_(mesh),
        cost_(std::move(cost)),
        groups_(mesh.vertex_count() + 1),
        owner_(mesh.vertex_count(), no_index),
        half_turns_(mesh.vertex_count() + 1, 0),
        joined_(mesh.vertex_count() + 1, 0),
        cut_(mesh.triangles.size(), 0),
        distance_(mesh.vertex_count()),
        arrival_(mesh.vertex_count()),
        reached_by_(mesh.vertex_count()) {
    // A group is named by the smallest of its singular vertices plus 1; group 0 is the boundary.
    for (std::uint32_t h = 0; h < mesh.opposite.size(); ++h)
      if (mesh.opposite[h] == no_index)
        for (const std::uint32_t end : {h, next_half_edge(h)}) {
          owner_[mesh.triangles[end]] = 0;
          groups_.join(0, mesh.triangles[end] + 1);
        }
    for (const Singularity& s : singularities) {
      owner_[s.vertex] = groups_.find(s.vertex + 1);
      half_turns_[groups_.find(s.vertex + 1)] += s.half_turns;
      sites_.push_back(s.vertex + 1);
    }
    std::sort(sites_.begin(), sites_.end());
    sites_.erase(std::unique(sites_.begin(), sites_.end()), sites_.end());
  }

  std::vector<std::uint32_t> run(const CancelToken& cancel) {
    while (round(cancel)) {
    }
    std::vector<std::uint32_t> result;
    for (std::uint32_t h = 0; h < cut_.size(); ++h)
      if (cut_[h]) result.push_back(h);
    return result;
  }

 private:
  bool open(std::uint32_t group) const {
    return group != 0 && (!joined_[group] || half_turns_[group] % 2 != 0);
  }

  bool round(const CancelToken& cancel) {
    if (std::none_of(sites_.begin(), sites_.end(), [&](std::uint32_t s) { return open(groups_.find(s)); }))
      return false;
    flood(cancel);
    struct Bridge {
      double cost = 0;
      std::uint32_t half_edge = no_index;
    };
    std::vector<Bridge> best(mesh_.vertex_count() + 1);
    for (std::uint32_t h = 0; h < mesh_.opposite.size(); ++h) {
      if (mesh_.opposite[h] == no_index || mesh_.opposite[h] < h) continue;
      const std::uint32_t a = mesh_.triangles[h], b = mesh_.triangles[next_half_edge(h)];
      if (reached_by_[a] == no_index || reached_by_[b] == no_index || reached_by_[a] == reached_by_[b])
        continue;
      const double cost = distance_[a] + cost_[h] + distance_[b];
      for (const std::uint32_t group : {reached_by_[a], reached_by_[b]})
        if (best[group].half_edge == no_index || cost < best[group].cost) best[group] = {cost, h};
    }
    bool any = false;
    for (const std::uint32_t site : sites_) {
      // Before this round's joins, groups still have the names that the flood gave them.
      const std::uint32_t group = reached_by_[site - 1], h = best[group].half_edge;
      if (!was_open_[group] || h == no_index) continue;
      const std::uint32_t a = mesh_.triangles[h], b = mesh_.triangles[next_half_edge(h)];
      const std::uint32_t first = groups_.find(reached_by_[a]), second = groups_.find(reached_by_[b]);
      if (first == second) continue;
      add(h);
      for (std::uint32_t v : {a, b})
        for (const std::uint32_t group_of = reached_by_[v]; arrival_[v] != no_index;
             v = mesh_.triangles[arrival_[v]]) {
          add(arrival_[v]);
          take(v, group_of);
        }
      const std::int32_t sum = half_turns_[first] + half_turns_[second];
      groups_.join(first, second);
      const std::uint32_t both = std::min(first, second);
      half_turns_[both] = sum;
      joined_[both] = 1;
      any = true;
    }
    return any;
  }

  void add(std::uint32_t h) { cut_[std::min(h, mesh_.opposite[h])] = 1; }
  void take(std::uint32_t v, std::uint32_t group) {
    if (owner_[v] == no_index) owner_[v] = group;
  }

  void flood(const CancelToken& cancel) {
    RadixHeap heap;
    std::fill(reached_by_.begin(), reached_by_.end(), no_index);
    std::fill(arrival_.begin(), arrival_.end(), no_index);
    std::fill(distance_.begin(), distance_.end(), 1e300);
    was_open_.assign(mesh_.vertex_count() + 1, 0);
    for (const std::uint32_t site : sites_) was_open_[groups_.find(site)] = open(groups_.find(site));
    for (std::uint32_t v = 0; v < owner_.size(); ++v) {
      if (owner_[v] == no_index) continue;
      distance_[v] = 0;
      reached_by_[v] = groups_.find(owner_[v]);
      heap.push(0, v);
    }
    std::size_t steps = 0;
    while (!heap.empty()) {
      const RadixHeap::Entry entry = heap.pop();
      if (entry.key > distance_[entry.value]) continue;
      if ((++steps & 0xFFFF) == 0) cancel.check();
      for (const std::uint32_t h : around_.of(entry.value)) {
        if (mesh_.opposite[h] == no_index) continue;
        const std::uint32_t other = mesh_.triangles[next_half_edge(h)];
        const double distance = entry.key + cost_[h];
        if (!(distance < distance_[other])) continue;
        distance_[other] = distance;
        arrival_[other] = h;
        reached_by_[other] = reached_by_[entry.value];
        heap.push(distance, other);
      }
    }
  }

  const PreparedMesh& mesh_;
  VertexCorners around_;
  std::vector<double> cost_;
  DisjointSets groups_;
  std::vector<std::uint32_t> owner_;      // V: a name of the vertex's group, no_index: none
  std::vector<std::int32_t> half_turns_;  // by group
  std::vector<std::uint8_t> joined_, cut_, was_open_;
  std::vector<double> distance_;
  std::vector<std::uint32_t> arrival_, reached_by_;
  std::vector<std::uint32_t> sites_;  // names of the groups that singularities started
};

}  // namespace

std::vector<std::uint32_t> connect_singularities(const PreparedMesh& mesh, const TensorField& field,
                                                 std::span<const Singularity> singularities,
                                                 const SingularityCutParameters& parameters,
                                                 const CancelToken& cancel) {
  if (singularities.empty()) return {};
  GroupJoiner joiner(mesh, edge_costs(mesh, field, parameters.bend), singularities);
  cancel.check();
  return joiner.run(cancel);
}

}  // namespace meander
