#include "kernels/segment/seeds.h"

#include <algorithm>
#include <limits>

#include "kernels/core/radix_heap.h"
#include "kernels/mesh/components.h"

namespace meander {

namespace {

constexpr double unreached = std::numeric_limits<double>::infinity();

// The triangle whose centroid lies farthest from the component's area centroid: approximately a tip.
std::uint32_t outermost_triangle(const PreparedMesh& mesh, const Component& component) {
  CentroidSum sum;
  for (std::uint32_t t = component.triangle_begin; t < component.triangle_end; ++t)
    sum.add(mesh.area[t], mesh.centroid(t));
  const Vector3 center = sum.centroid();
  std::uint32_t best = component.triangle_begin;
  double longest = -1;
  for (std::uint32_t t = component.triangle_begin; t < component.triangle_end; ++t) {
    const Vector3 d = mesh.centroid(t) - center;
    if (dot(d, d) > longest) {
      longest = dot(d, d);
      best = t;
    }
  }
  return best;
}

// Distances to the nearest of the sources so far (Dijkstra 1959), within a range of triangles that no edge
// leaves.
class NearestSource {
 public:
  NearestSource(const PreparedMesh& mesh, std::uint32_t begin, std::uint32_t end,
                std::span<const double> length, const CancelToken& cancel)
      : mesh_(mesh), length_(length), cancel_(cancel), begin_(begin), distance_(end - begin, unreached) {}

  void add(std::uint32_t source) {
    heap_.restart();
    distance_[source - begin_] = 0;
    heap_.push(0, source);
    while (!heap_.empty()) {
      if (++steps_ % 65536 == 0) cancel_.check();
      const RadixHeap::Entry entry = heap_.pop();
      if (entry.key > distance_[entry.value - begin_]) continue;
      for (std::uint32_t h = 3 * entry.value; h < 3 * entry.value + 3; ++h) {
        const std::uint32_t other = mesh_.opposite[h];
        if (other == no_index) continue;
        const double through = entry.key + length_[h];
        if (!(through < distance_[other / 3 - begin_])) continue;
        distance_[other / 3 - begin_] = through;
        heap_.push(through, other / 3);
      }
    }
  }

  // Adds the component's first seed, from which farthest-point search continues.
  std::uint32_t add_first(const Component& component) {
    add(outermost_triangle(mesh_, component));
    const std::uint32_t seed = farthest(component.triangle_begin, component.triangle_end);
    std::fill(at(component.triangle_begin), at(component.triangle_end), unreached);
    add(seed);
    return seed;
  }

  void add_farthest(std::uint32_t count, std::vector<std::uint32_t>& seeds) {
    const auto end = begin_ + static_cast<std::uint32_t>(distance_.size());
    while (seeds.size() < count) {
      cancel_.check();  // each seed is searched among all triangles
      const std::uint32_t seed = farthest(begin_, end);
      if (!(distance_[seed - begin_] > 0)) break;
      seeds.push_back(seed);
      add(seed);
    }
  }

 private:
  std::vector<double>::iterator at(std::uint32_t triangle) { return distance_.begin() + (triangle - begin_); }
  std::uint32_t farthest(std::uint32_t begin, std::uint32_t end) {
    return begin_ + static_cast<std::uint32_t>(std::max_element(at(begin), at(end)) - distance_.begin());
  }

  const PreparedMesh& mesh_;
  std::span<const double> length_;
  const CancelToken& cancel_;
  std::uint32_t begin_;
  std::vector<double> distance_;
  RadixHeap heap_;
  std::size_t steps_ = 0;
};

}  // namespace

std::vector<std::uint32_t> farthest_seeds(const PreparedMesh& mesh, std::span<const double> length,
                                          std::uint32_t count, const CancelToken& cancel) {
  NearestSource nearest(mesh, 0, static_cast<std::uint32_t>(mesh.triangle_count()), length, cancel);
  std::vector<std::uint32_t> seeds;
  for (const Component& component : mesh.components) seeds.push_back(nearest.add_first(component));
  nearest.add_farthest(count, seeds);
  return seeds;
}

std::vector<std::uint32_t> farthest_seeds(const PreparedMesh& mesh, const Component& component,
                                          std::span<const double> length, std::uint32_t count,
                                          const CancelToken& cancel) {
  NearestSource nearest(mesh, component.triangle_begin, component.triangle_end, length, cancel);
  std::vector<std::uint32_t> seeds = {nearest.add_first(component)};
  nearest.add_farthest(count, seeds);
  return seeds;
}

}  // namespace meander
