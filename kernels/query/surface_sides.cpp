#include "kernels/query/surface_sides.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "kernels/core/parallel.h"
#include "kernels/query/lanes.h"
#include "kernels/query/segment_crossings.h"
#include "kernels/query/shell_grid.h"
#include "kernels/query/winding_number.h"

namespace meander {

namespace {

constexpr std::size_t side_block = 512, area_places = 512;
// Bounds of the errors of winding numbers. What the second errs by is 500 times less on real models; all that
// comes near a threshold is looked at with the first.
constexpr double strict_bound = 0.02, usual_bound = 10, near_threshold = 0.15;
constexpr double whole_bound = 0.25;
// Working units: closer, the side of a point is beyond double.
constexpr double on_surface = 1e-13;

Vector3 point_at(std::span<const double> points, std::size_t i) {
  return {points[3 * i], points[3 * i + 1], points[3 * i + 2]};
}

double to_whole(double winding) { return std::abs(winding - std::round(winding)); }

// Whether the nearest triangle has an open edge, or the nearest point is the end of one.
bool is_open(const OrientedSurface& oriented, const NearestTriangles& nearest, std::size_t i) {
  const std::uint8_t open = oriented.open_sides[nearest.triangle[i]];
  const double first = nearest.weights[2 * i], second = nearest.weights[2 * i + 1];
  const unsigned corner = first == 1 ? 4 : second == 1 ? 8 : first == 0 && second == 0 ? 2 : 0;
  return (open & (1 | corner)) != 0;
}

struct ClosedWork {
  const TriangleTree& tree;
  const OrientedSurface& oriented;
  const WindingTree& winding;
  std::span<const double> points;
  const NearestTriangles& nearest;
};

// A run of the order, the first by itself and each of the others by a step from the one before.
void walk(const ClosedWork& work, std::span<const std::uint32_t> run, PointSides& out) {
  bool known = false;
  std::uint32_t before = 0;
  for (std::size_t r = 0; r < run.size(); ++r) {
    const std::uint32_t i = run[r];
    if (r + lanes::ahead < run.size()) {
      const std::size_t next = run[r + lanes::ahead];
      __builtin_prefetch(work.points.data() + 3 * next);
      __builtin_prefetch(work.points.data() + 3 * next + 2);
      __builtin_prefetch(work.nearest.distance.data() + next);
      __builtin_prefetch(out.winding.data() + next, 1);
    }
    const Vector3 here = point_at(work.points, i);
    bool stepped = false;
    if (known) {
      const Vector3 there = point_at(work.points, before);
      const double step = distance(here, there) * (1 + 1e-9);
      stepped = step < work.nearest.distance[before] || step < work.nearest.distance[i];
      out.winding[i] = out.winding[before];
      if (!stepped) {
        const SegmentCrossings crossed = segment_crossings(work.tree, work.oriented.flipped, there, here);
        stepped = crossed.sure;
        out.winding[i] -= crossed.outward;
      }
    }
    if (!stepped) {
      const double winding = winding_number(work.winding, here);
      known = to_whole(winding) < whole_bound + 0.05;
      out.winding[i] = std::round(winding);
    }
    out.inside[i] = out.winding[i] != 0;
    out.certain[i] = known && work.oriented.nested && work.nearest.distance[i] > on_surface;
    before = i;
  }
}

void tell_closed(const TriangleTree& tree, const OrientedSurface& oriented, std::span<const double> points,
                 const NearestTriangles& nearest, const CancelToken& cancel, PointSides& out) {
  const WindingTree winding = build_winding_tree(tree, oriented.flipped, whole_bound);
  const ClosedWork work{tree, oriented, winding, points, nearest};
  parallel_blocks(nearest.order.size(), side_block, [&](std::size_t begin, std::size_t end) {
    cancel.check();
    walk(work, std::span(nearest.order).subspan(begin, end - begin), out);
  });
}

void tell_by_winding(const TriangleTree& tree, const OrientedSurface& oriented,
                     std::span<const double> points, const NearestTriangles& nearest,
                     const CancelToken& cancel, PointSides& out) {
  {
    const WindingTree usual = build_winding_tree(tree, oriented.flipped, usual_bound);
    out.winding = winding_numbers(usual, points, nearest.order, cancel);
  }
  std::vector<std::uint32_t> close;
  std::vector<double> close_points;
  for (std::size_t i = 0; i < out.winding.size(); ++i)
    if (std::abs(std::abs(out.winding[i]) - 0.5) < near_threshold) {
      close.push_back(static_cast<std::uint32_t>(i));
      close_points.insert(close_points.end(), points.begin() + static_cast<std::ptrdiff_t>(3 * i),
                          points.begin() + static_cast<std::ptrdiff_t>(3 * i + 3));
    }
  if (!close.empty()) {
    const WindingTree strict = build_winding_tree(tree, oriented.flipped, strict_bound);
    const std::vector<double> winding = winding_numbers(strict, close_points, cancel);
    for (std::size_t k = 0; k < close.size(); ++k) out.winding[close[k]] = winding[k];
  }
  for (std::size_t i = 0; i < out.winding.size(); ++i) {
    const double beyond = std::abs(out.winding[i]) - 0.5;
    out.inside[i] = beyond >= 0;
    out.certain[i] = oriented.nested && std::abs(beyond) >= uncertain_winding &&
                     !is_open(oriented, nearest, i) && nearest.distance[i] > on_surface;
  }
}

void tell_by_shell(const TriangleTree& tree, std::span<const double> points, const NearestTriangles& nearest,
                   const CancelToken& cancel, PointSides& out) {
  const ShellGrid grid = build_shell_grid(tree);
  parallel_blocks(nearest.order.size(), side_block, [&](std::size_t begin, std::size_t end) {
    cancel.check();
    for (std::size_t r = begin; r < end; ++r) {
      const std::uint32_t i = nearest.order[r];
      const ShellSide side = shell_side(grid, tree, point_at(points, i));
      out.inside[i] = side.inside;
      out.certain[i] = side.certain && nearest.distance[i] > on_surface;
    }
  });
}

}  // namespace

double nearly_closed_area(const PreparedMesh& mesh, const TriangleTree& tree,
                          const OrientedSurface& oriented) {
  std::vector<double> points;
  double before = 0, next = 0.5;  // in shares of the area, in places
  const double per_place = mesh.total_area / static_cast<double>(area_places);
  for (std::size_t t = 0; t < mesh.triangle_count() && per_place > 0; ++t) {
    before += mesh.area[t] / per_place;
    if (before < next) continue;
    // A triangle with many places counts as often.
    const Vector3 a = mesh.position(mesh.triangles[3 * t]), b = mesh.position(mesh.triangles[3 * t + 1]),
                  c = mesh.position(mesh.triangles[3 * t + 2]);
    const Vector3 normal = cross(b - a, c - a);
    const double length = norm(normal);
    const Vector3 beside = mesh.centroid(t) + (1e-6 / length) * normal;
    for (; next <= before; ++next) points.insert(points.end(), {beside.x, beside.y, beside.z});
  }
  if (points.empty()) return 0;
  const WindingTree winding = build_winding_tree(tree, oriented.flipped, usual_bound);
  std::size_t near = 0;
  for (const double w : winding_numbers(winding, points)) near += to_whole(w) < 0.2;
  return static_cast<double>(3 * near) / static_cast<double>(points.size());
}

SignRule sign_rule(const PreparedMesh& mesh, const TriangleTree& tree, const OrientedSurface& oriented) {
  if (!oriented.nested) return SignRule::shell;
  if (oriented.all_closed()) return SignRule::closed;
  return nearly_closed_area(mesh, tree, oriented) >= nearly_closed_share ? SignRule::winding
                                                                         : SignRule::shell;
}

PointSides point_sides(const TriangleTree& tree, const OrientedSurface& oriented, SignRule rule,
                       std::span<const double> points, const NearestTriangles& nearest,
                       const CancelToken& cancel) {
  const std::size_t count = points.size() / 3;
  if (nearest.distance.size() != count || nearest.triangle.size() != count || nearest.order.size() != count ||
      points.size() % 3 != 0)
    throw std::invalid_argument("point_sides: a nearest triangle for each point");
  if (oriented.flipped.size() != tree.count() || oriented.open_sides.size() != tree.count())
    throw std::invalid_argument("point_sides: the orientation of another mesh");
  if (rule == SignRule::closed && !oriented.all_closed())
    throw std::invalid_argument("point_sides: the surface is not closed");
  PointSides out;
  out.rule = rule;
  out.inside.assign(count, 0);
  out.certain.assign(count, 0);
  if (rule == SignRule::closed || rule == SignRule::winding) out.winding.assign(count, 0);
  if (rule == SignRule::closed) tell_closed(tree, oriented, points, nearest, cancel, out);
  if (rule == SignRule::winding) tell_by_winding(tree, oriented, points, nearest, cancel, out);
  if (rule == SignRule::shell) tell_by_shell(tree, points, nearest, cancel, out);
  for (const std::uint8_t certain : out.certain) out.uncertain += certain == 0;
  return out;
}

}  // namespace meander
