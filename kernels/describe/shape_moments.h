// Area, volume, moments and bounding box of a triangle mesh, exact integrals over the surface.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "kernels/core/vector3.h"

namespace meander {

struct ShapeMoments {
  std::array<double, 6> bbox{};  // min x, y, z, max x, y, z of the triangles' corners
  double area = 0;
  Vector3 centroid;  // of the surface
  // xx, yy, zz, xy, xz, yz of the inertia tensor of the surface (mass = area) about its centroid.
  std::array<double, 6> inertia{};
  std::array<double, 3> principal_moments{};  // eigenvalues of `inertia`, ascending
  // Their unit vectors: right-handed, with a positive largest component in the first two; arbitrary where
  // moments are equal.
  std::array<Vector3, 3> principal_axes;
  double volume = 0;        // enclosed, negative when inside out; NaN unless closed
  Vector3 volume_centroid;  // of the solid; NaN unless closed and volume != 0
  bool closed = false;      // every half-edge has its opposite: closed and consistently oriented
};

// x, y, z: V finite positions; triangles: 3 T vertex indices (vertices at one position must have one index,
// or the mesh counts as open). Moments of surfaces: the quadratic form of a triangle's corners (Messner and
// Taylor 1980, "Algorithm 550: solid polyhedron measures"); volumes: sums of tetrahedra from the center of
// the box. Triangles without area contribute nothing. O(T log T); the same bytes for every thread count.
// Throws ItemError(zero_area) when there is no area.
ShapeMoments shape_moments(std::span<const double> x, std::span<const double> y, std::span<const double> z,
                           std::span<const std::uint32_t> triangles);

// The basics as a descriptor, independent of scale: d is the diagonal of the bounding box; lengths are
// divided by d, areas by d^2, moments by area x d^2. Rotations of the model change the box and the offsets.
// NaN where the mesh is not closed.
inline constexpr std::size_t shape_basics_count = 16;
inline constexpr std::array<std::string_view, shape_basics_count> shape_basics_names = {
    "area",               // area / d^2
    "volume",             // volume / d^3
    "compactness",        // 36 pi volume^2 / area^3: 1 for a sphere
    "box_x",              // sides of the bounding box / d: x, y, z
    "box_y",              //
    "box_z",              //
    "centroid_x",         // (surface centroid - box center) / d: x, y, z
    "centroid_y",         //
    "centroid_z",         //
    "volume_centroid_x",  // (volume centroid - box center) / d: x, y, z
    "volume_centroid_y",  //
    "volume_centroid_z",  //
    "principal_1",        // principal moments, ascending, / (area d^2)
    "principal_2",        //
    "principal_3",        //
    "radius"};            // root mean square distance of the surface from its centroid / d
std::array<double, shape_basics_count> shape_basics(const ShapeMoments& moments);

}  // namespace meander
