#include "kernels/analyse/mesh_distance.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "kernels/analyse/point_location.h"
#include "kernels/analyse/unit_frame.h"
#include "kernels/core/parallel.h"
#include "kernels/core/random.h"
#include "kernels/core/status.h"
#include "kernels/mesh/bounds_tree.h"

namespace meander {

namespace {

constexpr std::size_t sample_block = 1024;

double fraction(double value) { return value - std::floor(value); }

// Points of a surface, stratified by area: sample i is a function of (surface, number of samples, seed, i).
class AreaSampler {
 public:
  AreaSampler(const TriangleSpans& mesh, const UnitFrame& frame, std::uint64_t seed)
      : mesh_(mesh), frame_(frame), key_(make_random_key(seed, {})) {
    const std::size_t count = mesh.triangles.size() / 3;
    std::vector<double> low(3 * count), high(3 * count);
    for (std::size_t t = 0; t < count; ++t) {
      const Vector3 a = corner(t, 0), b = corner(t, 1), c = corner(t, 2);
      const std::array<double, 3> least{std::min({a.x, b.x, c.x}), std::min({a.y, b.y, c.y}),
                                        std::min({a.z, b.z, c.z})};
      const std::array<double, 3> most{std::max({a.x, b.x, c.x}), std::max({a.y, b.y, c.y}),
                                       std::max({a.z, b.z, c.z})};
      std::copy(least.begin(), least.end(), low.begin() + static_cast<std::ptrdiff_t>(3 * t));
      std::copy(most.begin(), most.end(), high.begin() + static_cast<std::ptrdiff_t>(3 * t));
    }
    order_ = build_bounds_tree(low, high).order;
    before_.assign(count + 1, 0.0);
    for (std::size_t p = 0; p < count; ++p) {
      const std::size_t t = order_[p];
      before_[p + 1] = before_[p] + triangle_area(corner(t, 0), corner(t, 1), corner(t, 2));
      if (before_[p + 1] > before_[p]) last_ = p;
    }
    if (!(area() > 0)) throw ItemError(Status::zero_area, "no area to measure a distance from");
  }

  void set_samples(std::uint64_t samples) { samples_ = samples; }
  double area() const { return before_.back(); }  // working units squared

  // Sample i in file units.
  Vector3 sample(std::uint64_t i) const {
    const auto found = std::upper_bound(before_.begin() + 1, before_.end(), area_at(i));
    const std::size_t p = std::min(static_cast<std::size_t>(found - before_.begin()) - 1, last_);
    // The number of the sample within its triangle, by which it takes its place in a Kronecker sequence (R2,
    // Roberts 2018) with a random shift.
    const double expected = before_[p] / area() * static_cast<double>(samples_);
    auto first = std::min(i, static_cast<std::uint64_t>(std::max(0.0, std::floor(expected) - 1)));
    while (first < i && area_at(first) < before_[p]) ++first;
    const std::uint32_t t = order_[p];
    const UnitPair shift = random_pair(key_, Stream::surface_probe, t, 1);
    const auto number = static_cast<double>(i - first);
    double u = fraction(shift.first + number * 0.7548776662466927);
    double v = fraction(shift.second + number * 0.5698402909980532);
    if (u + v > 1) {
      u = 1 - u;
      v = 1 - v;
    }
    const Vector3 a = corner(t, 0);
    return frame_.from_unit(a + u * (corner(t, 1) - a) + v * (corner(t, 2) - a));
  }

 private:
  Vector3 corner(std::size_t triangle, std::size_t k) const {
    const std::uint32_t v = mesh_.triangles[3 * triangle + k];
    return frame_.to_unit({mesh_.x[v], mesh_.y[v], mesh_.z[v]});
  }
  // The position of sample i in the area: uniform in its stratum.
  double area_at(std::uint64_t i) const {
    const double jitter = random_pair(key_, Stream::surface_probe, i).first;
    return area() * ((static_cast<double>(i) + jitter) / static_cast<double>(samples_));
  }

  const TriangleSpans& mesh_;
  const UnitFrame& frame_;
  RandomKey key_;
  std::uint64_t samples_ = 0;
  std::vector<std::uint32_t> order_;  // triangles along the Hilbert curve
  std::vector<double> before_;        // T + 1: areas summed along it
  std::size_t last_ = 0;              // the last position with area
};

// The contribution of one block of points.
struct Gathered {
  double sum = 0, squares = 0, most = -1;
  Vector3 farthest;

