#include "kernels/tensor/singularities.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "kernels/core/disjoint_sets.h"
#include "kernels/core/parallel.h"
#include "kernels/core/portable_angles.h"
#include "kernels/core/portable_functions.h"
#include "kernels/core/radix_heap.h"
#include "kernels/mesh/half_edges.h"
#include "kernels/mesh/vertex_corners.h"
#include "kernels/tensor/tensor_blocks.h"

namespace meander {

namespace {

constexpr double pi = std::numbers::pi;
// Deviators of log S shorter than this have no direction.
constexpr double min_deviator = 1e-12;

// The trace-free part of a tangent tensor as a vector, at twice the angle of the first principal direction.
struct Deviator {
  double x = 0, y = 0;
};
Deviator deviator(TangentTensor a) { return {0.5 * (a.xx - a.yy), a.xy}; }
double length(Deviator d) { return portable::hypot(d.x, d.y); }

double wrapped(double angle) {
  const double turns = std::round(angle / (2 * pi));
  return angle - 2 * pi * turns;
}

// The corners as angles: of the triangles, of the half-edges in the frames of their triangles, and of the
// field (doubled).
class CornerAngles {
 public:
  CornerAngles(const PreparedMesh& mesh, const TensorField& field)
      : mesh_(mesh),
        inner_(field.corner.size()),
        direction_(field.corner.size()),
        doubled_(field.corner.size()),
        known_(field.corner.size()) {
    parallel_blocks(mesh.triangle_count(), tensor_block, [&](std::size_t begin, std::size_t end) {
      for (std::size_t t = begin; t < end; ++t) measure(field, t);
    });
    fill();
  }

  // The triangle's angle at corner h.
  double inner(std::uint32_t h) const { return inner_[h]; }
  // Change of the doubled angle from corner h to the next corner of its triangle.
  double along(std::uint32_t h) const { return wrapped(doubled_[next_half_edge(h)] - doubled_[h]); }
  // The same from corner h to the corner of its vertex on the other side of half-edge h, which must exist.
  double across(std::uint32_t h) const {
    return wrapped(doubled_[next_half_edge(mesh_.opposite[h])] - carried(h, doubled_[h]));
  }

 private:
  void measure(const TensorField& field, std::size_t t) {
    std::array<Vector3, 3> p;
    for (std::size_t k = 0; k < 3; ++k) p[k] = mesh_.position(mesh_.triangles[3 * t + k]);
    for (std::size_t k = 0; k < 2; ++k) {
      const Vector3 to_next = p[k + 1] - p[k], to_last = p[(k + 2) % 3] - p[k];
      inner_[3 * t + k] = upper_angle(norm(cross(to_next, to_last)), dot(to_next, to_last));
    }
    // The third angle makes their sum exact, so that all defects sum to 2 pi chi.
    inner_[3 * t + 2] = pi - inner_[3 * t] - inner_[3 * t + 1];
    direction_[3 * t] = 0;
    direction_[3 * t + 1] = pi - inner_[3 * t + 1];
    direction_[3 * t + 2] = direction_[3 * t + 1] + pi - inner_[3 * t + 2];
    for (std::size_t h = 3 * t; h < 3 * t + 3; ++h) {
      const Deviator d = deviator(field.corner[h]);
      known_[h] = mesh_.area[t] > 0 && length(d) > min_deviator;
      doubled_[h] = known_[h] ? portable::atan2(d.y, d.x) : 0;
    }
  }

  // Unfolds a doubled angle from the triangle of h into the triangle behind h.
  double carried(std::uint32_t h, double angle) const {
    return angle - 2 * direction_[h] + 2 * direction_[mesh_.opposite[h]];
  }

  // Visits the four corners linked to corner h with the angles that they propose.
  template <class Visit>
  void neighbors(std::uint32_t h, const Visit& visit) const {
    const std::uint32_t next = next_half_edge(h), last = previous_half_edge(h);
    visit(next, doubled_[next]);
    visit(last, doubled_[last]);
    if (const std::uint32_t o = mesh_.opposite[h]; o != no_index)
      visit(next_half_edge(o), carried(o, doubled_[next_half_edge(o)]));
    if (const std::uint32_t o = mesh_.opposite[last]; o != no_index) visit(o, carried(o, doubled_[o]));
  }

