#include "kernels/analyse/box_triangles.h"

#include <algorithm>

namespace meander {

BoxTriangles build_box_triangles(std::span<const double> x, std::span<const double> y,
                                 std::span<const double> z, std::span<const std::uint32_t> triangles) {
  const std::size_t count = triangles.size() / 3;
  std::vector<double> low(3 * count), high(3 * count);
  const auto position = [&](std::size_t corner) {
    const std::uint32_t v = triangles[corner];
    return Vector3{x[v], y[v], z[v]};
  };
  for (std::size_t t = 0; t < count; ++t) {
    const Vector3 a = position(3 * t), b = position(3 * t + 1), c = position(3 * t + 2);
    const std::array<double, 3> least{std::min({a.x, b.x, c.x}), std::min({a.y, b.y, c.y}),
                                      std::min({a.z, b.z, c.z})};
    const std::array<double, 3> most{std::max({a.x, b.x, c.x}), std::max({a.y, b.y, c.y}),
                                     std::max({a.z, b.z, c.z})};
    std::copy(least.begin(), least.end(), low.begin() + 3 * t);
    std::copy(most.begin(), most.end(), high.begin() + 3 * t);
  }
  BoxTriangles made;
  made.tree = build_bounds_tree(low, high);
  made.corners.resize(9 * count);
  for (std::size_t p = 0; p < count; ++p)
    for (std::size_t k = 0; k < 3; ++k) {
      const Vector3 v = position(3 * std::size_t{made.tree.order[p]} + k);
      made.corners[9 * p + 3 * k] = v.x;
      made.corners[9 * p + 3 * k + 1] = v.y;
      made.corners[9 * p + 3 * k + 2] = v.z;
    }
  return made;
}

}  // namespace meander
