// A tensor-product B-spline or NURBS patch (Piegl and Tiller 1997, "The NURBS book", chapters 2 to 4).
#pragma once

#include <memory>
#include <string_view>
#include <vector>

#include "kernels/surface/surface.h"

namespace meander {

// The control net, as flat arrays. With n_u x n_v control points: knots_u has n_u + degree_u + 1 entries,
// ascending, likewise v. The surface runs over [knots_u[degree_u], knots_u[n_u]] x the same of v, scaled to
// the unit square. Units are those of the control points.
struct NurbsNet {
  int degree_u = 0, degree_v = 0;  // 1..max_nurbs_degree
  std::vector<double> knots_u, knots_v;
  std::vector<double> points;   // 3 n_u n_v coordinates, v varies fastest
  std::vector<double> weights;  // n_u n_v, > 0; empty: all 1 (a B-spline)
};
inline constexpr int max_nurbs_degree = 15;

// Throws ItemError(unreadable), with all problems in one sentence, when the net is inconsistent.
std::unique_ptr<ParametricSurface> make_nurbs_patch(NurbsNet net);

// Reads a net from text, one statement a line. Blank lines are skipped, and so is the rest of a line after #.
//
//   degree  DU DV                 once, first
//   knots_u T T T ...             ascending; the line may be repeated, the values are appended
//   knots_v T T T ...
//   point   X Y Z [W]             (knots_u - DU - 1)(knots_v - DV - 1) lines, v fastest; W defaults to 1
//
// Throws ItemError(unreadable) with the number of the line. O(bytes).
NurbsNet parse_nurbs_net(std::string_view text);
std::unique_ptr<ParametricSurface> parse_nurbs_patch(std::string_view text);

}  // namespace meander
