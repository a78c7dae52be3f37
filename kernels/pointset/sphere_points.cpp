#include "kernels/pointset/sphere_points.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "kernels/core/parallel.h"
#include "kernels/pointset/planar_points.h"

namespace meander {

namespace {

constexpr double turn = 2 * std::numbers::pi;

SpherePoints empty_points(std::size_t count) {
  SpherePoints points;
  points.x.resize(count);
  points.y.resize(count);
  points.z.resize(count);
  return points;
}

void put(SpherePoints& points, std::size_t i, double angle, double height) {
  const double radius = std::sqrt(std::max(0.0, (1 - height) * (1 + height)));
  points.x[i] = radius * std::cos(angle);
  points.y[i] = radius * std::sin(angle);
  points.z[i] = height;
}

SpherePoints fibonacci(std::uint32_t count) {
  SpherePoints points = empty_points(count);
  for (std::uint32_t i = 0; i < count; ++i) {
    const double turns = i / std::numbers::phi;
    put(points, i, turn * (turns - std::floor(turns)), 1 - (2.0 * i + 1) / count);
  }
  return points;
}

SpherePoints spiral(std::uint32_t count) {
  SpherePoints points = empty_points(count);
  double angle = 0;
  for (std::uint32_t i = 0; i < count; ++i) {
    const double height = count == 1 ? -1 : -1 + 2.0 * i / (count - 1.0);
    if (i > 0 && i + 1 < count)  // the poles have no angle of their own
      angle = std::fmod(angle + 3.6 / std::sqrt(count * (1 - height) * (1 + height)), turn);
    put(points, i, i + 1 < count ? angle : 0, height);
  }
  return points;
}

}  // namespace

std::optional<SphereMethod> sphere_method(std::string_view name) {
  const auto at = std::find(sphere_method_names.begin(), sphere_method_names.end(), name);
  if (at == sphere_method_names.end()) return {};
  return static_cast<SphereMethod>(at - sphere_method_names.begin());
}

bool is_deterministic(SphereMethod method) {
  return method == SphereMethod::fibonacci || method == SphereMethod::spiral ||
         method == SphereMethod::hammersley;
}

SpherePoints lift_to_sphere(const PlanarPoints& planar) {
  SpherePoints points = empty_points(planar.count());
  parallel_blocks(planar.count(), sum_block, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) put(points, i, turn * planar.x[i], 1 - 2 * planar.y[i]);
  });
  return points;
}

SpherePoints sphere_points(SphereMethod method, std::uint32_t count, std::uint64_t seed) {
  switch (method) {
    case SphereMethod::random:
      return lift_to_sphere(planar_points(PlanarMethod::random, count, seed));
    case SphereMethod::fibonacci:
      return fibonacci(count);
    case SphereMethod::spiral:
      return spiral(count);
    case SphereMethod::hammersley:
      return lift_to_sphere(planar_points(PlanarMethod::hammersley, count, seed));
    case SphereMethod::hilbert_stratified:
      return lift_to_sphere(planar_points(PlanarMethod::hilbert_stratified, count, seed));
    case SphereMethod::hilbert_shifted:
      break;
  }
  return lift_to_sphere(planar_points(PlanarMethod::hilbert_shifted, count, seed));
}

}  // namespace meander
