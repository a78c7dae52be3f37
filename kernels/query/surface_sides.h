// On which side of a surface points lie, and whether that is certain.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "kernels/core/cancel.h"
#include "kernels/core/words.h"
#include "kernels/data/sign_rule.h"
#include "kernels/query/boundary_field.h"
#include "kernels/query/curve_order.h"
#include "kernels/query/nearest_triangle.h"
#include "kernels/query/open_holes.h"
#include "kernels/query/oriented_surface.h"
#include "kernels/query/shell_grid.h"
#include "kernels/query/triangle_tree.h"
#include "kernels/query/winding_number.h"

namespace meander {

// How sides are told (SignRule). Closed: every component is closed, inside is where the winding number, a
// whole number, is not 0. Winding: the surface is nearly closed; inside is where the generalized winding
// number is at least one half. Shell: outside is what a grid is flooded by from outside of the surface,
// whatever its triangles are; gaps narrower than a cell, 1/124 of the longest side, are closed. None: points
// have no side.

// What users ask for: a rule, or the first of closed, winding and shell that fits the surface.
enum class SignChoice : std::uint8_t { automatic, closed, winding, shell, none };
inline constexpr Word<SignChoice> sign_choice_words[] = {{"auto", SignChoice::automatic},
                                                         {"closed", SignChoice::closed},
                                                         {"winding", SignChoice::winding},
                                                         {"shell", SignChoice::shell},
                                                         {"none", SignChoice::none}};

// By the rule `winding`, sides within this of the threshold, one half, are uncertain: above and below a hole
// the winding number is fractional, and what is missing may lie on either side of the point.
inline constexpr double uncertain_winding = 0.35;
// Surfaces are nearly closed where the winding number beside this share of their area, at least, is within
// one fifth of a whole number: 0 outside of a closed surface and 1 inside of it, one half on both sides of a
// sheet.
inline constexpr double nearly_closed_share = 0.9;

// Of n points.
struct PointSides {
  SignRule rule = SignRule::none;
  std::vector<std::uint8_t> inside;   // n: 0 or 1; 0 where the rule is none
  std::vector<std::uint8_t> certain;  // n: 0 or 1
  std::vector<double> winding;  // n: whole numbers by the rule closed; empty by the rules shell and none
  std::uint64_t uncertain = 0;  // how many are not certain
};

// The share of nearly_closed_share, from 512 places spread over the area. 0 without area.
double nearly_closed_area(const PreparedMesh& mesh, const TriangleTree& tree,
                          const OrientedSurface& oriented);

// The rule for a surface: closed, winding or, for all others, shell; shell also where it is not known which
// components lie in which.
SignRule sign_rule(const PreparedMesh& mesh, const TriangleTree& tree, const OrientedSurface& oriented);
// The rule that was asked for; nullopt where that is `closed` and the surface is not.
std::optional<SignRule> chosen_rule(SignChoice choice, const PreparedMesh& mesh, const TriangleTree& tree,
                                    const OrientedSurface& oriented);

// Tells the sides of 3 n coordinates in those of the mesh. tree: that of the mesh; nearest: what
// nearest_triangles says of the points. |w| counts, so that a solid that is wound inward has an inside too.
//
// Points should follow each other as neighbors do (along_curve). Closed:
// the winding number of the first of 512 points comes from all triangles (WindingTree), those of the others
// by steps: where a ball without surface holds two points they have the same, and elsewhere the crossings
// between them are counted (SegmentCrossings), or, where rounding would decide, triangles again. A point is
// uncertain that is closer to the surface than double can tell. Winding: winding numbers are those of a point
// before, less the crossings between, plus what the open edges make of the way (winding_change), where their
// field is even enough; and those of all triangles elsewhere, strictly within an error of 0.02 near the
// threshold, to which the way adds 0.02. Far from it they err by 0.01, and 0.1 at most, on real models.
// Uncertain within uncertain_winding of the threshold; where the nearest point lies on an open edge, unless
// the number is within 0.03 of a whole one, or above 1; and where several holes are near, unless they agree
// (OpenHoles). Shell: see shell_side; points of cells of the surface have the side of a point up to a cell
// away, if a way from point to point leads there past all triangles.
//
// Parallel; the same for every thread count. Throws
// std::invalid_argument for the rule closed where the surface is not, and for arrays that do not fit; timeout
// / RunCanceled from `cancel`. 0.1 to 0.3 us a point by the rule closed, 0.2 to 2 by the others.
PointSides point_sides(const TriangleTree& tree, const OrientedSurface& oriented, SignRule rule,
                       std::span<const double> points, const NearestTriangles& nearest,
                       const CancelToken& cancel = {});

// Nearest triangles and sides of n points.
struct LabeledPoints {
  NearestTriangles nearest;
  PointSides sides;
};

// Nearest triangles and sides of 3 n coordinates in any order, which are taken along a curve; errors as
// above.
LabeledPoints label_points(const TriangleTree& tree, const OrientedSurface& oriented, SignRule rule,
                           std::span<const double> points, const CancelToken& cancel = {});

// Upper bound of the bytes that sides take by any rule beside the points, what is known of them, the tree and
// the orientation.
constexpr double point_sides_bytes(double triangles, double points) {
  constexpr double bytes_per_point = 10;
  return points * bytes_per_point + winding_tree_bytes(triangles) + boundary_field_bytes(3 * triangles) +
         open_holes_bytes(triangles) + shell_grid_bytes();
}
constexpr double label_points_bytes(double triangles, double points) {
  // Points along the curve, and one array twice, of 2 doubles a point.
  return points * (curve_points_bytes + 16) + nearest_triangles_bytes(points) +
         point_sides_bytes(triangles, points);
}

}  // namespace meander
