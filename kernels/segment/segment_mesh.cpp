#include "kernels/segment/segment_mesh.h"

#include <algorithm>
#include <functional>
#include <queue>
#include <stdexcept>
#include <utility>

#include "kernels/core/disjoint_sets.h"
#include "kernels/mesh/components.h"
#include "kernels/mesh/half_edges.h"
#include "kernels/segment/seeds.h"

namespace meander {

namespace {

void require_labels(const PreparedMesh& mesh, std::size_t labels) {
  if (labels != mesh.triangle_count())
    throw std::invalid_argument("segments: one label for every triangle is needed");
}

// Adjacency restricted to segments.
std::vector<std::uint32_t> opposite_within(const PreparedMesh& mesh, std::span<const std::uint32_t> label) {
  std::vector<std::uint32_t> opposite = mesh.opposite;
  for (std::size_t h = 0; h < opposite.size(); ++h)
    if (opposite[h] != no_index && label[opposite[h] / 3] != label[h / 3]) opposite[h] = no_index;
  return opposite;
}

// Segments that are merged with their neighbors, and the triangles of each.
class Merger {
 public:
  Merger(const PreparedMesh& mesh, std::span<const double> length, std::span<const std::uint32_t> part,
         std::uint32_t parts)
      : mesh_(mesh), length_(length), part_(part), sets_(parts), members_(parts) {
    for (std::uint32_t t = 0; t < part.size(); ++t) members_[part[t]].push_back(t);
    shared_.assign(parts, 0.0);
  }

  std::uint32_t find(std::uint32_t part) { return sets_.find(part); }

  // Merges parts of fewer triangles; the lower number, that of the part that begins first, stays.
  void merge_smaller_than(std::uint32_t min_triangles) {
    using Entry = std::pair<std::size_t, std::uint32_t>;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> small;
    const auto offer = [&](std::uint32_t p) {
      if (members_[p].size() < min_triangles) small.emplace(members_[p].size(), p);
    };
    for (std::uint32_t p = 0; p < members_.size(); ++p) offer(p);
    while (!small.empty()) {
      const auto [size, p] = small.top();
      small.pop();
      if (!sets_.is_representative(p) || members_[p].size() != size) continue;
      const std::uint32_t q = longest_border(p);
      if (q == no_index) continue;
      const std::uint32_t kept = std::min(p, q), gone = std::max(p, q);
      sets_.join(kept, gone);
      if (members_[kept].size() < members_[gone].size()) members_[kept].swap(members_[gone]);
      members_[kept].insert(members_[kept].end(), members_[gone].begin(), members_[gone].end());
      members_[gone] = {};
      offer(kept);
    }
  }

 private:
  // The neighbor with the longest common boundary, no_index where there is none.
  std::uint32_t longest_border(std::uint32_t p) {
    std::vector<std::uint32_t> neighbors;
    for (const std::uint32_t t : members_[p])
      for (std::uint32_t h = 3 * t; h < 3 * t + 3; ++h) {
        if (mesh_.opposite[h] == no_index) continue;
        const std::uint32_t q = find(part_[mesh_.opposite[h] / 3]);
        if (q == p) continue;
        neighbors.push_back(q);
        shared_[q] += length_[h];
      }
    std::uint32_t best = no_index;
    for (const std::uint32_t q : neighbors)
      if (best == no_index || shared_[q] > shared_[best] || (shared_[q] == shared_[best] && q < best))
        best = q;
    for (const std::uint32_t q : neighbors) shared_[q] = 0;
    return best;
  }

