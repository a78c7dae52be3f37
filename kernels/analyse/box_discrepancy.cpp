#include "kernels/analyse/box_discrepancy.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "kernels/analyse/box_triangles.h"
#include "kernels/analyse/rotated_box_search.h"
#include "kernels/core/parallel.h"
#include "kernels/core/portable_angles.h"
#include "kernels/core/random.h"
#include "kernels/core/rotation.h"
#include "kernels/core/status.h"

namespace meander {

namespace {

constexpr std::uint32_t draws_per_box = 1000;
constexpr std::uint32_t words_per_draw = 6;  // counters that one draw of a box uses: two numbers each

using Corner = std::array<double, 3>;  // coordinates in the frame of a box

// The part of a polygon where sign * coordinate[axis] <= half (Sutherland and Hodgman 1974).
int clip(const Corner* in, int count, Corner* out, std::size_t axis, double sign, double half) {
  int kept = 0;
  for (int i = 0; i < count; ++i) {
    const Corner& from = in[i];
    const Corner& to = in[i + 1 == count ? 0 : i + 1];
    const double d0 = half - sign * from[axis], d1 = half - sign * to[axis];
    if (d0 >= 0) out[kept++] = from;
    if ((d0 > 0 && d1 < 0) || (d0 < 0 && d1 > 0)) {
      const double t = d0 / (d0 - d1);
      for (std::size_t k = 0; k < 3; ++k) out[kept][k] = from[k] + t * (to[k] - from[k]);
      out[kept++][axis] = sign * half;
    }
  }
  return kept;
}

double polygon_area(const Corner* corners, int count) {
  double x = 0, y = 0, z = 0;
  const Corner& o = corners[0];
  for (int i = 1; i + 1 < count; ++i) {
    const Corner &a = corners[i], &b = corners[i + 1];
    const Vector3 n = cross({a[0] - o[0], a[1] - o[1], a[2] - o[2]}, {b[0] - o[0], b[1] - o[1], b[2] - o[2]});
    x += n.x;
    y += n.y;
    z += n.z;
  }
  return 0.5 * std::sqrt(x * x + y * y + z * z);
}

// Area of the part of one triangle inside the box; `whole` is the triangle's area.
double clipped_area(const RotatedBox& box, Vector3 a, Vector3 b, Vector3 c, double whole) {
  // A convex polygon has at most nine corners in the end. Rounding can bend one that lies almost in a plane
  // of the box, and then a clip can add a corner for every two: 3 * 1.5^6 < 40 is never exceeded.
  std::array<Corner, 40> first, second;
  first[0] = to_box(box, a);
  first[1] = to_box(box, b);
  first[2] = to_box(box, c);
  bool inside = true;
  for (std::size_t k = 0; k < 3; ++k) {
    const double low = std::min({first[0][k], first[1][k], first[2][k]});
    const double high = std::max({first[0][k], first[1][k], first[2][k]});
    if (low > box.half[k] || high < -box.half[k]) return 0;
    inside = inside && low >= -box.half[k] && high <= box.half[k];
  }
  if (inside) return whole;
  int count = 3;
  for (std::size_t k = 0; k < 3 && count > 0; ++k) {
    count = clip(first.data(), count, second.data(), k, 1, box.half[k]);
    count = clip(second.data(), count, first.data(), k, -1, box.half[k]);
  }
  return count < 3 ? 0 : polygon_area(first.data(), count);
}

// Triangles along the 3-D Hilbert curve under a bounds tree: areas in boxes in sublinear time.
class AreaTree {
 public:
  AreaTree(std::span<const double> x, std::span<const double> y, std::span<const double> z,
           std::span<const std::uint32_t> triangles)
      : triangles_(build_box_triangles(x, y, z, triangles)) {
    before_.resize(triangles_.count() + 1);
    for (std::size_t p = 0; p < triangles_.count(); ++p)
      before_[p + 1] = before_[p] + triangle_area(corner(p, 0), corner(p, 1), corner(p, 2));
  }

  double total() const { return before_.back(); }

