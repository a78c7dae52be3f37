#include "kernels/analyse/random_differences.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "kernels/core/parallel.h"
#include "kernels/core/random.h"

namespace meander {

namespace {

constexpr std::size_t block = 1024;

std::vector<double> cumulative_areas(const PreparedMesh& mesh) {
  std::vector<double> cumulative(mesh.triangle_count() + 1, 0);
  for (std::size_t t = 0; t < mesh.triangle_count(); ++t) cumulative[t + 1] = cumulative[t] + mesh.area[t];
  return cumulative;
}

struct RandomPoint {
  Vector3 point, normal;  // that of its triangle, of any length
};

// Uniform by area, of four numbers in [0, 1).
RandomPoint random_point(const PreparedMesh& mesh, const std::vector<double>& cumulative, double chosen,
                         UnitPair inside) {
  const auto at = std::upper_bound(cumulative.begin() + 1, cumulative.end() - 1, chosen * cumulative.back());
  const auto t = static_cast<std::size_t>(at - cumulative.begin()) - 1;
  const Vector3 a = mesh.position(mesh.triangles[3 * t]), b = mesh.position(mesh.triangles[3 * t + 1]),
                c = mesh.position(mesh.triangles[3 * t + 2]);
  const double root = std::sqrt(inside.first), second = root * inside.second;
  return {(1 - root) * a + (root - second) * b + second * c, cross(b - a, c - a)};
}

void push(std::vector<double>& to, Vector3 v) { to.insert(to.end(), {v.x, v.y, v.z}); }

void push(std::vector<double>& to, const std::vector<double>& from, std::size_t i) {
  if (!from.empty()) to.insert(to.end(), {from[3 * i], from[3 * i + 1], from[3 * i + 2]});
}

}  // namespace

void add_random_surface_differences(DifferenceMap& map, const PreparedMesh& mesh, std::size_t count,
                                    std::uint64_t seed, std::uint32_t sets) {
  const std::vector<double> cumulative = cumulative_areas(mesh);
  const double spacing = std::sqrt(cumulative.back() / static_cast<double>(count));
  const RandomKey key = make_random_key(seed, {});
  for (std::uint32_t s = 0; s < sets; ++s) {
    std::vector<double> points, normals;
    for (std::size_t i = 0; i < count; ++i) {
      const RandomPoint p =
          random_point(mesh, cumulative, random_pair(key, Stream::surface_probe, i, 2 * s).first,
                       random_pair(key, Stream::surface_probe, i, 2 * s + 1));
      push(points, p.point);
      push(normals, p.normal);
    }
    add_surface_differences(map, points, normals, std::vector<double>(count, spacing));
  }
}

void FieldSamples::append(const FieldSamples& other) {
  const auto join = [](std::vector<double>& to, const std::vector<double>& from) {
    to.insert(to.end(), from.begin(), from.end());
  };
  join(points, other.points);
  join(normals, other.normals);
  join(density, other.density);
  join(axes, other.axes);
  join(ratio, other.ratio);
  join(frames, other.frames);
}

namespace {

std::array<double, 6> with_normal(const std::vector<double>& points, const std::vector<double>& normals,
                                  std::size_t i, double scale) {
  const Vector3 n{normals[3 * i], normals[3 * i + 1], normals[3 * i + 2]};
  const double s = scale / std::max(norm(n), 1e-300);
  return {points[3 * i], points[3 * i + 1], points[3 * i + 2], s * n.x, s * n.y, s * n.z};
}

std::vector<double> places_of(const FieldSamples& samples, double scale) {
  std::vector<double> places;
  for (std::size_t i = 0; i < samples.count(); ++i)
    for (const double c : with_normal(samples.points, samples.normals, i, scale)) places.push_back(c);
  return places;
}

}  // namespace

SampledField::SampledField(const PreparedMesh& mesh, FieldSamples samples, std::size_t count, double integral,
                           std::uint64_t seed)
    : mesh_(mesh),
      samples_(std::move(samples)),
      count_(count),
      cumulative_(cumulative_areas(mesh)),
      reach_(2 * std::sqrt(cumulative_.back() / static_cast<double>(count))),
      integral_(integral),
      tree_(places_of(samples_, reach_)) {
  // The integral of the field: stratified over the cumulative area, at random within triangles.
  const std::size_t probes = std::max<std::size_t>(20000, 32 * count_);
  std::vector<double> points, normals;
  const RandomKey key = make_random_key(seed, {});
  for (std::size_t k = 0; k < probes; ++k) {
    const double chosen = (static_cast<double>(k) + 0.5) / static_cast<double>(probes);
    const RandomPoint p =
        random_point(mesh_, cumulative_, chosen, random_pair(key, Stream::surface_probe, k, 0xFFFFFFFFu));
    push(points, p.point);
    push(normals, p.normal);
  }
  const std::vector<std::uint32_t> found = nearest(points, normals);
  const auto mean_to = [&](double most) {
    double sum = 0;
    for (const std::uint32_t i : found) sum += std::min(most, samples_.density[i]);
    return sum / static_cast<double>(probes);
  };
  const double largest = *std::max_element(samples_.density.begin(), samples_.density.end());
  most_ = std::min(largest, 1000 * mean_to(largest));
  own_ = cumulative_.back() * mean_to(most_);
  if (integral_ > 0) return;
  double sum = 0, squares = 0;
  for (const double density : samples_.density) {
    sum += 1 / density;
    squares += 1 / (density * density);
  }
  const double n = static_cast<double>(samples_.count()),
               error = std::sqrt(std::max(0.0, squares / (sum * sum) - 1 / n));
  integral_ = error < 0.02 ? cumulative_.back() * n / sum : own_;
}

std::vector<std::uint32_t> SampledField::nearest(const std::vector<double>& points,
                                                 const std::vector<double>& normals) const {
  std::vector<std::uint32_t> found(points.size() / 3);
  parallel_blocks(found.size(), block, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      KdTree<6>::Nearest best;
      tree_.nearest(with_normal(points, normals, i, reach_), KdTree<6>::none, best);
      found[i] = best.index;
    }
  });
  return found;
}