  // Gives corners without a direction the mean of their neighbors, from the rim inwards.
  void fill() {
    std::vector<std::uint32_t> front, next;
    std::vector<std::uint8_t> queued(known_.size(), 0);
    const auto queue = [&](std::uint32_t corner) {
      if (known_[corner] || queued[corner]) return;
      queued[corner] = 1;
      next.push_back(corner);
    };
    for (std::uint32_t h = 0; h < known_.size(); ++h)
      if (!known_[h])
        neighbors(h, [&](std::uint32_t other, double) {
          if (known_[other]) queue(h);
        });
    std::vector<double> angle;
    while (!next.empty()) {
      front.swap(next);
      next.clear();
      angle.clear();
      for (const std::uint32_t h : front) {
        double first = 0, sum = 0, count = 0;
        neighbors(h, [&](std::uint32_t other, double proposal) {
          if (!known_[other]) return;
          if (count == 0) first = proposal;
          sum += wrapped(proposal - first);
          count += 1;
        });
        angle.push_back(wrapped(first + sum / count));
      }
      for (std::size_t i = 0; i < front.size(); ++i) {
        doubled_[front[i]] = angle[i];
        known_[front[i]] = 1;
      }
      for (const std::uint32_t h : front) neighbors(h, [&](std::uint32_t other, double) { queue(other); });
    }
  }

  const PreparedMesh& mesh_;
  std::vector<double> inner_, direction_, doubled_;
  std::vector<std::uint8_t> known_;
};

std::int32_t whole_turns(double angle) { return static_cast<std::int32_t>(std::lround(angle / (2 * pi))); }

bool is_isotropic(TangentTensor log_spacing) {
  return 2 * length(deviator(log_spacing)) < portable::log(isotropic_ratio);
}

Singularity in_triangle(const PreparedMesh& mesh, const TensorField& field, std::uint32_t t,
                        std::int32_t half_turns) {
  // The deviator is linear, so weights are the signed areas opposite to the corners.
  std::array<Deviator, 3> d;
  for (std::size_t k = 0; k < 3; ++k) d[k] = deviator(field.corner[3 * t + k]);
  Singularity result{SingularityPlace::triangle, t, half_turns, {1.0 / 3, 1.0 / 3, 1.0 / 3}, {}, 0};
  std::array<double, 3> w;
  for (std::size_t k = 0; k < 3; ++k) {
    const Deviator a = d[(k + 1) % 3], b = d[(k + 2) % 3];
    w[k] = a.x * b.y - a.y * b.x;
  }
  const double sum = w[0] + w[1] + w[2];
  const bool inside = std::abs(sum) > 1e-300 && w[0] / sum >= 0 && w[1] / sum >= 0 && w[2] / sum >= 0;
  for (std::size_t k = 0; k < 3; ++k) {
    if (inside) result.weights[k] = w[k] / sum;
    result.position = result.position + result.weights[k] * mesh.position(mesh.triangles[3 * t + k]);
  }
  const auto nearest = std::max_element(result.weights.begin(), result.weights.end());
  result.vertex = mesh.triangles[3 * t + static_cast<std::size_t>(nearest - result.weights.begin())];
  return result;
}

// Gathers the singularities in and around each isotropic region (vertices with isotropic corners only) to one
// with their sum, where the field around has a direction.
void gather_isotropic(const PreparedMesh& mesh, const TensorField& field, std::vector<Singularity>& list) {
  const std::vector<std::uint8_t> boundary =
      boundary_vertices(mesh.triangles, mesh.opposite, mesh.vertex_count());
  std::vector<std::uint8_t> isotropic(mesh.vertex_count(), 1);
  for (std::uint32_t h = 0; h < mesh.triangles.size(); ++h)
    if (mesh.area[h / 3] > 0 && !is_isotropic(field.corner[h])) isotropic[mesh.triangles[h]] = 0;
  DisjointSets regions(mesh.vertex_count());
  for (std::uint32_t h = 0; h < mesh.triangles.size(); ++h) {
    const std::uint32_t a = mesh.triangles[h], b = mesh.triangles[next_half_edge(h)];
    if (isotropic[a] && isotropic[b]) regions.join(a, b);
  }
  struct Region {
    Vector3 sum;
    double count = 0;
    std::int32_t half_turns = 0;
    bool open = false;  // reaches the boundary: its turns are unknown
    double nearest = 0;
    std::size_t best = SIZE_MAX;
  };
  std::vector<Region> region(mesh.vertex_count());
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
    if (!isotropic[v]) continue;
    Region& of = region[regions.find(v)];
    of.sum = of.sum + mesh.position(v);
    of.count += 1;
    of.open = of.open || boundary[v];
  }
  for (const Component& component : mesh.components) {
    const std::uint32_t first = component.vertex_begin;
    if (isotropic[first] && region[regions.find(first)].count == component.vertex_end - first)
      region[regions.find(first)].open = true;  // the whole component: no direction anywhere
  }
  const auto region_of = [&](const Singularity& s) -> std::uint32_t {
    std::array<std::uint32_t, 3> v{s.element, s.element, s.element};
    if (s.place == SingularityPlace::triangle)
      for (std::size_t k = 0; k < 3; ++k) v[k] = mesh.triangles[3 * s.element + k];
    if (s.place == SingularityPlace::edge)
      v = {mesh.triangles[s.element], mesh.triangles[next_half_edge(s.element)], mesh.triangles[s.element]};
    // Isotropic vertices of one cell are neighbors, in one region.
    for (const std::uint32_t vertex : v)
      if (isotropic[vertex]) return regions.find(vertex);
    return no_index;
  };
  for (std::size_t i = 0; i < list.size(); ++i) {
    const std::uint32_t r = region_of(list[i]);
    if (r == no_index) continue;
    Region& of = region[r];
    of.half_turns += list[i].half_turns;
    const double away = distance(list[i].position, (1 / of.count) * of.sum);
    if (of.best != SIZE_MAX && !(away < of.nearest)) continue;
    of.nearest = away;
    of.best = i;
  }
  std::size_t kept = 0;
  for (std::size_t i = 0; i < list.size(); ++i) {
    if (const std::uint32_t r = region_of(list[i]); r != no_index) {
      if (region[r].open || region[r].best != i || region[r].half_turns == 0) continue;
      list[i].half_turns = region[r].half_turns;
    }
    list[kept++] = list[i];
  }
  list.resize(kept);
}

}  // namespace

