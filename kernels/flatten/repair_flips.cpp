#include "kernels/flatten/repair_flips.h"

#include <algorithm>
#include <utility>

#include "kernels/flatten/chart_report.h"
#include "kernels/flatten/mean_value.h"

namespace meander {

namespace {

constexpr int largest_patch = 6;  // rings
constexpr int rounds = 3;         // patches may overlap: repeat after all were solved
constexpr std::size_t too_many = 4096;

// Units of WorkBudget for each visit of a triangle and each judgment of it.
constexpr std::uint64_t work_per_scanned_triangle = 64;

class Patcher {
 public:
  Patcher(const IntrinsicDisk& disk, const ChartGeometry& geometry, std::span<double> u, std::span<double> v,
          WorkBudget* budget)
      : disk_(disk),
        geometry_(geometry),
        u_(u),
        v_(v),
        budget_(budget),
        leaving_(leaving_half_edges(disk)),
        vertex_mark_(disk.vertex_count, 0),
        moved_(disk.triangle_count(), 0) {}

  bool bad(std::uint32_t t) const { return is_bad_triangle(geometry_, disk_.triangles, u_, v_, t); }

  // Repairs the cluster of triangle t as far as the budget goes.
  void mend(std::uint32_t t) {
    std::vector<std::uint32_t> vertices = cluster_vertices(t);
    ++stamp_;
    for (const std::uint32_t w : vertices) vertex_mark_[w] = stamp_;
    std::size_t max_mended = 0;
    std::vector<std::uint32_t> best_free;
    std::vector<double> best_uv;
    for (int ring = 0; ring <= largest_patch; ++ring) {
      if (ring > 0) grow(vertices);
      std::vector<std::uint32_t> free;
      for (const std::uint32_t w : vertices)
        if (!on_boundary(w)) free.push_back(w);
      const std::vector<std::uint32_t> touched = triangles_at(free);
      if (!spend(budget_, work_per_scanned_triangle * (std::exchange(visits_, 0) + 2 * touched.size())))
        break;
      if (free.empty()) continue;
      const std::size_t before = count_bad(touched);
      const std::vector<double> old = positions(free);
      if (!solve_mean_value(disk_, leaving_, free, u_, v_, {}, budget_)) continue;
      const std::size_t after = count_bad(touched);
      if (after == 0) {
        mark_moved(touched);
        return;
      }
      if (after < before && before - after > max_mended) {
        max_mended = before - after;
        best_free = free;
        best_uv = positions(free);
      }
      restore(free, old);
    }
    if (best_free.empty()) return;
    restore(best_free, best_uv);
    mark_moved(triangles_at(best_free));
  }

  std::uint32_t moved_count() const {
    return static_cast<std::uint32_t>(std::count(moved_.begin(), moved_.end(), std::uint8_t{1}));
  }

 private:
  bool on_boundary(std::uint32_t w) const { return disk_.opposite[leaving_[w]] == no_index; }

  template <class Body>
  void for_each_outgoing(std::uint32_t w, Body&& body) {
    const std::uint32_t first = leaving_[w];
    std::uint32_t h = first;
    do {
      ++visits_;
      body(h);
      h = next_outgoing(disk_, h);
    } while (h != first && h != no_index);
  }

  // The vertices of all bad triangles connected to t through shared vertices.
  std::vector<std::uint32_t> cluster_vertices(std::uint32_t t) {
    ++stamp_;
    std::vector<std::uint32_t> vertices;
    const auto take = [&](std::uint32_t triangle) {
      for (int k = 0; k < 3; ++k) {
        const std::uint32_t w = disk_.triangles[3 * triangle + k];
        if (vertex_mark_[w] == stamp_) continue;
        vertex_mark_[w] = stamp_;
        vertices.push_back(w);
      }
    };
    take(t);
    for (std::size_t i = 0; i < vertices.size(); ++i)
      for_each_outgoing(vertices[i], [&](std::uint32_t h) {
        if (bad(h / 3)) take(h / 3);
      });
    return vertices;
  }

  void grow(std::vector<std::uint32_t>& vertices) {
    const std::size_t count = vertices.size();
    const auto take = [&](std::uint32_t w) {
      if (vertex_mark_[w] == stamp_) return;
      vertex_mark_[w] = stamp_;
      vertices.push_back(w);
    };
    for (std::size_t i = 0; i < count; ++i)
      for_each_outgoing(vertices[i], [&](std::uint32_t h) {
        take(disk_.triangles[next_half_edge(h)]);
        take(disk_.triangles[previous_half_edge(h)]);
      });
  }

  std::vector<std::uint32_t> triangles_at(const std::vector<std::uint32_t>& vertices) {
    std::vector<std::uint32_t> touched;
    for (const std::uint32_t w : vertices)
      for_each_outgoing(w, [&](std::uint32_t h) { touched.push_back(h / 3); });
    std::sort(touched.begin(), touched.end());
    touched.erase(std::unique(touched.begin(), touched.end()), touched.end());
    return touched;
  }

  std::size_t count_bad(const std::vector<std::uint32_t>& triangles) const {
    std::size_t count = 0;
    for (const std::uint32_t t : triangles) count += bad(t);
    return count;
  }

  std::vector<double> positions(const std::vector<std::uint32_t>& vertices) const {
    std::vector<double> uv;
    for (const std::uint32_t w : vertices) {
      uv.push_back(u_[w]);
      uv.push_back(v_[w]);
    }
    return uv;
  }
  void restore(const std::vector<std::uint32_t>& vertices, const std::vector<double>& uv) {
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      u_[vertices[i]] = uv[2 * i];
      v_[vertices[i]] = uv[2 * i + 1];
    }
  }
  void mark_moved(const std::vector<std::uint32_t>& triangles) {
    for (const std::uint32_t t : triangles) moved_[t] = 1;
  }

  const IntrinsicDisk& disk_;
  const ChartGeometry& geometry_;
  std::span<double> u_, v_;
  WorkBudget* budget_;
  std::vector<std::uint32_t> leaving_;
  std::vector<std::uint32_t> vertex_mark_;
  std::vector<std::uint8_t> moved_;
  std::uint32_t stamp_ = 0;
  std::uint64_t visits_ = 0;  // of triangles, not yet taken out of the budget
};

}  // namespace

std::uint32_t repair_flips(const IntrinsicDisk& disk, const ChartGeometry& geometry,
                           std::span<const std::uint32_t> bad, std::span<double> u, std::span<double> v,
                           const CancelToken& cancel, WorkBudget* budget) {
  if (bad.empty() || bad.size() > too_many) return 0;
  Patcher patcher(disk, geometry, u, v, budget);
  std::vector<std::uint32_t> left(bad.begin(), bad.end());
  for (int round = 0; round < rounds && !left.empty(); ++round) {
    for (const std::uint32_t t : left) {
      if (!spend(budget, work_per_scanned_triangle)) return patcher.moved_count();
      if (!patcher.bad(t)) continue;  // repaired together with another one
      cancel.check();
      patcher.mend(t);
    }
    const std::size_t before = left.size();
    if (!spend(budget, work_per_scanned_triangle * disk.triangle_count())) break;
    left = scan_map(geometry, disk.triangles, u, v).bad;
    if (left.size() >= before) break;
  }
  return patcher.moved_count();
}

}  // namespace meander
