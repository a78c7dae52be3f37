// Samples lifted from the chords of a mesh to the smooth surface that its vertex normals describe
// (docs/METHODS.md 11).
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "kernels/core/vector3.h"

namespace meander {

struct CurvedSampleParameters {
  double crease_degrees = 40;  // 0..180: normals are split at edges with a larger dihedral angle
  double lift_limit = 0.25;    // 0..1: |offset| is at most this share of the triangle's longest edge
};

// Unit normal of every corner of every triangle: 9 T numbers, corner 3 t + k at 9 t + 3 k. Corners at a
// vertex share a normal when smooth edges connect their triangles: edges of exactly two triangles that agree
// in orientation and whose normals differ by at most crease_degrees. Weights of Max 1999 ("Weights for
// computing vertex normals from facet normals"), exact on spheres. Zero vectors at corners whose triangles
// have no area. x, y, z: V finite positions; triangles: 3 T vertex numbers; vertices at one position need one
// number to share normals. O(T log T), 100 to 170 ns a triangle; deterministic. Throws std::invalid_argument
// for parameters out of range.
std::vector<double> crease_normals(std::span<const double> x, std::span<const double> y,
                                   std::span<const double> z, std::span<const std::uint32_t> triangles,
                                   const CurvedSampleParameters& parameters = {});

// Offset of the smooth surface from the triangle's plane at weights b, along the interpolated normal:
// 1/2 sum_{i<j} b_i b_j (n_j - n_i).(x_j - x_i), positive to the outside of convex parts, clamped to
// lift_limit times the longest edge. Error O(h^4) on smooth surfaces with exact
// normals; O(h^3) was seen on a torus with those of crease_normals.
double curved_offset(const std::array<Vector3, 3>& corners, const std::array<Vector3, 3>& normals,
                     const std::array<double, 3>& weights, double lift_limit = 0.25);

// The lifted points, 3 n numbers. triangle: n triangle numbers; barycentric: 2 n weights of corners 1 and 2
// of that triangle; normals: 9 T of crease_normals. A point whose interpolated normal is zero stays where it
// is. 30 ns a point in cache, 120 in random order on large meshes; parallel. Throws std::invalid_argument
// when lengths do not fit.
std::vector<double> lift_samples(std::span<const double> x, std::span<const double> y,
                                 std::span<const double> z, std::span<const std::uint32_t> triangles,
                                 std::span<const double> normals, std::span<const std::uint32_t> triangle,
                                 std::span<const float> barycentric,
                                 const CurvedSampleParameters& parameters = {});

// Upper bound of the bytes of crease normals, their edges and sums.
constexpr double lift_bytes(double triangles) {
  constexpr double bytes_per_triangle = 270;
  return triangles * bytes_per_triangle;
}

}  // namespace meander
