#include "kernels/analyse/sampled_integrands.h"

#include <cmath>
#include <vector>

#include "kernels/analyse/differential_domain.h"
#include "kernels/analyse/integration_error.h"
#include "kernels/analyse/random_differences.h"
#include "kernels/analyse/spacing.h"
#include "kernels/core/random.h"
#include "kernels/mesh/prepare_mesh.h"
#include "support/catch.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;

TEST_CASE("mesh_integrands: the exact means match many points at the same places") {
  const PreparedMesh mesh = prepare_mesh(moved(torus(24, 12), 1, 3, 2, 1));
  // Each triangle in n^2 equal parts, a point in the middle of each, weighted by the triangle's area.
  constexpr int n = 12;
  std::vector<double> points, density;
  for (std::uint32_t t = 0; t < mesh.triangle_count(); ++t) {
    const Vector3 a = mesh.position(mesh.triangles[3 * t]), b = mesh.position(mesh.triangles[3 * t + 1]),
                  c = mesh.position(mesh.triangles[3 * t + 2]);
    for (int i = 0; i < n; ++i)
      for (int j = 0; i + j < n; ++j)
        for (const int half : {0, 1}) {
          if (half == 1 && i + j == n - 1) continue;
          const double u = (i + (1.0 + half) / 3) / n, v = (j + (1.0 + half) / 3) / n;
          const Vector3 p = (1 - u - v) * a + u * b + v * c;
          points.insert(points.end(), {p.x, p.y, p.z});
          density.push_back(1 / mesh.area[t]);
        }
  }
  const auto integrands = mesh_integrands(mesh, points);
  REQUIRE(integrands.size() == 2);
  CHECK(integrands[0].name == "quadratic");
  CHECK(mean_estimate(integrands[0].values, density) == Approx(integrands[0].mean).epsilon(1e-3));
  CHECK(integrands[1].name == "half-space");
  CHECK(mean_estimate(integrands[1].values, density) == Approx(integrands[1].mean).margin(0.01));
}

TEST_CASE("plane_integrands: equal the standard ones, and the grid of the unit square integrates them") {
  std::vector<double> x, y;
  for (int i = 0; i < 100 * 100; ++i) {
    x.push_back((i % 100 + 0.5) / 100);
    y.push_back((i / 100 + 0.5) / 100);
  }
  const auto integrands = plane_integrands(x, y);
  CHECK(integrands.size() == standard_integrands().size() - 1);
  for (const SampledIntegrand& integrand : integrands) {
    INFO(integrand.name);
    CHECK(mean_estimate(integrand.values) == Approx(integrand.mean).margin(2e-3));
  }
}

TEST_CASE("add_random_surface_differences: one seed gives one map, at the level of independent points") {
  const PreparedMesh mesh = prepare_mesh(icosphere(3));
  DifferenceMap map = make_difference_map(), again = make_difference_map();
  add_random_surface_differences(map, mesh, 2000, 7, 2);
  add_random_surface_differences(again, mesh, 2000, 7, 2);
  CHECK(map.sets == 2);
  CHECK(map.sum == again.sum);
  const std::vector<double> ratio = normalized_differences(map, expected_differences(map.parameters, 2000));
  double sum = 0;
  for (const double r : ratio) sum += r;
  CHECK(sum / static_cast<double>(ratio.size()) == Approx(1).epsilon(0.03));
}
