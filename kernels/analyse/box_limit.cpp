#include "kernels/analyse/box_limit.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "kernels/analyse/box_triangles.h"
#include "kernels/analyse/rotated_box_search.h"
#include "kernels/core/parallel.h"

namespace meander {

namespace {

using Corner = std::array<double, 3>;  // coordinates in the frame of a box

// The length of the part of a segment within |coordinate[k]| <= half[k] for the axes other than `axis`
// (Liang and Barsky 1984).
double length_within(const Corner& from, const Corner& to, std::size_t axis,
                     const std::array<double, 3>& half) {
  double begin = 0, end = 1, squared = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    if (k == axis) continue;
    const double step = to[k] - from[k];
    squared += step * step;
    if (step == 0) {
      if (std::abs(from[k]) > half[k]) return 0;
      continue;
    }
    const double a = (-half[k] - from[k]) / step, b = (half[k] - from[k]) / step;
    begin = std::max(begin, std::min(a, b));
    end = std::min(end, std::max(a, b));
  }
  return begin < end ? (end - begin) * std::sqrt(squared) : 0;
}

// The length that one face has on a triangle, that of sign * coordinate[axis] = half[axis].
double length_on_face(const std::array<Corner, 3>& corners, std::size_t axis, double sign,
                      const std::array<double, 3>& half) {
  std::array<double, 3> beyond;  // the distance to the plane of the face, on its outer side positive
  for (std::size_t i = 0; i < 3; ++i) beyond[i] = sign * corners[i][axis] - half[axis];
  std::array<Corner, 2> ends{};
  std::size_t found = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3;
    if ((beyond[i] > 0) == (beyond[j] > 0)) continue;
    // From the inner corner, so that both triangles at an edge find one point.
    const std::size_t in = beyond[i] > 0 ? j : i, out = beyond[i] > 0 ? i : j;
    const double t = beyond[in] / (beyond[in] - beyond[out]);
    for (std::size_t k = 0; k < 3; ++k)
      ends[found][k] = corners[in][k] + t * (corners[out][k] - corners[in][k]);
    ++found;  // none or two of the three edges cross
  }
  return found == 2 ? length_within(ends[0], ends[1], axis, half) : 0;
}

// The length that all faces have on a triangle.
double length_on_faces(const std::array<Corner, 3>& corners, const std::array<double, 3>& half) {
  std::array<double, 3> low{}, high{};
  for (std::size_t k = 0; k < 3; ++k) {
    low[k] = std::min({corners[0][k], corners[1][k], corners[2][k]});
    high[k] = std::max({corners[0][k], corners[1][k], corners[2][k]});
    if (low[k] > half[k] || high[k] < -half[k]) return 0;  // most triangles near a box lie beyond one face
  }
  double length = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (low[axis] <= half[axis] && high[axis] > half[axis]) length += length_on_face(corners, axis, 1, half);
    if (high[axis] >= -half[axis] && low[axis] < -half[axis])
      length += length_on_face(corners, axis, -1, half);
  }
  return length;
}

double boundary_length(const BoxTriangles& triangles, const RotatedBox& box) {
  double length = 0;
  visit_box(
      triangles.tree, box, [](std::size_t, std::size_t) {},
      [&](std::size_t begin, std::size_t end) {
        for (std::size_t p = begin; p < end; ++p)
          length += length_on_faces({to_box(box, triangles.corner(p, 0)), to_box(box, triangles.corner(p, 1)),
                                     to_box(box, triangles.corner(p, 2))},
                                    box.half);
      });
  return length;
}

std::vector<double> boundary_lengths(const BoxTriangles& triangles, std::span<const RotatedBox> boxes) {
  std::vector<double> lengths(boxes.size());
  parallel_tasks(boxes.size(), [&](std::size_t i) { lengths[i] = boundary_length(triangles, boxes[i]); });
  return lengths;
}

}  // namespace

std::vector<double> boundary_lengths(std::span<const double> x, std::span<const double> y,
                                     std::span<const double> z, std::span<const std::uint32_t> triangles,
                                     std::span<const RotatedBox> boxes) {
  return boundary_lengths(build_box_triangles(x, y, z, triangles), boxes);
}

double relative_boundary(std::span<const double> x, std::span<const double> y, std::span<const double> z,
                         std::span<const std::uint32_t> triangles, std::span<const RotatedBox> boxes) {
  const BoxTriangles surface = build_box_triangles(x, y, z, triangles);
  std::vector<double> areas(surface.count()), variances(boxes.size());
  for (std::size_t p = 0; p < surface.count(); ++p)
    areas[p] = triangle_area(surface.corner(p, 0), surface.corner(p, 1), surface.corner(p, 2));
  for (std::size_t i = 0; i < boxes.size(); ++i) variances[i] = boxes[i].share * (1 - boxes[i].share);
  const double variance = blocked_sum(variances);
  // The number of boxes cancels.
  return variance > 0
             ? blocked_sum(boundary_lengths(surface, boxes)) / (std::sqrt(blocked_sum(areas)) * variance)
             : 0;
}

double box_error_limit(double relative_boundary, std::uint64_t n, double k) {
  return std::sqrt(k * relative_boundary / std::sqrt(static_cast<double>(n)));
}

}  // namespace meander
