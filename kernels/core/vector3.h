// A plain 3-vector for scalar geometry; arrays of points stay separate x, y, z spans.
#pragma once

#include <cmath>

namespace meander {

struct Vector3 {
  double x = 0, y = 0, z = 0;
};
constexpr Vector3 operator+(Vector3 a, Vector3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
constexpr Vector3 operator-(Vector3 a, Vector3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
constexpr Vector3 operator*(double s, Vector3 a) { return {s * a.x, s * a.y, s * a.z}; }
constexpr double dot(Vector3 a, Vector3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
constexpr Vector3 cross(Vector3 a, Vector3 b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline double norm(Vector3 a) { return std::sqrt(dot(a, a)); }
inline double distance(Vector3 a, Vector3 b) { return norm(a - b); }
inline double triangle_area(Vector3 a, Vector3 b, Vector3 c) { return 0.5 * norm(cross(b - a, c - a)); }

}  // namespace meander
