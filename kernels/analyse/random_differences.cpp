#include "kernels/analyse/random_differences.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "kernels/core/random.h"

namespace meander {

void add_random_surface_differences(DifferenceMap& map, const PreparedMesh& mesh, std::size_t count,
                                    std::uint64_t seed, std::uint32_t sets) {
  std::vector<double> cumulative(mesh.triangle_count() + 1, 0);
  for (std::size_t t = 0; t < mesh.triangle_count(); ++t) cumulative[t + 1] = cumulative[t] + mesh.area[t];
  const double spacing = std::sqrt(cumulative.back() / static_cast<double>(count));
  for (std::uint32_t s = 0; s < sets; ++s) {
    std::vector<double> points, normals;
    for (std::size_t i = 0; i < count; ++i) {
      const UnitPair chosen = random_pair(make_random_key(seed, {}), Stream::surface_probe, i, 2 * s),
                     inside = random_pair(make_random_key(seed, {}), Stream::surface_probe, i, 2 * s + 1);
      const auto at =
          std::upper_bound(cumulative.begin() + 1, cumulative.end() - 1, chosen.first * cumulative.back());
      const auto t = static_cast<std::size_t>(at - cumulative.begin()) - 1;
      const Vector3 a = mesh.position(mesh.triangles[3 * t]), b = mesh.position(mesh.triangles[3 * t + 1]),
                    c = mesh.position(mesh.triangles[3 * t + 2]);
      const double root = std::sqrt(inside.first), second = root * inside.second;
      const Vector3 p = (1 - root) * a + (root - second) * b + second * c, n = cross(b - a, c - a);
      points.insert(points.end(), {p.x, p.y, p.z});
      normals.insert(normals.end(), {n.x, n.y, n.z});
    }
    add_surface_differences(map, points, normals, std::vector<double>(count, spacing));
  }
}

}  // namespace meander
