// Generalized discrepancies in the unit square (docs/METHODS.md 13.2): quarter circles exactly; triangles,
// rotated boxes, boxes under a density and rectangles in a metric over random shapes.
#pragma once

#include <array>
#include <span>

#include "kernels/analyse/discrepancy_shapes.h"
#include "kernels/analyse/planar_density.h"
#include "kernels/analyse/point_index.h"

namespace meander {

// All: N points in [0, 1)^2, at least one (else std::invalid_argument); deterministic for every thread count.

// sup over 0 < r <= 1 of |#{|p| <= r}/N - pi r^2/4|, quarters of disks about the origin. Exact. O(N log N).
double quarter_circle_discrepancy(std::span<const double> x, std::span<const double> y);

// The functions below take the points from build_point_index(x, y), so that one index serves several.
// O(sqrt(N)) per shape.

// Triangles with a corner at the origin and two uniformly random ones in the square.
ShapeDiscrepancy triangle_discrepancy(const PointIndex<2>& points, const ShapeParameters& parameters = {});

// Rectangles turned by a uniform angle, center uniform in the square, half-sides uniform in [0, 1/2], cut by
// the square.
ShapeDiscrepancy rotated_box_discrepancy(const PointIndex<2>& points, const ShapeParameters& parameters = {});

// Boxes [0, a] x [0, b] with uniform a, b; the points should follow the density. Error of the measure 1e-13.
ShapeDiscrepancy density_box_discrepancy(const PointIndex<2>& points, PlanarDensity density,
                                         const ShapeParameters& parameters = {});

// A constant metric: |d|^2 = g[0] dx^2 + 2 g[1] dx dy + g[2] dy^2, positive definite (else
// std::invalid_argument). Its scale does not matter.
using PlanarMetric = std::array<double, 3>;
// Rectangles along the principal axes of the metric, center uniform in the square, half-sides uniform in
// [0, 1/2] in the metric of determinant 1, cut by the square: squares of the metric are long in the square.
ShapeDiscrepancy metric_box_discrepancy(const PointIndex<2>& points, const PlanarMetric& metric,
                                        const ShapeParameters& parameters = {});

}  // namespace meander
