// The triangles of a chart in the plane.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>

#include "kernels/flatten/flatten_chart.h"
#include "kernels/flatten/orient2d.h"

namespace meander {

struct UvTriangle {
  std::array<double, 3> u, v;
};

inline UvTriangle uv_triangle(const FlatChart& chart, std::size_t triangle) {
  UvTriangle result{};
  for (std::size_t k = 0; k < 3; ++k) {
    const std::uint32_t vertex = chart.cut.triangles[3 * triangle + k];
    result.u[k] = chart.u[vertex];
    result.v[k] = chart.v[vertex];
  }
  return result;
}

// The unsigned area: a flipped triangle covers the plane as well as any other.
inline double uv_area(const UvTriangle& t) {
  return 0.5 * std::abs((t.u[1] - t.u[0]) * (t.v[2] - t.v[0]) - (t.u[2] - t.u[0]) * (t.v[1] - t.v[0]));
}

// The exact sign of the turn: 1 counter-clockwise, -1 clockwise, 0 without area.
inline int orientation(const UvTriangle& t) {
  const double twice_area = orient2d(t.u[0], t.v[0], t.u[1], t.v[1], t.u[2], t.v[2]);
  return (twice_area > 0) - (twice_area < 0);
}

// Whether a point is strictly inside, exactly: false on the border, so that no point is strictly inside two
// triangles of a map that does not overlap.
inline bool strictly_inside(const UvTriangle& t, double u, double v) {
  int positive = 0, negative = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t next = (k + 1) % 3;
    const double side = orient2d(t.u[k], t.v[k], t.u[next], t.v[next], u, v);
    positive += side > 0;
    negative += side < 0;
  }
  return positive == 3 || negative == 3;
}

// Weights of the three corners at a point, clamped to the triangle; a third each where it has no area.
inline std::array<double, 3> clamped_barycentric(const UvTriangle& t, double u, double v) {
  std::array<double, 3> weight{};
  const double area = (t.u[1] - t.u[0]) * (t.v[2] - t.v[0]) - (t.u[2] - t.u[0]) * (t.v[1] - t.v[0]);
  double sum = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t a = (k + 1) % 3, b = (k + 2) % 3;
    const double part = (t.u[a] - u) * (t.v[b] - v) - (t.u[b] - u) * (t.v[a] - v);
    weight[k] = area == 0 ? 1.0 : std::fmax(0.0, part / area);
    sum += weight[k];
  }
  for (double& w : weight) w /= sum;
  return weight;
}

}  // namespace meander
