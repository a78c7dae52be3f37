// Discrepancy in the plane under a constant spacing tensor (Quinn et al. 2013, figure 15;
// docs/METHODS.md 13.2): shapes are round, square and so on in the metric.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "kernels/analyse/discrepancy_shapes.h"
#include "kernels/tensor/tangent_tensor.h"

namespace meander {

// The domain that the points fill: origin + s a + t b, 0 <= s, t <= 1.
struct Parallelogram {
  std::array<double, 2> origin{0, 0}, a{1, 0}, b{0, 1};
};

struct AnisotropicDiscrepancyParameters {
  ShapeParameters shapes;  // of every window and every kind; the same shapes in all windows
  // 1: in the middle of the domain; more: at random anywhere in it; 1..4096. One is used if the window cannot
  // move (ratio 1 in a square).
  std::uint32_t windows = 1;
  Parallelogram domain;  // not flat
};

// Means over the windows.
struct AnisotropicDiscrepancy {
  double disks = 0, boxes = 0, triangles = 0;
  double points = 0;          // in a window: errors are to be compared, and slopes fitted, over this number
  double window_share = 0;    // of the domain
  std::uint32_t windows = 0;  // that held points; the others do not count
  double windows_stable = 0;  // share of (window, kind) with a maximum that ShapeParameters calls stable
};

// N points (x, y) in the domain. HOW THE BORDER IS TREATED: all is measured in a window, the largest disk of
// the METRIC (an ellipse of the domain, axes in the ratio s1 : s2) that fits into the domain, pulled back by
// S^-1 to a disk. Shapes lie inside the window, so nothing is clipped and their share of the window's area is
// exact; the error is |points in the shape / points in the window - share|. Hence the law of the result
// depends on the number of points in the window alone: neither on the tensor nor on the form of the domain.
// Ratio 1 is one case of it, and random points, or strata that are alike in the metric, give the same
// constant for every ratio. (Shapes cut by the border of the domain, as metric_box_discrepancy has them, do
// not: a square seen through a metric of ratio 8 is a strip, whose shapes cut fewer strata.) What happens
// within a spacing of the domain's border is not measured. The window takes pi / 4 of a square at ratio 1 and
// pi / (4 ratio) of it along an axis; more windows make up for that.
// Kinds, uniform in the unit disk: disks (center uniform in the disk, radius uniform up to the rim); boxes
// (any angle, center uniform, half-sides uniform in [0, 1], drawn again until all corners are inside);
// triangles (three uniform corners). `log_spacing` is log S of the constant tensor, its scale is immaterial.
// About 0.1 us x sqrt(points in the window) a shape. Deterministic for every thread count. Throws
// std::invalid_argument when lengths differ or are zero, a number is not finite, the domain is flat, or a
// parameter is out of range.
AnisotropicDiscrepancy anisotropic_discrepancy(std::span<const double> x, std::span<const double> y,
                                               TangentTensor log_spacing,
                                               const AnisotropicDiscrepancyParameters& parameters = {});

}  // namespace meander
