// Power spectra of a point set on concentric shells (Kazhdan, Funkhouser and Rusinkiewicz 2003, "Rotation
// invariant spherical harmonic representation of 3D shape descriptors").
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "kernels/core/cancel.h"
#include "kernels/core/vector3.h"

namespace meander {

inline constexpr std::uint32_t harmonic_shells = 8, highest_harmonic_degree = 16;
inline constexpr std::uint32_t shell_harmonic_values = harmonic_shells * (highest_harmonic_degree + 1);
inline constexpr double harmonic_range = 2.5;  // radius of the last shell over the mean distance

// The real spherical harmonics of degrees 0 to `degree`, orthonormal on the unit sphere, at a direction of
// length 1; the one of degree l and order m, -l <= m <= l, at l (l + 1) + m. Orders below 0 have sin |m| phi.
// No trigonometric function: the same bits on every processor. O(degree^2).
std::vector<double> spherical_harmonics(Vector3 direction, std::uint32_t degree);

// Norms of spherical harmonics on shells. points: 3 n coordinates, finite, n >= 1, each of mass 1 / n. Shell
// s = 1 .. harmonic_shells has the radius s / harmonic_shells x harmonic_range x the mean distance of the
// points from their centroid. A point belongs to the two shells next to it, with weights linear in its
// radius; below the first shell its weight falls to 0 at the centroid, where it has no direction; beyond the
// last shell it counts there. Value (s - 1) x (highest_harmonic_degree + 1) + l is the norm of the shell's
// part of degree l,
//
//   sqrt(4 pi sum over m of (sum over the points of weight / n x Y_lm)^2),
//
// the mass of the shell for l = 0, and at most sqrt(2 l + 1) times that mass for others. The values change
// neither with position, direction or size of the whole nor with a reflection, except for rounding, and
// continuously with every point. Points that all coincide have their whole mass in degree 0 of the first
// shell and 0 elsewhere.
//
// Independent points of a uniform density have values near sqrt((2 l + 1) mass / n), not 0. O(n degree^2);
// bench/describe_bench.cpp measures it. Serial, in the order of the points. Throws std::invalid_argument for
// lengths that are not 3 n or numbers that are not finite; RunCanceled and ItemError(timeout) from `cancel`.
std::vector<float> shell_harmonics(std::span<const float> points, const CancelToken& cancel = {});

}  // namespace meander
