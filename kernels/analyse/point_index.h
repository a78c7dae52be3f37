// Points of the plane or of space along the Hilbert curve under a tree of bounding boxes, to count those
// inside convex shapes in time of the points near the shape's boundary.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace meander {

// normal . p <= offset; the normal is a unit vector.
template <std::size_t D>
struct HalfSpace {
  std::array<double, D> normal{};
  double offset = 0;
};

template <std::size_t D>
bool contains(const HalfSpace<D>& half_space, const std::array<double, D>& p) {
  double along = half_space.normal[0] * p[0];
  for (std::size_t k = 1; k < D; ++k) along += half_space.normal[k] * p[k];
  return along <= half_space.offset;
}

template <std::size_t D>
struct PointIndex {
  static constexpr std::size_t leaf = 16;
  static constexpr std::size_t fan = 4;
  std::array<std::vector<double>, D> at;  // the coordinates, sorted along the curve
  // Level 0 has one node per `leaf` points, each higher level one per `fan` nodes below. A node is 2 D
  // doubles: center and half-extent of the box around its points.
  std::vector<std::vector<double>> levels;

  std::size_t count() const { return at[0].size(); }
};

// Finite coordinates in [-1, 1] (2-D: [0, 1]); those outside are allowed but cost speed. O(n), 60 ns a point;
// 19 (2-D) or 28 (3-D) bytes a point, twice that while building. Deterministic. Throws std::invalid_argument
// when lengths differ.
PointIndex<2> build_point_index(std::span<const double> x, std::span<const double> y);
PointIndex<3> build_point_index(std::span<const double> x, std::span<const double> y,
                                std::span<const double> z);

// Points inside all half-spaces (at most 8), the same number as a loop over `contains`. O(points near the
// faces of the shape): about 0.1 us x sqrt(n) for a shape of average size in the plane.
std::size_t count_inside(const PointIndex<2>& points, std::span<const HalfSpace<2>> shape);
std::size_t count_inside(const PointIndex<3>& points, std::span<const HalfSpace<3>> shape);

// Points of the plane at most `radius` from the center: those with dx * dx + dy * dy <= radius * radius.
std::size_t count_in_disk(const PointIndex<2>& points, const std::array<double, 2>& center, double radius);

}  // namespace meander
