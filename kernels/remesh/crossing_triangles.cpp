#include "kernels/remesh/crossing_triangles.h"

namespace meander {

namespace {

// Cosine between the normals of triangles with a common edge from which they count as folded together.
constexpr double folded = -0.999;

// Six times that of the tetrahedron.
double signed_volume(Vector3 a, Vector3 b, Vector3 c, Vector3 d) { return dot(cross(b - a, c - a), d - a); }

bool passes_through(Vector3 p, Vector3 q, const TriangleCorners& t) {
  if (signed_volume(t[0], t[1], t[2], p) * signed_volume(t[0], t[1], t[2], q) >= 0) return false;
  const double first = signed_volume(p, q, t[0], t[1]), second = signed_volume(p, q, t[1], t[2]),
               third = signed_volume(p, q, t[2], t[0]);
  return (first > 0 && second > 0 && third > 0) || (first < 0 && second < 0 && third < 0);
}

}  // namespace

bool triangles_cross(const TriangleCorners& a, const TriangleCorners& b) {
  for (std::size_t k = 0; k < 3; ++k)
    if (passes_through(a[k], a[(k + 1) % 3], b) || passes_through(b[k], b[(k + 1) % 3], a)) return true;
  return false;
}

bool triangles_overlap(const TriangleVertices& a, const TriangleCorners& at_a, const TriangleVertices& b,
                       const TriangleCorners& at_b) {
  std::size_t common = 0, in_a = 0, in_b = 0;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      if (a[i] == b[j]) {
        ++common;
        in_a = i;
        in_b = j;
      }
  if (common == 0) return triangles_cross(at_a, at_b);
  if (common == 1)
    return passes_through(at_a[(in_a + 1) % 3], at_a[(in_a + 2) % 3], at_b) ||
           passes_through(at_b[(in_b + 1) % 3], at_b[(in_b + 2) % 3], at_a);
  const Vector3 n = cross(at_a[1] - at_a[0], at_a[2] - at_a[0]),
                m = cross(at_b[1] - at_b[0], at_b[2] - at_b[0]);
  return dot(n, m) < folded * norm(n) * norm(m);
}

SpaceBox box_of(const TriangleCorners& triangle) {
  const auto& [a, b, c] = triangle;
  return {{std::min({a.x, b.x, c.x}), std::min({a.y, b.y, c.y}), std::min({a.z, b.z, c.z})},
          {std::max({a.x, b.x, c.x}), std::max({a.y, b.y, c.y}), std::max({a.z, b.z, c.z})}};
}

SpaceBox common_box(const SpaceBox& a, const SpaceBox& b) {
  SpaceBox both = a;
  for (std::size_t k = 0; k < 3; ++k) {
    both.low[k] = std::max(a.low[k], b.low[k]);
    both.high[k] = std::min(a.high[k], b.high[k]);
  }
  return both;
}

}  // namespace meander
