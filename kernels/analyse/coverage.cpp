#include "kernels/analyse/coverage.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "kernels/analyse/kd_tree.h"
#include "kernels/analyse/spacing.h"
#include "kernels/core/parallel.h"

namespace meander {

namespace {

constexpr std::size_t triangle_block = 64;
constexpr double tolerance = 1e-3;

double squared_distance(Vector3 a, Vector3 b) { return dot(a - b, a - b); }

struct Piece {
  std::array<Vector3, 3> corners;
  std::uint32_t sample = KdTree<3>::none;  // one that is near
};

// Halves triangles until none can hold a distance beyond the largest one found by more than the tolerance.
class HoleSearch {
 public:
  HoleSearch(const KdTree<3>& tree, std::span<const double> points, double found)
      : tree_(tree), points_(points), largest_(found) {}

  double largest() const { return largest_; }  // squared

  void add(const Piece& triangle) {
    pieces_.assign(1, triangle);
    while (!pieces_.empty()) {
      Piece piece = pieces_.back();
      pieces_.pop_back();
      if (is_done(piece)) continue;
      const Vector3 at = (1.0 / 3) * (piece.corners[0] + piece.corners[1] + piece.corners[2]);
      KdTree<3>::Nearest nearest;
      if (piece.sample != KdTree<3>::none)
        nearest = {squared_distance(at, sample(piece.sample)), piece.sample};
      tree_.nearest({at.x, at.y, at.z}, KdTree<3>::none, nearest);
      piece.sample = nearest.index;
      largest_ = std::max(largest_, nearest.squared);
      if (!is_done(piece)) halve(piece);
    }
  }

 private:
  Vector3 sample(std::uint32_t index) const {
    const double* at = points_.data() + 3 * std::size_t{index};
    return {at[0], at[1], at[2]};
  }

  // Every point of the piece is as near to its sample as the farthest corner.
  bool is_done(const Piece& piece) const {
    if (piece.sample == KdTree<3>::none) return false;
    const Vector3 at = sample(piece.sample);
    double most = 0;
    for (const Vector3& corner : piece.corners) most = std::max(most, squared_distance(corner, at));
    return most <= (1 + tolerance) * (1 + tolerance) * largest_;
  }

  void halve(const Piece& piece) {
    std::size_t longest = 0;
    double most = -1;
    for (std::size_t k = 0; k < 3; ++k) {
      const double squared = squared_distance(piece.corners[k], piece.corners[(k + 1) % 3]);
      if (squared > most) longest = k;
      most = std::max(most, squared);
    }
    const std::size_t other = (longest + 1) % 3;
    const Vector3 middle = 0.5 * (piece.corners[longest] + piece.corners[other]);
    pieces_.insert(pieces_.end(), 2, piece);
    pieces_[pieces_.size() - 2].corners[longest] = middle;
    pieces_.back().corners[other] = middle;
  }

  const KdTree<3>& tree_;
  std::span<const double> points_;
  double largest_;
  std::vector<Piece> pieces_;
};

// found: the square of a distance that some point of the surface has.
double largest_distance(const TriangleSpans& surface, const KdTree<3>& tree, std::span<const double> points,
                        double found) {
  const std::size_t count = surface.triangles.size() / 3;
  std::vector<double> largest((count + triangle_block - 1) / triangle_block, found);
  parallel_tasks(largest.size(), [&](std::size_t block) {
    HoleSearch search(tree, points, found);
    for (std::size_t t = block * triangle_block; t < std::min(count, (block + 1) * triangle_block); ++t) {
      Piece piece;
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t v = surface.triangles[3 * t + k];
        piece.corners[k] = {surface.x[v], surface.y[v], surface.z[v]};
      }
      search.add(piece);
    }
    largest[block] = search.largest();
  });
  for (const double l : largest) found = std::max(found, l);
  return std::sqrt(found);
}

double area_of(const TriangleSpans& surface) {
  std::vector<double> areas(surface.triangles.size() / 3);
  const auto corner = [&](std::size_t at) {
    const std::uint32_t v = surface.triangles[at];
    return Vector3{surface.x[v], surface.y[v], surface.z[v]};
  };
  for (std::size_t t = 0; t < areas.size(); ++t)
    areas[t] = triangle_area(corner(3 * t), corner(3 * t + 1), corner(3 * t + 2));
  return blocked_sum(areas);
}

}  // namespace

Coverage coverage_of(const TriangleSpans& surface, std::span<const double> points, std::uint64_t seed) {
  const std::uint64_t n = points.size() / 3;
  if (n == 0 || points.size() % 3 != 0) throw std::invalid_argument("coverage: three coordinates a point");
  const std::vector<double> reference = area_samples(surface, std::max<std::uint64_t>(20 * n, 20000), seed);
  const std::vector<double> distances = distances_to_samples(points, reference);
  const double farthest = *std::max_element(distances.begin(), distances.end());
  const double area = area_of(surface);
  Coverage coverage;
  coverage.mean = blocked_sum(distances) / static_cast<double>(distances.size());
  coverage.radius = largest_distance(surface, KdTree<3>(points), points, farthest * farthest);
  coverage.hole = coverage.radius / hexagonal_hole(area, n);
  coverage.chamfer = coverage.mean / hexagonal_mean_distance(area, n);
  return coverage;
}

}  // namespace meander
