// How small the error over rotated boxes can be on a surface (docs/METHODS.md 13.1).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "kernels/analyse/box_discrepancy.h"

namespace meander {

// The variance of the number of points in a window, over its position and rotation, is K L sqrt(n / A) where
// n points of even density lie on a surface of area A, L is the length of the window's boundary on it, and
// the window is large against the distance of points. No set has a lower rate (Beck 1987, "Irregularities of
// distribution I"). K depends on the set alone; of a lattice it is the sum of |q|^-3 over the dual lattice,
// in periods over the spacing sqrt(A / n), over 4 pi^3. That of the triangular lattice is the least of all
// lattices, and by conjecture of all sets (Torquato and Stillinger 2003, "Local density fluctuations,
// hyperuniformity, and order metrics").
inline constexpr double triangular_lattice_variance = 0.071701168702782;  // K

// The length on the surface of the boundary of each box, exact: every triangle is cut by the plane of every
// face, and the segment is clipped to the face (in double). x, y, z: V finite positions; triangles: 3 T
// vertex numbers. A triangle within the plane of a face counts as inside of the box, as in box_errors.
// Borders of the surface do not count. O(T log T) once, then O(triangles across the faces) a box; parallel
// over boxes, the same bits for every number of threads.
std::vector<double> boundary_lengths(std::span<const double> x, std::span<const double> y,
                                     std::span<const double> z, std::span<const std::uint32_t> triangles,
                                     std::span<const RotatedBox> boxes);

// G = mean(L) / (sqrt(A) mean(p (1 - p))) over the boxes, p their shares as random_boxes sets them: the
// relative boundary of the boxes, 11 to 15 for random_boxes on most models. 0 without boxes of a share in
// (0, 1). Cost as boundary_lengths.
double relative_boundary(std::span<const double> x, std::span<const double> y, std::span<const double> z,
                         std::span<const std::uint32_t> triangles, std::span<const RotatedBox> boxes);

// The box_error_ratio, root mean square over rotations and positions, of n >= 1 points with that K:
// sqrt(K G / sqrt(n)). With K of the triangular lattice it is the limit that no set is known to pass. It
// takes the surface for smooth on the scale of the spacing sqrt(A / n): sheets nearer to each other than
// that, or parts smaller than it, can do better or worse, as can single sets by chance.
double box_error_limit(double relative_boundary, std::uint64_t n, double k = triangular_lattice_variance);

}  // namespace meander