  double area_in(const RotatedBox& box) const {
    double area = 0;
    visit_box(
        triangles_.tree, box,
        [&](std::size_t begin, std::size_t end) { area += before_[end] - before_[begin]; },
        [&](std::size_t begin, std::size_t end) {
          for (std::size_t p = begin; p < end; ++p)
            area += clipped_area(box, corner(p, 0), corner(p, 1), corner(p, 2), before_[p + 1] - before_[p]);
        });
    return area;
  }

  // The point with weights from (first, second) of the triangle that holds share u of the area.
  Vector3 point_at(double u, UnitPair weights) const {
    const auto at = std::upper_bound(before_.begin() + 1, before_.end() - 1, u * total());
    const auto p = static_cast<std::size_t>(at - before_.begin()) - 1;
    const double root = std::sqrt(weights.first);  // uniform over the triangle
    const double b1 = root * (1 - weights.second), b2 = root * weights.second;
    return (1 - root) * corner(p, 0) + b1 * corner(p, 1) + b2 * corner(p, 2);
  }

  double diagonal() const {
    const std::vector<double>& root = triangles_.tree.levels.back();
    return 2 * norm({root[3], root[4], root[5]});
  }

 private:
  Vector3 corner(std::size_t p, std::size_t k) const { return triangles_.corner(p, k); }

  BoxTriangles triangles_;
  std::vector<double> before_;  // areas summed along the curve
};

// Rows of the rotation of the unit quaternion that three uniform numbers give (Shoemake 1992).
Rotation rotation_from_uniform(double u0, double u1, double u2) {
  const double turn = 2 * std::numbers::pi;
  const double s = std::sqrt(1 - u0), c = std::sqrt(u0);
  const Direction first = direction_of(turn * u1), second = direction_of(turn * u2);
  return rotation_of(s * first.sine, s * first.cosine, c * second.sine, c * second.cosine);
}

// Draw `draw` of box `index`; the share is not set.
RotatedBox draw_box(const AreaTree& surface, const BoxParameters& parameters, RandomKey key,
                    std::uint32_t index, std::uint32_t draw) {
  std::array<double, 2 * words_per_draw> u;
  for (std::uint32_t i = 0; i < words_per_draw; ++i) {
    const UnitPair pair = random_pair(key, Stream::test_shapes, index, draw * words_per_draw + i);
    u[2 * i] = pair.first;
    u[2 * i + 1] = pair.second;
  }
  RotatedBox box;
  box.axes = rotation_from_uniform(u[0], u[1], u[2]);
  box.center = surface.point_at(u[3], {u[4], u[5]});
  for (std::size_t k = 0; k < 3; ++k) {
    box.half[k] = surface.diagonal() * (parameters.half_size_min + parameters.half_size_span * u[6 + k]);
    box.center = box.center + ((u[9 + k] - 0.5) * box.half[k]) * box.axes[k];
  }
  return box;
}

// The points along the 3-D Hilbert curve, coordinates apart.
struct PointTree {
  BoundsTree tree;
  std::vector<double> x, y, z;
};

PointTree build_point_tree(std::span<const double> points) {
  PointTree set;
  set.tree = build_bounds_tree(points, points);
  const std::size_t count = set.tree.count();
  set.x.resize(count);
  set.y.resize(count);
  set.z.resize(count);
  for (std::size_t p = 0; p < count; ++p) {
    const double* point = points.data() + 3 * std::size_t{set.tree.order[p]};
    set.x[p] = point[0];
    set.y[p] = point[1];
    set.z[p] = point[2];
  }
  return set;
}

std::size_t count_in(const PointTree& set, const RotatedBox& box) {
  std::size_t count = 0;
  visit_box(
      set.tree, box, [&](std::size_t begin, std::size_t end) { count += end - begin; },
      [&](std::size_t begin, std::size_t end) {
        for (std::size_t p = begin; p < end; ++p) {
          const Corner at = to_box(box, {set.x[p], set.y[p], set.z[p]});
          // Without short cuts, so that the loop has no branches.
          const auto within = [&](std::size_t axis) -> std::size_t {
            return std::abs(at[axis]) <= box.half[axis];
          };
          count += within(0) & within(1) & within(2);
        }
      });
  return count;
}

}  // namespace

double area_in_box(std::span<const double> x, std::span<const double> y, std::span<const double> z,
                   std::span<const std::uint32_t> triangles, const RotatedBox& box) {
  const std::size_t count = triangles.size() / 3;
  std::vector<double> areas(count);
  parallel_blocks(count, sum_block, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) {
      const std::uint32_t i = triangles[3 * t], j = triangles[3 * t + 1], k = triangles[3 * t + 2];
      const Vector3 a{x[i], y[i], z[i]}, b{x[j], y[j], z[j]}, c{x[k], y[k], z[k]};
      areas[t] = clipped_area(box, a, b, c, triangle_area(a, b, c));
    }
  });
  return blocked_sum(areas);
}

