#include "kernels/analyse/self_intersections.h"

#include <algorithm>
#include <array>
#include <vector>

#include "kernels/analyse/bounds_tree.h"
#include "kernels/core/parallel.h"

namespace meander {

namespace {

using Corners = std::array<std::uint32_t, 3>;

class IntersectionCount {
 public:
  explicit IntersectionCount(const TriangleSpans& mesh) : mesh_(mesh), count_(mesh.triangles.size() / 3) {
    std::vector<double> low(3 * count_), high(3 * count_);
    for (std::size_t t = 0; t < count_; ++t) {
      const Corners c = corners(t);
      const std::array<std::span<const double>, 3> axes = {mesh.x, mesh.y, mesh.z};
      for (std::size_t k = 0; k < 3; ++k) {
        low[3 * t + k] = std::min({axes[k][c[0]], axes[k][c[1]], axes[k][c[2]]});
        high[3 * t + k] = std::max({axes[k][c[0]], axes[k][c[1]], axes[k][c[2]]});
      }
    }
    tree_ = build_bounds_tree(low, high);
    low_ = std::move(low);
    high_ = std::move(high);
  }

  std::uint64_t run() const {
    constexpr std::size_t block = 256;
    std::vector<std::uint64_t> found((count_ + block - 1) / block, 0);
    parallel_blocks(count_, block, [&](std::size_t begin, std::size_t end) {
      for (std::size_t t = begin; t < end; ++t) found[begin / block] += pairs_of(t);
    });
    std::uint64_t sum = 0;
    for (const std::uint64_t f : found) sum += f;
    return sum;
  }

 private:
  Corners corners(std::size_t t) const {
    return {mesh_.triangles[3 * t], mesh_.triangles[3 * t + 1], mesh_.triangles[3 * t + 2]};
  }
  Vector3 at(std::uint32_t v) const { return {mesh_.x[v], mesh_.y[v], mesh_.z[v]}; }

  // With triangles of higher numbers.
  std::uint64_t pairs_of(std::size_t t) const {
    RotatedBox box;
    const double* low = low_.data() + 3 * t;
    const double* high = high_.data() + 3 * t;
    box.centre = {0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1]), 0.5 * (low[2] + high[2])};
    box.axes = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    for (std::size_t k = 0; k < 3; ++k) box.half[k] = 0.5000001 * (high[k] - low[k]) + 1e-300;
    std::uint64_t pairs = 0;
    const auto look = [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) pairs += tree_.order[i] > t && intersect(t, tree_.order[i]);
    };
    visit_box(tree_, box, look, look);
    return pairs;
  }

  bool intersect(std::size_t t, std::size_t u) const {
    for (std::size_t k = 0; k < 3; ++k)
      if (low_[3 * t + k] > high_[3 * u + k] || low_[3 * u + k] > high_[3 * t + k]) return false;
    const Corners a = corners(t), b = corners(u);
    for (const std::uint32_t v : a)
      if (std::find(b.begin(), b.end(), v) != b.end()) return false;
    for (std::size_t k = 0; k < 3; ++k)
      if (crosses(at(a[k]), at(a[(k + 1) % 3]), b) || crosses(at(b[k]), at(b[(k + 1) % 3]), a)) return true;
    return false;
  }

  // Whether the segment p q passes through the triangle.
  bool crosses(Vector3 p, Vector3 q, const Corners& c) const {
    const auto volume = [](Vector3 a, Vector3 b, Vector3 d, Vector3 e) {
      return dot(cross(b - a, d - a), e - a);
    };
    const Vector3 x = at(c[0]), y = at(c[1]), z = at(c[2]);
    if (volume(x, y, z, p) * volume(x, y, z, q) >= 0) return false;
    const double first = volume(p, q, x, y), second = volume(p, q, y, z), third = volume(p, q, z, x);
    return (first > 0 && second > 0 && third > 0) || (first < 0 && second < 0 && third < 0);
  }

  const TriangleSpans mesh_;
  const std::size_t count_;
  std::vector<double> low_, high_;
  BoundsTree tree_;
};

}  // namespace

std::uint64_t self_intersections(const TriangleSpans& mesh) { return IntersectionCount(mesh).run(); }

}  // namespace meander