  void add(Vector3 point, double value) {
    sum += value;
    squares += value * value;
    if (value > most) {
      most = value;
      farthest = point;
    }
  }
};

// point(i) for i in [0, count) against the surface; distances in units of `unit`, added up in fixed blocks.
template <class PointAt>
Gathered gather(const SurfaceLocator& surface, std::uint64_t count, double unit, const CancelToken& cancel,
                const PointAt& point_at) {
  std::vector<Gathered> blocks((count + sample_block - 1) / sample_block);
  parallel_blocks(count, sample_block, [&](std::size_t begin, std::size_t end) {
    cancel.check();
    Gathered& block = blocks[begin / sample_block];
    for (std::size_t i = begin; i < end; ++i) {
      const Vector3 p = point_at(i);
      block.add(p, surface.nearest(p).distance / unit);
    }
  });
  Gathered all;
  for (const Gathered& block : blocks) {
    all.sum += block.sum;
    all.squares += block.squares;
    if (block.most > all.most) {
      all.most = block.most;
      all.farthest = block.farthest;
    }
  }
  return all;
}

std::vector<std::uint32_t> used_vertices(const TriangleSpans& mesh) {
  std::vector<std::uint8_t> used(mesh.x.size(), 0);
  for (const std::uint32_t v : mesh.triangles) used[v] = 1;
  std::vector<std::uint32_t> vertices;
  for (std::size_t v = 0; v < used.size(); ++v)
    if (used[v] != 0) vertices.push_back(static_cast<std::uint32_t>(v));
  return vertices;
}

std::uint64_t checked_samples(double samples) {
  if (!(samples >= 1 && samples <= 4294967295.0))
    throw std::invalid_argument("mesh_distance: between 1 and 2^32 - 1 samples on a surface");
  return static_cast<std::uint64_t>(samples);
}

OneSidedDistance one_sided(const TriangleSpans& from, const UnitFrame& frame, const SurfaceLocator& to,
                           const MeshDistanceParameters& parameters, const CancelToken& cancel) {
  AreaSampler sampler(from, frame, parameters.seed);
  const double diagonal = frame.diagonal / frame.unit;
  const std::uint64_t samples = checked_samples(
      parameters.samples > 0
          ? static_cast<double>(parameters.samples)
          : std::max(1.0, std::ceil(parameters.density * sampler.area() / (diagonal * diagonal))));
  sampler.set_samples(samples);
  const Gathered over_area =
      gather(to, samples, frame.unit, cancel, [&](std::uint64_t i) { return sampler.sample(i); });
  const std::vector<std::uint32_t> vertices = used_vertices(from);
  const Gathered over_vertices = gather(to, vertices.size(), frame.unit, cancel, [&](std::uint64_t i) {
    const std::uint32_t v = vertices[i];
    return Vector3{from.x[v], from.y[v], from.z[v]};
  });

  OneSidedDistance result;
  const auto n = static_cast<double>(samples);
  result.mean = frame.unit * (over_area.sum / n);
  result.rms = frame.unit * std::sqrt(over_area.squares / n);
  const Gathered& most = over_vertices.most >= over_area.most ? over_vertices : over_area;
  result.max = frame.unit * most.most;
  result.farthest = most.farthest;
  result.samples = samples;
  result.vertices = vertices.size();
  result.sample_spacing = frame.unit * std::sqrt(sampler.area() / n);
  return result;
}

}  // namespace

MeshDistance mesh_distance(const EmbreeDevice& device, const TriangleSpans& first,
                           const TriangleSpans& second, const MeshDistanceParameters& parameters,
                           const CancelToken& cancel) {
  const UnitFrame first_frame = unit_frame(first.x, first.y, first.z, first.triangles);
  const UnitFrame second_frame = unit_frame(second.x, second.y, second.z, second.triangles);
  const SurfaceLocator to_first(device, first.x, first.y, first.z, first.triangles);
  const SurfaceLocator to_second(device, second.x, second.y, second.z, second.triangles);
  MeshDistance result;
  result.diagonal = first_frame.diagonal;
  result.forward = one_sided(first, first_frame, to_second, parameters, cancel);
  result.backward = one_sided(second, second_frame, to_first, parameters, cancel);
  return result;
}

std::vector<double> area_samples(const TriangleSpans& mesh, std::uint64_t samples, std::uint64_t seed) {
  if (samples == 0) return {};
  checked_samples(static_cast<double>(samples));
  const UnitFrame frame = unit_frame(mesh.x, mesh.y, mesh.z, mesh.triangles);
  AreaSampler sampler(mesh, frame, seed);
  sampler.set_samples(samples);
  std::vector<double> points(3 * samples);
  parallel_blocks(samples, sample_block, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const Vector3 p = sampler.sample(i);
      points[3 * i] = p.x;
      points[3 * i + 1] = p.y;
      points[3 * i + 2] = p.z;
    }
  });
  return points;
}

}  // namespace meander
