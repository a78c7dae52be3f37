// A plain 3-vector for scalar geometry; arrays of points stay separate x, y, z spans.
#pragma once

#include <cmath>
#include <utility>

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
// Area from three lengths, stable for needles (Kahan 2014); 0 where the lengths form no triangle.
inline double area_from_lengths(double a, double b, double c) {
  if (a < b) std::swap(a, b);
  if (b < c) std::swap(b, c);
  if (a < b) std::swap(a, b);
  const double product = (a + (b + c)) * (c - (a - b)) * (c + (a - b)) * (a + (b - c));
  return product > 0 ? 0.25 * std::sqrt(product) : 0.0;
}

}  // namespace meander