  const PreparedMesh& mesh_;
  std::span<const double> length_;
  std::span<const std::uint32_t> part_;
  DisjointSets sets_;
  std::vector<std::vector<std::uint32_t>> members_;
  std::vector<double> shared_;  // scratch: length of the boundary with each part
};

// Grows a set of triangles of a component from `start`, always by the neighbor with the highest value (ties:
// the lower index), up to `size` triangles, never by `barred`. Indices count from the component's first
// triangle.
std::vector<std::uint8_t> grow(const PreparedMesh& mesh, const Component& component, std::uint32_t start,
                               std::uint32_t barred, std::size_t size,
                               const std::function<double(std::uint32_t)>& value) {
  const std::uint32_t begin = component.triangle_begin;
  std::vector<std::uint8_t> inside(component.triangle_end - begin, 0), offered = inside;
  struct Entry {
    double value;
    std::uint32_t triangle;
    bool operator<(const Entry& other) const {
      return value < other.value || (value == other.value && triangle > other.triangle);
    }
  };
  std::priority_queue<Entry> queue;
  queue.push({value(start), start});
  offered[start] = 1;
  for (std::size_t grown = 0; grown < size && !queue.empty(); ++grown) {
    const std::uint32_t t = queue.top().triangle;
    queue.pop();
    inside[t] = 1;
    for (std::uint32_t h = 3 * (begin + t); h < 3 * (begin + t) + 3; ++h) {
      if (mesh.opposite[h] == no_index) continue;
      const std::uint32_t next = mesh.opposite[h] / 3 - begin;
      if (offered[next] || next == barred) continue;
      offered[next] = 1;
      queue.push({value(next), next});
    }
  }
  return inside;
}

// Gives triangles of the seed's label that are not connected to the seed the other label.
void keep_connected(const PreparedMesh& mesh, const Component& component, std::uint32_t seed,
                    std::vector<std::uint32_t>& label) {
  const std::uint32_t begin = component.triangle_begin, kept = label[seed];
  std::vector<std::uint8_t> reached(label.size(), 0);
  std::vector<std::uint32_t> stack = {seed};
  reached[seed] = 1;
  while (!stack.empty()) {
    const std::uint32_t t = stack.back();
    stack.pop_back();
    for (std::uint32_t h = 3 * (begin + t); h < 3 * (begin + t) + 3; ++h) {
      if (mesh.opposite[h] == no_index) continue;
      const std::uint32_t next = mesh.opposite[h] / 3 - begin;
      if (reached[next] || label[next] != kept) continue;
      reached[next] = 1;
      stack.push_back(next);
    }
  }
  for (std::size_t t = 0; t < label.size(); ++t)
    if (label[t] == kept && !reached[t]) label[t] = 1 - kept;
}

}  // namespace

std::uint32_t tidy_segments(const PreparedMesh& mesh, std::span<const double> length,
                            std::uint32_t min_triangles, std::vector<std::uint32_t>& label) {
  require_labels(mesh, label.size());
  if (length.size() != mesh.triangles.size())
    throw std::invalid_argument("segments: one length for every half-edge is needed");
  std::vector<std::uint32_t> part;
  const std::uint32_t parts = find_components(opposite_within(mesh, label), part);
  Merger merger(mesh, length, part, parts);
  merger.merge_smaller_than(min_triangles);
  std::vector<std::uint32_t> number(parts, no_index);
  std::uint32_t segments = 0;
  for (std::size_t t = 0; t < label.size(); ++t) {
    std::uint32_t& place = number[merger.find(part[t])];
    if (place == no_index) place = segments++;
    label[t] = place;
  }
  return segments;
}

SegmentedMesh split_into_segments(const PreparedMesh& mesh, std::span<const std::uint32_t> label) {
  require_labels(mesh, label.size());
  const auto count = static_cast<std::uint32_t>(mesh.triangle_count());
  const std::vector<std::uint32_t> opposite = opposite_within(mesh, label);
  std::vector<std::uint32_t> part;
  const std::uint32_t parts = find_components(opposite, part);
  std::vector<CentroidSum> sums(parts);
  for (std::uint32_t t = 0; t < count; ++t) sums[part[t]].add(mesh.area[t], mesh.centroid(t));
  const std::vector<std::uint32_t> place = places_along_curve(sums);

  SegmentedMesh result;
  PreparedMesh& out = result.mesh;
  out.center = mesh.center;
  out.unit = mesh.unit;
  out.diagonal = mesh.diagonal;
  out.bbox = mesh.bbox;
  out.total_area = mesh.total_area;
  out.unreferenced_vertices = mesh.unreferenced_vertices;
  out.repairs = mesh.repairs;

  std::vector<std::uint32_t> next(parts + 1, 0);
  for (std::uint32_t t = 0; t < count; ++t) ++next[place[part[t]] + 1];
  for (std::uint32_t p = 0; p < parts; ++p) next[p + 1] += next[p];
  out.components.assign(parts, {});
  for (std::uint32_t p = 0; p < parts; ++p) {
    out.components[p].triangle_begin = next[p];
    out.components[p].triangle_end = next[p + 1];
  }
  std::vector<std::uint32_t> moved_to(count);
  result.source_triangle.resize(count);
  for (std::uint32_t t = 0; t < count; ++t) {
    moved_to[t] = next[place[part[t]]]++;
    result.source_triangle[moved_to[t]] = t;
  }
  out.opposite.resize(3 * std::size_t{count});
  out.corner_slot.resize(3 * std::size_t{count});
  out.polygon.resize(count);
  out.area.resize(count);
  for (std::uint32_t to = 0; to < count; ++to) {
    const std::uint32_t from = result.source_triangle[to];
    out.polygon[to] = mesh.polygon[from];
    out.area[to] = mesh.area[from];
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::uint32_t other = opposite[3 * from + k];
      out.opposite[3 * to + k] = other == no_index ? no_index : 3 * moved_to[other / 3] + other % 3;
      out.corner_slot[3 * to + k] = mesh.corner_slot[3 * from + k];
    }
  }