std::vector<RotatedBox> random_boxes(std::span<const double> x, std::span<const double> y,
                                     std::span<const double> z, std::span<const std::uint32_t> triangles,
                                     const BoxParameters& parameters) {
  if (triangles.size() < 3) throw ItemError(Status::zero_area, "no triangle to lay test boxes on");
  const AreaTree surface(x, y, z, triangles);
  if (!(surface.total() > 0)) throw ItemError(Status::zero_area, "no area to lay test boxes on");

  const RandomKey key = make_random_key(parameters.seed, {});
  std::vector<RotatedBox> drawn(parameters.boxes);
  std::vector<std::uint8_t> kept(parameters.boxes, 0);
  parallel_tasks(parameters.boxes, [&](std::size_t i) {
    for (std::uint32_t draw = 0; draw < draws_per_box && kept[i] == 0; ++draw) {
      drawn[i] = draw_box(surface, parameters, key, static_cast<std::uint32_t>(i), draw);
      drawn[i].share = surface.area_in(drawn[i]) / surface.total();
      kept[i] = drawn[i].share >= parameters.share_min && drawn[i].share <= parameters.share_max;
    }
  });
  std::vector<RotatedBox> boxes;
  for (std::size_t i = 0; i < drawn.size(); ++i)
    if (kept[i] != 0) boxes.push_back(drawn[i]);
  return boxes;
}

std::vector<double> box_errors(std::span<const RotatedBox> boxes, std::span<const double> points) {
  if (boxes.empty() || points.size() < 3)
    throw std::invalid_argument("box errors need at least one box and one point");
  const PointTree set = build_point_tree(points);
  const auto n = static_cast<double>(set.tree.count());
  std::vector<double> errors(boxes.size());
  parallel_tasks(boxes.size(), [&](std::size_t i) {
    errors[i] = static_cast<double>(count_in(set, boxes[i])) / n - boxes[i].share;
  });
  return errors;
}

double box_error_ratio(std::span<const RotatedBox> boxes, std::span<const double> points) {
  std::vector<double> squared = box_errors(boxes, points), variance(boxes.size());
  const auto n = static_cast<double>(points.size() / 3);
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    squared[i] *= squared[i];
    variance[i] = boxes[i].share * (1 - boxes[i].share) / n;
  }
  return std::sqrt(blocked_sum(squared) / blocked_sum(variance));
}

void BoxBias::add(std::span<const double> errors) {
  if (sets_ == 0) {
    sum_.assign(errors.size(), 0.0);
    squares_.assign(errors.size(), 0.0);
  }
  if (errors.size() != sum_.size()) throw std::invalid_argument("every set must meet the same boxes");
  ++sets_;
  for (std::size_t i = 0; i < errors.size(); ++i) {
    sum_[i] += errors[i];
    squares_[i] += errors[i] * errors[i];
  }
}

double BoxBias::ratio() const {
  double bias = 0, one = 0;
  for (std::size_t i = 0; i < sum_.size(); ++i) {
    const double mean = sum_[i] / sets_, square = squares_[i] / sets_;
    bias += mean * mean - (square - mean * mean) / (sets_ - 1);
    one += square;
  }
  return std::sqrt(std::max(0.0, bias / one));
}

}  // namespace meander
