// Differences between samples of surfaces (declared in differential_domain.h).
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "kernels/analyse/difference_blocks.h"
#include "kernels/analyse/kd_tree.h"
#include "kernels/core/random.h"

namespace meander {

using namespace differences;

namespace {

Vector3 at(std::span<const double> triples, std::size_t i) {
  return {triples[3 * i], triples[3 * i + 1], triples[3 * i + 2]};
}

std::vector<TangentFrame> tangent_frames(std::span<const Vector3> normals, std::span<const double> frames,
                                         std::uint64_t seed) {
  const RandomKey key = make_random_key(seed, {});
  std::vector<TangentFrame> out(normals.size());
  for (std::size_t i = 0; i < normals.size(); ++i) {
    if (!frames.empty()) {
      out[i] = frame_along(normals[i], at(frames, i));
      continue;
    }
    const TangentFrame any = frame_along(normals[i], {});
    const double angle = 2 * std::numbers::pi * random_pair(key, Stream::tangent_frame, i).first;
    const double c = std::cos(angle), s = std::sin(angle);
    out[i] = {c * any.x + s * any.y, c * any.y - s * any.x, any.normal};
  }
  return out;
}

// A vector of this length in the tangential part of the direction; none where that has no tangential part.
std::optional<std::array<double, 2>> along_surface(const TangentFrame& frame, Vector3 towards,
                                                   double length) {
  const double a = dot(frame.x, towards), b = dot(frame.y, towards);
  const double size = std::sqrt(a * a + b * b);
  if (!(size > 1e-12 * norm(towards))) return std::nullopt;
  return std::array<double, 2>{length * a / size, length * b / size};
}

}  // namespace

void add_anisotropic_surface_differences(DifferenceMap& map, const TangentSamples& samples,
                                         const TensorDifferenceParameters& parameters) {
  require(parameters.min_normal_cosine >= -1 && parameters.min_normal_cosine <= 1,
          "differences: min_normal_cosine is in [-1, 1]");
  const PreparedTangentSamples at_sample = prepare_tangent_samples(samples);
  const std::vector<double> weight = half_weights(parameters.counted, samples.count());
  const bool by_area = parameters.units == DifferenceUnits::area;
  const double reach = reach_of(map.parameters);
  std::vector<double> along(samples.count()), across(samples.count());  // what components are divided by
  for (std::size_t i = 0; i < samples.count(); ++i) {
    const double size = std::sqrt(samples.s1[i] * samples.s2[i]);
    along[i] = by_area ? size : samples.s1[i];
    across[i] = by_area ? size : samples.s2[i];
  }
  const KdTree<3> tree(samples.points);
  using Vector2 = std::array<double, 2>;
  // v is a tangent vector at sample i; both ends' S^-1 v, averaged, in the frame of sample i.
  const auto add_from = [&](MapBlock& block, std::uint32_t i, std::uint32_t j, const Vector2& v) {
    if (!(weight[i] > 0)) return;
    const TangentFrame &here = at_sample.frames[i], &there = at_sample.frames[j];
    const Vector3 moved = transport(v[0] * here.x + v[1] * here.y, here.normal, there.normal);
    const Vector3 scaled =
        transport((dot(moved, there.x) / along[j]) * there.x + (dot(moved, there.y) / across[j]) * there.y,
                  there.normal, here.normal);
    block.add(0.5 * (v[0] / along[i] + dot(scaled, here.x)), 0.5 * (v[1] / across[i] + dot(scaled, here.y)),
              weight[i]);
  };
  add_blocks(map, samples.count(), [&](MapBlock& block, std::size_t position) {
    const std::uint32_t i = tree.index(position);
    const Vector3 p = at_sample.points[i];
    const TangentFrame& frame = at_sample.frames[i];
    const double r = reach * std::max(along[i], across[i]) * (1 + 1e-12);
    // No geodesic is shorter than the chord.
    tree.in_ball(tree.point(position), r * r, [&](std::uint32_t j, const auto&) {
      const TangentFrame& other = at_sample.frames[j];
      if (j <= i || dot(frame.normal, other.normal) < parameters.min_normal_cosine) return;
      if (weight[i] + weight[j] == 0) return;
      const Vector3 q = at_sample.points[j];
      const double length = geodesic_length(p, frame.normal, q, other.normal);
      const auto v = along_surface(frame, q - p, length), w = along_surface(other, p - q, length);
      if (!v || !w) return;
      const auto within = [&](const Vector2& d, std::uint32_t k) {
        return square({d[0] / along[k], d[1] / across[k]}) <= reach * reach;
      };
      if (!within(*v, i) || !within(*w, j)) return;
      add_from(block, i, j, *v);
      add_from(block, j, i, *w);
    });
  });
}

std::optional<std::array<double, 2>> geodesic_vector(Vector3 p, const TangentFrame& frame, Vector3 q,
                                                     Vector3 n_q) {
  if (!(distance(p, q) > 0)) return std::array<double, 2>{0, 0};
  return along_surface(frame, q - p, geodesic_length(p, frame.normal, q, n_q));
}

double geodesic_length(Vector3 p, Vector3 n_p, Vector3 q, Vector3 n_q) {
  const Vector3 chord = p - q;
  const double d = norm(chord);
  if (!(d > 0)) return 0;
  const auto sine = [&](Vector3 n) { return std::clamp(dot(n, chord) / d, -1.0, 1.0); };
  const double c1 = sine(n_p), c2 = sine(n_q);
  // sin a - sin b = 2 cos((a + b) / 2) sin((a - b) / 2): with h = (c1 - c2) / (2 cos m) and m the mean of the
  // arc sines, the quotient is asin(h) / (h cos m), whose limit h = 0 needs no case of its own.
  const double cosine = std::cos(0.5 * (std::asin(c1) + std::asin(c2)));
  if (!(cosine > 1e-12)) return std::numeric_limits<double>::infinity();
  const double h = std::clamp(0.5 * (c1 - c2) / cosine, -1.0, 1.0);
  const double quotient = std::abs(h) < 1e-3 ? 1 + h * h * (1.0 / 6 + h * h * (3.0 / 40)) : std::asin(h) / h;
  return d * quotient / cosine;
}

void add_surface_differences(DifferenceMap& map, std::span<const double> points,
                             std::span<const double> normals, std::span<const double> spacing,
                             std::span<const double> frames, const SurfaceDifferenceParameters& parameters) {
  require(points.size() % 3 == 0 && normals.size() == points.size(),
          "differences: three coordinates and three of the normal a sample");
  require(frames.empty() || frames.size() == points.size(), "differences: three coordinates a tangent frame");
  require(parameters.min_normal_cosine >= -1 && parameters.min_normal_cosine <= 1,
          "differences: min_normal_cosine is in [-1, 1]");
  check_finite(normals);
  check_finite(frames);
  const std::size_t samples = points.size() / 3;
  check_spacing(spacing, samples);
  std::vector<Vector3> unit(samples);
  for (std::size_t i = 0; i < samples; ++i) {
    const double length = norm(at(normals, i));
    require(length > 0, "differences: normals must not be zero");
    unit[i] = (1 / length) * at(normals, i);
  }
  const std::vector<TangentFrame> tangents = tangent_frames(unit, frames, parameters.seed);
  const KdTree<3> tree(points);
  const double reach = reach_of(map.parameters);

  // q: `length` in the direction from sample i to the other one, in the frame of sample i.
  const auto add_from = [&](MapBlock& block, std::uint32_t i, Vector3 towards, double length) {
    const std::optional<std::array<double, 2>> q = along_surface(tangents[i], towards, length);
    // Half, as every deposit is mirrored in the end.
    if (q) block.add((*q)[0], (*q)[1], 0.5);
  };
  add_blocks(map, samples, [&](MapBlock& block, std::size_t position) {
    const std::uint32_t i = tree.index(position);
    const Vector3 p = at(points, i);
    const double r = reach * spacing[i];
    // No geodesic is shorter than the chord.
    tree.in_ball(tree.point(position), r * r, [&](std::uint32_t j, const auto&) {
      if (j <= i || dot(unit[i], unit[j]) < parameters.min_normal_cosine) return;
      const Vector3 q = at(points, j);
      const double length = geodesic_length(p, unit[i], q, unit[j]);
      if (!(length <= reach * std::min(spacing[i], spacing[j]))) return;
      const double scaled = 2 * length / (spacing[i] + spacing[j]);
      add_from(block, i, q - p, scaled);
      add_from(block, j, p - q, scaled);
    });
  });
}

}  // namespace meander