  const std::uint32_t fans = number_fans(out.opposite, out.triangles);
  result.source_vertex.resize(fans);
  out.x.resize(fans);
  out.y.resize(fans);
  out.z.resize(fans);
  for (std::uint32_t h = 0; h < out.triangles.size(); ++h) {
    const std::uint32_t v = out.triangles[h];
    const std::uint32_t from = mesh.triangles[3 * result.source_triangle[h / 3] + h % 3];
    result.source_vertex[v] = from;
    out.x[v] = mesh.x[from];
    out.y[v] = mesh.y[from];
    out.z[v] = mesh.z[from];
  }
  describe_components(out);

  result.source_component.resize(parts);
  for (std::uint32_t p = 0; p < parts; ++p) {
    const std::uint32_t t = result.source_triangle[out.components[p].triangle_begin];
    const auto after =
        std::upper_bound(mesh.components.begin(), mesh.components.end(), t,
                         [](std::uint32_t a, const Component& c) { return a < c.triangle_end; });
    result.source_component[p] = static_cast<std::uint32_t>(after - mesh.components.begin());
  }
  return result;
}

SegmentedMesh segment_mesh(const PreparedMesh& mesh, const TensorField& field,
                           const SegmentParameters& parameters, const CancelToken& cancel) {
  if (parameters.count == 0) throw std::invalid_argument("segments: at least one is needed");
  const TriangleSteps steps = triangle_steps(mesh, field, parameters.walk);
  const std::vector<std::uint32_t> seeds = farthest_seeds(mesh, steps.length, parameters.count, cancel);
  std::vector<std::uint32_t> label = random_walk_labels(mesh, steps.weight, seeds, cancel);
  tidy_segments(mesh, metric_edge_lengths(mesh, field), parameters.min_triangles, label);
  cancel.check();
  return split_into_segments(mesh, label);
}

std::vector<std::uint32_t> bisect_component(const PreparedMesh& mesh, const Component& component,
                                            const TriangleSteps& steps, const CancelToken& cancel) {
  const std::uint32_t begin = component.triangle_begin, count = component.triangle_end - begin;
  std::vector<std::uint32_t> label(count, 0);
  if (count < 2) return label;
  std::vector<std::uint32_t> seeds = farthest_seeds(mesh, component, steps.length, 2, cancel);
  if (seeds.size() < 2) seeds = {begin, begin + count - 1};  // every step has length 0
  const std::vector<double> probability =
      random_walk_probabilities(mesh, component, steps.weight, seeds, cancel);
  std::uint32_t second = 0;
  for (std::uint32_t t = 0; t < count; ++t) {
    label[t] = probability[2 * t] >= probability[2 * t + 1] ? 0 : 1;
    second += label[t];
  }
  const std::uint32_t quarter = std::max(1u, count / 4);
  if (second < quarter || count - second < quarter) {
    const std::uint32_t small = second < quarter ? 1 : 0;
    const std::vector<std::uint8_t> grown =
        grow(mesh, component, seeds[small] - begin, seeds[1 - small] - begin, quarter,
             [&](std::uint32_t t) { return probability[2 * t + small]; });
    for (std::uint32_t t = 0; t < count; ++t) label[t] = grown[t] ? small : 1 - small;
  }
  // The first call may give islands to the side of the second seed. Triangles then cut off from that seed
  // touch the first side only.
  keep_connected(mesh, component, seeds[0] - begin, label);
  keep_connected(mesh, component, seeds[1] - begin, label);
  if (label[0] == 1)
    for (std::uint32_t& l : label) l = 1 - l;
  return label;
}

SegmentedMesh bisect_components(const PreparedMesh& mesh, std::span<const std::uint32_t> components,
                                const TriangleSteps& steps, const CancelToken& cancel) {
  std::vector<std::uint32_t> label(mesh.triangle_count());
  for (std::uint32_t c = 0; c < mesh.components.size(); ++c)
    std::fill(label.begin() + mesh.components[c].triangle_begin,
              label.begin() + mesh.components[c].triangle_end, 2 * c);
  for (const std::uint32_t c : components) {
    const Component& component = mesh.components.at(c);
    const std::vector<std::uint32_t> half = bisect_component(mesh, component, steps, cancel);
    for (std::uint32_t t = component.triangle_begin; t < component.triangle_end; ++t)
      label[t] = 2 * c + half[t - component.triangle_begin];
  }
  return split_into_segments(mesh, label);
}

TensorField carry_field(const SegmentedMesh& segmented, const TensorField& field) {
  TensorField carried;
  carried.corner.resize(field.corner.size());
  for (std::size_t h = 0; h < carried.corner.size(); ++h)
    carried.corner[h] = field.corner[3 * segmented.source_triangle[h / 3] + h % 3];
  return carried;
}

std::vector<double> carry_half_edge_values(const SegmentedMesh& segmented, std::span<const double> values) {
  std::vector<double> carried(values.size());
  for (std::size_t h = 0; h < carried.size(); ++h)
    carried[h] = values[3 * segmented.source_triangle[h / 3] + h % 3];
  return carried;
}

}  // namespace meander
