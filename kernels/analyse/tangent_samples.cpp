#include "kernels/analyse/tangent_samples.h"

#include <cmath>

#include "kernels/analyse/require.h"

namespace meander {

namespace {

Vector3 finite_at(std::span<const double> triples, std::size_t i) {
  const Vector3 v{triples[3 * i], triples[3 * i + 1], triples[3 * i + 2]};
  require(std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z),
          "samples: coordinates, normals and axes must be finite");
  return v;
}

}  // namespace

double sample_spacing_scale(double measure, std::uint64_t samples) {
  require(measure > 0 && std::isfinite(measure) && samples > 0,
          "sample_spacing_scale: measure and number of samples must be positive");
  return std::sqrt(measure / static_cast<double>(samples));
}

TangentFrame frame_along(Vector3 n, Vector3 first) {
  const auto project = [&](Vector3 v) { return v - dot(n, v) * n; };
  const double size = norm(first);
  Vector3 x = size > 0 ? project((1 / size) * first) : Vector3{};
  if (!(norm(x) > 1e-9)) x = project(std::abs(n.x) < 0.7 ? Vector3{1, 0, 0} : Vector3{0, 1, 0});
  x = (1 / norm(x)) * x;
  return {x, cross(n, x), n};
}

PreparedTangentSamples prepare_tangent_samples(const TangentSamples& samples) {
  const std::size_t count = samples.count();
  require(samples.s2.size() == count && samples.points.size() == 3 * count &&
              samples.normals.size() == 3 * count && samples.axes.size() == 3 * count,
          "samples: three coordinates, three of the normal, three of the axis and two spacings a sample");
  PreparedTangentSamples out;
  out.s1.assign(samples.s1.begin(), samples.s1.end());
  out.s2.assign(samples.s2.begin(), samples.s2.end());
  out.points.reserve(count);
  out.frames.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    require(samples.s1[i] > 0 && samples.s2[i] > 0 && std::isfinite(samples.s1[i]) &&
                std::isfinite(samples.s2[i]),
            "samples: spacings must be positive and finite");
    const Vector3 normal = finite_at(samples.normals, i);
    const double length = norm(normal);
    require(length > 0, "samples: normals must not be zero");
    out.points.push_back(finite_at(samples.points, i));
    out.frames.push_back(frame_along((1 / length) * normal, finite_at(samples.axes, i)));
  }
  return out;
}

}  // namespace meander