TensorIndices tensor_indices(const PreparedMesh& mesh, const TensorField& field, const CancelToken& cancel) {
  const CornerAngles angles(mesh, field);
  cancel.check();
  TensorIndices result;
  result.triangle.assign(mesh.triangle_count(), 0);
  result.edge.assign(mesh.triangles.size(), 0);
  result.vertex.assign(mesh.vertex_count(), 0);
  std::vector<double> along(mesh.triangles.size()), across(mesh.triangles.size(), 0.0);
  parallel_blocks(along.size(), tensor_block, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const auto h = static_cast<std::uint32_t>(i);
      along[i] = angles.along(h);
      if (mesh.opposite[i] != no_index) across[i] = angles.across(h);
    }
  });
  for (std::size_t t = 0; t < result.triangle.size(); ++t)
    result.triangle[t] = whole_turns(along[3 * t] + along[3 * t + 1] + along[3 * t + 2]);
  std::vector<double> turn(mesh.vertex_count(), 4 * pi);  // twice the defect, less the links
  for (std::uint32_t h = 0; h < along.size(); ++h) {
    const std::uint32_t o = mesh.opposite[h];
    turn[mesh.triangles[h]] -= 2 * angles.inner(h) + across[h];
    if (o != no_index && h < o) result.edge[h] = whole_turns(across[h] + across[o] - along[h] - along[o]);
  }
  const std::vector<std::uint8_t> boundary =
      boundary_vertices(mesh.triangles, mesh.opposite, mesh.vertex_count());
  for (std::size_t v = 0; v < turn.size(); ++v)
    if (!boundary[v]) result.vertex[v] = whole_turns(turn[v]);
  return result;
}

std::vector<Singularity> find_singularities(const PreparedMesh& mesh, const TensorField& field,
                                            bool drop_isotropic, const CancelToken& cancel) {
  const TensorIndices indices = tensor_indices(mesh, field, cancel);
  std::vector<Singularity> result;
  for (std::uint32_t t = 0; t < indices.triangle.size(); ++t)
    if (indices.triangle[t] != 0) result.push_back(in_triangle(mesh, field, t, indices.triangle[t]));
  for (std::uint32_t h = 0; h < indices.edge.size(); ++h) {
    if (indices.edge[h] == 0) continue;
    const std::uint32_t a = mesh.triangles[h], b = mesh.triangles[next_half_edge(h)];
    result.push_back({SingularityPlace::edge,
                      h,
                      indices.edge[h],
                      {},
                      0.5 * (mesh.position(a) + mesh.position(b)),
                      std::min(a, b)});
  }
  for (std::uint32_t v = 0; v < indices.vertex.size(); ++v)
    if (indices.vertex[v] != 0)
      result.push_back({SingularityPlace::vertex, v, indices.vertex[v], {}, mesh.position(v), v});
  cancel.check();
  if (drop_isotropic) gather_isotropic(mesh, field, result);
  return result;
}

TensorField mean_on_triangles(const TensorField& field) {
  TensorField result;
  result.corner.resize(field.corner.size());
  for (std::size_t h = 0; h < result.corner.size(); h += 3)
    result.corner[h] = result.corner[h + 1] = result.corner[h + 2] = field.mean(h / 3);
  return result;
}

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
