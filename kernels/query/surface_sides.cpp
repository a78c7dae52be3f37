#include "kernels/query/surface_sides.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "kernels/core/parallel.h"
#include "kernels/query/boundary_field.h"
#include "kernels/query/open_holes.h"
#include "kernels/query/segment_crossings.h"
#include "kernels/query/shell_grid.h"
#include "kernels/query/winding_number.h"

namespace meander {

namespace {

constexpr std::size_t side_block = 512, area_places = 512;
// Bounds of the errors of winding numbers: near the threshold, and of all others, for which the one of the
// expansion is usual_bound. On real models they err by 500 times less than that.
constexpr double strict_bound = 0.02, usual_bound = 10, usual_error = 0.1, near_threshold = 0.05;
constexpr double whole_bound = 0.25;
// What the gradient may add to errors; beyond largest_error in all, a number is computed anew. Beyond
// anchor_share of the reach of one anchor the next one is set.
constexpr double change_bound = 0.5, change_tolerance = 0.02, largest_error = 0.2, anchor_share = 0.7;
// Working units: closer, the side of a point is beyond double.
constexpr double on_surface = 1e-13;
// Where the nearest point lies on an open edge a side is in doubt, unless the winding number is within this
// of a whole one, as it is from about four radii of a hole above its middle on.
constexpr double nearly_whole = 0.03;
// Weights within this of 0 are those of points on an edge.
constexpr double on_edge = 1e-12;

Vector3 point_at(std::span<const double> points, std::size_t i) {
  return {points[3 * i], points[3 * i + 1], points[3 * i + 2]};
}

// Whether the balls around two points that their distances leave empty of the surface cover the way between
// them.
bool is_short(Vector3 there, double distance_there, Vector3 here, double distance_here) {
  constexpr double roundings = 1e-9;
  return distance(here, there) * (1 + roundings) < distance_there + distance_here;
}

double to_whole(double winding) { return std::abs(winding - std::round(winding)); }

// Whether the nearest point lies on an open edge, or at the end of one.
bool is_open(const OrientedSurface& oriented, const NearestTriangles& nearest, std::size_t i) {
  const std::uint8_t open = oriented.open_sides[nearest.triangle[i]];
  if (open == 0) return false;
  const double first = nearest.weights[2 * i], second = nearest.weights[2 * i + 1];
  // The sides that the point lies on: from corner 0 to 1, 1 to 2 and 2 to 0.
  const unsigned sides =
      (second <= 0 ? 1u : 0u) | (1 - first - second <= on_edge ? 2u : 0u) | (first <= 0 ? 4u : 0u);
  const unsigned corner = sides == 5 ? 1u : sides == 3 ? 2u : sides == 6 ? 4u : 0u;
  return (open & (sides | corner << 3)) != 0;
}

struct ClosedWork {
  const TriangleTree& tree;
  const OrientedSurface& oriented;
  const WindingTree& winding;
  std::span<const double> points;
  const NearestTriangles& nearest;
};

// The points from `begin` to `end`, the first by itself and each of the others by a step from the one before.
void walk(const ClosedWork& work, std::size_t begin, std::size_t end, PointSides& out) {
  bool known = false;
  for (std::size_t i = begin; i < end; ++i) {
    const Vector3 here = point_at(work.points, i);
    bool stepped = false;
    if (known) {
      const Vector3 there = point_at(work.points, i - 1);
      stepped = is_short(there, work.nearest.distance[i - 1], here, work.nearest.distance[i]);
      out.winding[i] = out.winding[i - 1];
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
  }
}

void tell_closed(const TriangleTree& tree, const OrientedSurface& oriented, std::span<const double> points,
                 const NearestTriangles& nearest, const CancelToken& cancel, PointSides& out) {
  const WindingTree winding = build_winding_tree(tree, oriented.flipped, whole_bound);
  const ClosedWork work{tree, oriented, winding, points, nearest};
  parallel_blocks(nearest.distance.size(), side_block, [&](std::size_t begin, std::size_t end) {
    cancel.check();
    walk(work, begin, end, out);
  });
}

// Where the winding number is known, and how it changes around: as far as its radius reaches it is that of
// the anchor, less the crossings on the way, plus what the gradient says.
struct Anchor {
  Vector3 at;
  double winding = 0, error = 0;
  WindingChange change;
  int crossings = 0;  // outward, on the way to the last point
  bool known = false;

  double winding_at(Vector3 here) const { return winding + dot(change.gradient, here - at) - crossings; }
  double error_at(Vector3 here) const {
    const double share = distance(here, at) / change.radius;
    return error + (share > 0 ? change_tolerance * share * share : 0);
  }
};

struct WindingWork {
  const TriangleTree& tree;
  const OrientedSurface& oriented;
  const WindingTree& winding;
  const BoundaryField& boundary;
  const OpenHoles& holes;
  std::span<const double> points;
  const NearestTriangles& nearest;
};

// Follows the way from the point before, whose anchor reaches to the new one.
bool step_to(const WindingWork& work, std::size_t i, Anchor& anchor) {
  const Vector3 here = point_at(work.points, i);
  if (!anchor.known || !(distance(here, anchor.at) < anchor.change.radius)) return false;
  const Vector3 there = point_at(work.points, i - 1);
  if (is_short(there, work.nearest.distance[i - 1], here, work.nearest.distance[i])) return true;
  const SegmentCrossings crossed = segment_crossings(work.tree, work.oriented.flipped, there, here);
  anchor.crossings += crossed.outward;
  return crossed.sure;
}

bool is_near_threshold(double winding, double error) {
  return std::abs(std::abs(winding) - 0.5) < near_threshold + error;
}

void set_anchor(const WindingWork& work, Vector3 here, double winding, double error, Anchor& anchor) {
  if (!anchor.known || distance(anchor.at, here) > 0)
    anchor.change = winding_change(work.boundary, here, change_bound);
  anchor.at = here;
  anchor.winding = winding;
  anchor.error = error;
  anchor.crossings = 0;
  anchor.known = true;
}

// Whether what is missing beside an open edge may have made the side: it is the nearest. Where the winding
// number is 1 or more all that may be missing adds to an inside.
bool is_doubtful(const WindingWork& work, std::size_t i, double winding) {
  return std::abs(winding) < 1 && to_whole(winding) > nearly_whole && is_open(work.oriented, work.nearest, i);
}

void walk(const WindingWork& work, std::size_t begin, std::size_t end, PointSides& out) {
  Anchor anchor;
  for (std::size_t i = begin; i < end; ++i) {
    const Vector3 here = point_at(work.points, i);
    if (i == begin || !step_to(work, i, anchor))
      set_anchor(work, here, winding_number(work.winding, here), usual_error, anchor);
    double winding = anchor.winding_at(here), error = anchor.error_at(here);
    if (anchor.error > strict_bound && is_near_threshold(winding, error)) {
      winding = winding_number(work.winding, here, true);
      error = strict_bound;
      set_anchor(work, here, winding, error, anchor);
    } else if (distance(here, anchor.at) > anchor_share * anchor.change.radius && error < largest_error) {
      set_anchor(work, here, winding, error, anchor);
    }
    out.winding[i] = winding;
    const double beyond = std::abs(winding) - 0.5;
    out.inside[i] = beyond >= 0;
    out.certain[i] = work.oriented.nested && std::abs(beyond) >= uncertain_winding &&
                     work.nearest.distance[i] > on_surface && !is_doubtful(work, i, winding) &&
                     work.holes.agree(here, winding);
  }
}

void tell_by_winding(const TriangleTree& tree, const OrientedSurface& oriented,
                     std::span<const double> points, const NearestTriangles& nearest,
                     const CancelToken& cancel, PointSides& out) {
  const WindingTree winding = build_winding_tree(tree, oriented.flipped, usual_bound, strict_bound);
  const BoundaryField boundary = build_boundary_field(oriented.boundary);
  const OpenHoles holes(oriented, tree.count());
  const WindingWork work{tree, oriented, winding, boundary, holes, points, nearest};
  parallel_blocks(nearest.distance.size(), side_block, [&](std::size_t begin, std::size_t end) {
    cancel.check();
    walk(work, begin, end, out);
  });
}

struct ShellWork {
  const ShellGrid& grid;
  const TriangleTree& tree;
  std::span<const std::uint32_t> position;  // of a triangle in the tree
  std::span<const double> points;
  const NearestTriangles& nearest;
};

// The last point of a run on a side, and the last one there whose side was looked up.
struct SidePoint {
  Vector3 at, looked_up;
  double distance = 0;         // from the surface
  std::uint32_t position = 0;  // of the nearest triangle
  ShellSide side;
  bool known = false;
};

// Whether a point of a cell of the surface can be reached from the last one on a side past all triangles.
// The triangle nearest to one of them is most often in the way.
bool reaches(const ShellWork& work, const SidePoint& from, const SidePoint& to) {
  if (!from.known || distance(to.at, from.looked_up) > work.grid.cell) return false;
  if (is_short(from.at, from.distance, to.at, to.distance)) return true;
  return is_free_segment(work.tree, from.at, to.at, std::array{to.position, from.position});
}

// Sides of the points from `begin` to `end` by the grid. Points of cells of the surface have the side of a
// point no more than a cell away that was looked up, if a way leads there.
void walk(const ShellWork& work, std::size_t begin, std::size_t end, PointSides& out) {
  std::array<SidePoint, 3> last;  // outside, inside, uncertain
  std::size_t at = 0;
  for (std::size_t i = begin; i < end; ++i) {
    SidePoint here;
    here.at = point_at(work.points, i);
    here.distance = work.nearest.distance[i];
    here.position = work.position[work.nearest.triangle[i]];
    const std::array likely{here.position};
    if (is_surface_cell(work.grid, here.at)) {
      std::size_t from = at;
      for (std::size_t k = 0; k < last.size(); ++k) {
        from = (at + k) % last.size();
        if (reaches(work, last[from], here)) break;
        from = last.size();
      }
      if (from == last.size()) {
        here.side = shell_side(work.grid, work.tree, here.at, likely);
        here.looked_up = here.at;
        from = !here.side.certain ? 2 : here.side.inside ? 1 : 0;
      } else {
        here.side = last[from].side;
        here.looked_up = last[from].looked_up;
      }
      here.known = true;
      at = from;
      last[at] = here;
    } else {
      here.side = shell_side(work.grid, work.tree, here.at, likely);
    }
    out.inside[i] = here.side.inside;
    out.certain[i] = here.side.certain && here.distance > on_surface;
  }
}

void tell_by_shell(const TriangleTree& tree, std::span<const double> points, const NearestTriangles& nearest,
                   const CancelToken& cancel, PointSides& out) {
  const ShellGrid grid = build_shell_grid(tree);
  std::vector<std::uint32_t> position(tree.count());
  for (std::uint32_t p = 0; p < position.size(); ++p) position[tree.order[p]] = p;
  const ShellWork work{grid, tree, position, points, nearest};
  parallel_blocks(nearest.distance.size(), side_block, [&](std::size_t begin, std::size_t end) {
    cancel.check();
    walk(work, begin, end, out);
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

std::optional<SignRule> chosen_rule(SignChoice choice, const PreparedMesh& mesh, const TriangleTree& tree,
                                    const OrientedSurface& oriented) {
  switch (choice) {
    case SignChoice::automatic:
      return sign_rule(mesh, tree, oriented);
    case SignChoice::closed:
      return oriented.all_closed() ? std::optional(SignRule::closed) : std::nullopt;
    case SignChoice::winding:
      return SignRule::winding;
    case SignChoice::shell:
      return SignRule::shell;
    case SignChoice::none:
      break;
  }
  return SignRule::none;
}

PointSides point_sides(const TriangleTree& tree, const OrientedSurface& oriented, SignRule rule,
                       std::span<const double> points, const NearestTriangles& nearest,
                       const CancelToken& cancel) {
  const std::size_t count = points.size() / 3;
  if (nearest.distance.size() != count || nearest.triangle.size() != count || points.size() % 3 != 0)
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

LabeledPoints label_points(const TriangleTree& tree, const OrientedSurface& oriented, SignRule rule,
                           std::span<const double> points, const CancelToken& cancel) {
  const CurvePoints along = along_curve(points);
  LabeledPoints labels;
  labels.nearest = nearest_triangles(tree, along.points, cancel);
  labels.sides = point_sides(tree, oriented, rule, along.points, labels.nearest, cancel);
  labels.nearest.distance = along.as_given(labels.nearest.distance);
  labels.nearest.triangle = along.as_given(labels.nearest.triangle);
  labels.nearest.weights = along.as_given(labels.nearest.weights, 2);
  labels.sides.inside = along.as_given(labels.sides.inside);
  labels.sides.certain = along.as_given(labels.sides.certain);
  labels.sides.winding = along.as_given(labels.sides.winding);
  return labels;
}

}  // namespace meander
