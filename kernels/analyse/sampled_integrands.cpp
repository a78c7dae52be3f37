#include "kernels/analyse/sampled_integrands.h"

#include <cmath>
#include <utility>

#include "kernels/analyse/box_discrepancy.h"
#include "kernels/analyse/integration_error.h"

namespace meander {

std::vector<SampledIntegrand> plane_integrands(std::span<const double> x, std::span<const double> y) {
  std::vector<SampledIntegrand> result;
  for (const Integrand& f : standard_integrands()) {
    if (f.name == "weighted") continue;  // needs sets of its own density
    SampledIntegrand integrand{std::string(f.name), {}, f.mean};
    for (std::size_t i = 0; i < x.size(); ++i) integrand.values.push_back(f.value(x[i], y[i]));
    result.push_back(std::move(integrand));
  }
  return result;
}

std::vector<SampledIntegrand> mesh_integrands(const PreparedMesh& mesh, std::span<const double> points) {
  const auto smooth = [](Vector3 p) { return p.x * p.x + 0.5 * p.y * p.z - 0.3 * p.z + 0.7 * p.y; };
  SampledIntegrand polynomial{"quadratic", {}, 0}, side{"half-space", {}, 0};
  double total = 0;
  for (std::size_t t = 0; t < mesh.triangle_count(); ++t) {
    const Vector3 a = mesh.position(mesh.triangles[3 * t]), b = mesh.position(mesh.triangles[3 * t + 1]),
                  c = mesh.position(mesh.triangles[3 * t + 2]);
    total += mesh.area[t] * (smooth(0.5 * (a + b)) + smooth(0.5 * (b + c)) + smooth(0.5 * (c + a))) / 3;
  }
  polynomial.mean = total / mesh.total_area;
  // The half-space as a box that reaches far beyond the mesh on one side (working coordinates lie in [-1,
  // 1]).
  const Vector3 normal = (1 / std::sqrt(14.0)) * Vector3{1, 2, 3};
  const Vector3 across = (1 / std::sqrt(5.0)) * Vector3{2, -1, 0};
  RotatedBox half;
  half.axes = {normal, across, cross(normal, across)};
  half.half = {8, 8, 8};
  half.center = 8.0 * normal;
  side.mean = area_in_box(mesh.x, mesh.y, mesh.z, mesh.triangles, half) / mesh.total_area;
  for (std::size_t i = 0; i < points.size(); i += 3) {
    const Vector3 p{points[i], points[i + 1], points[i + 2]};
    polynomial.values.push_back(smooth(p));
    side.values.push_back(dot(normal, p) >= 0 ? 1 : 0);
  }
  return {std::move(polynomial), std::move(side)};
}

}  // namespace meander
