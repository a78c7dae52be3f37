// Error of a point set against the exact area of random rotated boxes (docs/METHODS.md 13.1; the
// headline measure).
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "kernels/core/vector3.h"

namespace meander {

// A rotated box: |axis_k . (p - center)| <= half[k]; the axes are orthonormal.
struct RotatedBox {
  Vector3 center;
  std::array<Vector3, 3> axes;
  std::array<double, 3> half{};
  double share = 0;  // of the surface's measure inside the box, exact
};

struct BoxParameters {
  std::uint32_t boxes = 1000;
  std::uint64_t seed = 1;
  double half_size_min = 0.03, half_size_span = 0.32;  // half-sizes: diagonal x (min + span u)
  double share_min = 0.002, share_max = 0.6;           // other boxes are drawn again
};

// Exact area of the part of the triangles inside the box (each triangle clipped against the six planes, in
// double). x, y, z: V positions; triangles: 3 T vertex numbers. O(T), parallel in fixed blocks. Triangles of
// no area contribute nothing. Positions must be finite.
double area_in_box(std::span<const double> x, std::span<const double> y, std::span<const double> z,
                   std::span<const std::uint32_t> triangles, const RotatedBox& box);

// Random test boxes on a surface: center an area-random surface point moved by a uniform offset within half a
// half-size along each box axis, uniform rotation (Shoemake 1992, "Uniform random rotations"), half-sizes as
// in the parameters (the diagonal is that of the box around all used vertices), kept when the exact share
// lies in [share_min, share_max]. Pure in the seed: box i is a function of (surface, seed, i), so that fewer
// boxes are a prefix of more. A box whose every draw of 1000 is refused is left out: fewer boxes than asked,
// perhaps none, come back for surfaces that hardly have such boxes (all area in one spot). O(T log T) once,
// then O(triangles across the faces of the box) a draw. Throws ItemError(zero_area) when there is no area.
std::vector<RotatedBox> random_boxes(std::span<const double> x, std::span<const double> y,
                                     std::span<const double> z, std::span<const std::uint32_t> triangles,
                                     const BoxParameters& parameters);

// points: 3 n coordinates, finite, in the units of the boxes, in any order. Returns count/n - share of every
// box. Points on a face of a box are inside. O(n log n) once, then O(points near the faces of the box) a box.
// Deterministic for every thread count. Throws std::invalid_argument without points or boxes.
std::vector<double> box_errors(std::span<const RotatedBox> boxes, std::span<const double> points);

// The root mean square of those errors over its Monte Carlo value sqrt(mean p (1 - p) / n): 1 for random
// points (root mean square over many sets), smaller is better. Cost and errors as above.
double box_error_ratio(std::span<const RotatedBox> boxes, std::span<const double> points);

// How far a sampler is from unbiased: add the box_errors of many independent sets of equal size over the same
// boxes.
class BoxBias {
 public:
  // Throws std::invalid_argument when the number of boxes changes.
  void add(std::span<const double> errors);
  // Root mean square over boxes of the mean error, over that of the error of one set; the remaining
  // variance of the mean is subtracted, so that an unbiased sampler has about 0 (with few sets some
  // 1/sqrt(sets) times the fourth root of 2/boxes). At least two sets.
  double ratio() const;

 private:
  double sets_ = 0;
  std::vector<double> sum_, squares_;
};

}  // namespace meander