void SampledField::add(DifferenceMap& map, const FieldSamples& set, double integral) const {
  const double n = static_cast<double>(count_), widest = 8 * std::sqrt(cumulative_.back() / n);
  std::vector<double> s1, s2;
  for (std::size_t i = 0; i < set.count(); ++i) {
    const double spacing = std::min(widest, std::sqrt(integral / (n * std::min(most_, set.density[i]))));
    const double stretch = set.ratio.empty() ? 1 : std::sqrt(set.ratio[i]);
    s1.push_back(spacing * stretch);
    s2.push_back(spacing / stretch);
  }
  if (set.ratio.empty())
    add_surface_differences(map, set.points, set.normals, s1, set.frames);
  else
    add_anisotropic_surface_differences(map, {set.points, set.normals, set.axes, s1, s2});
}

void SampledField::add_random(DifferenceMap& map, std::uint64_t seed, std::uint32_t sets) const {
  const RandomKey key = make_random_key(seed, {});
  const std::size_t most_draws = 4000 * count_;  // a point takes 1000 at most, on average
  for (std::uint32_t s = 0; s < sets; ++s) {
    FieldSamples set;
    for (std::size_t begin = 0; set.count() < count_ && begin < most_draws; begin += block) {
      std::vector<double> points, normals;
      for (std::size_t k = begin; k < begin + block; ++k) {
        const RandomPoint p =
            random_point(mesh_, cumulative_, random_pair(key, Stream::surface_probe, k, 2 * s).first,
                         random_pair(key, Stream::surface_probe, k, 2 * s + 1));
        push(points, p.point);
        push(normals, p.normal);
      }
      const std::vector<std::uint32_t> found = nearest(points, normals);
      for (std::size_t k = 0; k < block && set.count() < count_; ++k) {
        const double density = std::min(most_, samples_.density[found[k]]);
        if (random_pair(key, Stream::surface_probe, begin + k, 2 * s).second * most_ >= density) continue;
        push(set.points, points, k);
        push(set.normals, normals, k);
        push(set.axes, samples_.axes, found[k]);
        push(set.frames, samples_.frames, found[k]);
        set.density.push_back(density);
        if (!samples_.ratio.empty()) set.ratio.push_back(samples_.ratio[found[k]]);
      }
    }
    add(map, set, own_);
  }
}

}  // namespace meander
