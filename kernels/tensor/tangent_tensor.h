// Symmetric 2 x 2 tensors in a tangent plane, and the conventions of anisotropic sampling, fixed here once
// (docs/METHODS.md 9.1).
//
// SPACING FORM: S = s1 e1 e1^T + s2 e2 e2^T, s1 >= s2 > 0: the wanted distances between samples along the
// primary direction e1 (the long one; strokes follow it) and across it. Only ratios matter: the sampler
// scales the field to the number of samples. METRIC FORM: G = S^-2: the length of a step w, counted in
// spacings, is sqrt(w^T G w). Samples per area: sqrt(det G) = 1 / (s1 s2). Fields are kept as L = log S,
// which is linear: averages and interpolations of L (log-Euclidean, Arsigny et al. 2006) stay positive
// definite.
#pragma once

#include <cmath>

#include "kernels/core/portable_functions.h"
#include "kernels/core/vector3.h"

namespace meander {

// Components xx, xy, yy in some orthonormal frame of a tangent plane.
struct TangentTensor {
  double xx = 0, xy = 0, yy = 0;
};
constexpr TangentTensor operator+(TangentTensor a, TangentTensor b) {
  return {a.xx + b.xx, a.xy + b.xy, a.yy + b.yy};
}
constexpr TangentTensor operator*(double s, TangentTensor a) { return {s * a.xx, s * a.xy, s * a.yy}; }
constexpr double trace(TangentTensor a) { return a.xx + a.yy; }
constexpr double determinant(TangentTensor a) { return a.xx * a.yy - a.xy * a.xy; }
// w^T A w.
constexpr double quadratic(TangentTensor a, double x, double y) {
  return a.xx * x * x + 2 * a.xy * x * y + a.yy * y * y;
}

// Eigenvalues first >= second and the unit eigenvector of the first; its sign is that of x > 0, or y > 0
// where x is 0. Isotropic tensors give (1, 0).
struct TensorAxes {
  double first = 0, second = 0;
  double x = 1, y = 0;
};
inline TensorAxes tensor_axes(TangentTensor a) {
  const double half = 0.5 * (a.xx - a.yy), radius = portable::hypot(half, a.xy), middle = 0.5 * (a.xx + a.yy);
  TensorAxes axes{middle + radius, middle - radius, 1, 0};
  if (!(radius > 0)) return axes;
  // The larger of cos and sin of half the angle of (half, xy) comes first: no trigonometry, no cancellation.
  const double c = half / radius, s = a.xy / radius;
  if (c >= 0) {
    axes.x = std::sqrt(0.5 * (1 + c));
    axes.y = 0.5 * s / axes.x;
  } else {
    axes.y = std::copysign(std::sqrt(0.5 * (1 - c)), s);
    axes.x = 0.5 * s / axes.y;
    if (!(axes.x > 0)) axes = {axes.first, axes.second, 0, 1};
  }
  return axes;
}
inline TangentTensor tensor_of(TensorAxes axes) {
  const double xx = axes.x * axes.x, xy = axes.x * axes.y, yy = axes.y * axes.y;
  return {axes.first * xx + axes.second * yy, (axes.first - axes.second) * xy,
          axes.first * yy + axes.second * xx};
}

// f(A) by eigenvalues: exp, log (of positive definite tensors), powers.
template <class Function>
TangentTensor apply(TangentTensor a, Function function) {
  TensorAxes axes = tensor_axes(a);
  axes.first = function(axes.first);
  axes.second = function(axes.second);
  return tensor_of(axes);
}
inline TangentTensor exponential(TangentTensor a) {
  return apply(a, [](double v) { return portable::exp(v); });
}
inline TangentTensor logarithm(TangentTensor a) {
  return apply(a, [](double v) { return portable::log(v); });
}

// The two spacings with the primary direction, and the metric G, from log S.
inline TensorAxes spacings_of(TangentTensor log_spacing) {
  TensorAxes axes = tensor_axes(log_spacing);
  axes.first = portable::exp(axes.first);
  axes.second = portable::exp(axes.second);
  return axes;
}
inline TangentTensor metric_of(TangentTensor log_spacing) { return exponential(-2.0 * log_spacing); }

// The components in a frame that is rotated by the angle with the given cosine and sine (new x axis = cosine
// x + sine y).
constexpr TangentTensor in_turned_frame(TangentTensor a, double cosine, double sine) {
  const double cc = cosine * cosine, ss = sine * sine, cs = cosine * sine;
  return {cc * a.xx + 2 * cs * a.xy + ss * a.yy, cs * (a.yy - a.xx) + (cc - ss) * a.xy,
          ss * a.xx - 2 * cs * a.xy + cc * a.yy};
}

// Orthonormal frame of a tangent plane: x, y and normal = x cross y, unit vectors.
struct TangentFrame {
  Vector3 x{1, 0, 0}, y{0, 1, 0}, normal{0, 0, 1};
};
// A frame of the plane with this unit normal; a pure function of the normal.
TangentFrame frame_of_normal(Vector3 unit_normal);
// Rotates v by the smallest rotation that takes unit normal `from` to unit normal `to` (parallel transport
// across the fold between two planes). For opposite normals, mirrors v at the plane of `from`.
Vector3 transport(Vector3 v, Vector3 from, Vector3 to);
// The same for a tensor: its components in `to`, given those in `from`.
TangentTensor transport(TangentTensor tensor, const TangentFrame& from, const TangentFrame& to);

}  // namespace meander
