#include "kernels/analyse/differential_domain.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <stdexcept>

#include "kernels/analyse/kd_tree.h"
#include "kernels/core/parallel.h"
#include "kernels/core/random.h"

namespace meander {

namespace {

constexpr std::size_t most_blocks = 32;
constexpr std::size_t most_map_cells = std::size_t{1}
                                       << 22;  // of the maps of all blocks, while there are more than two
constexpr double cut_off = 3;                  // standard deviations of the kernel
constexpr double widest_kernel = 64;           // cells
constexpr std::size_t most_weights = 2 * static_cast<std::size_t>(cut_off * widest_kernel) + 2;

void require(bool fine, const char* what) {
  if (!fine) throw std::invalid_argument(what);
}

void check_finite(std::span<const double> values) {
  for (const double value : values)
    require(std::isfinite(value), "differences: coordinates, normals and frames must be finite");
}

// The kernel along one axis: weights of the cells first .. first + count - 1, which may lie beyond the map.
// They sum to one, so that every pair counts alike wherever in its cell it falls.
struct AxisWeights {
  std::ptrdiff_t first = 0;
  std::size_t count = 0;
  std::array<double, most_weights> weight;
};

// at: position in cells from the middle of cell 0.
void weigh(double at, double kernel, AxisWeights& out) {
  const double low = std::ceil(at - cut_off * kernel), high = std::floor(at + cut_off * kernel);
  if (!(low < high)) {  // narrower than a cell
    out.first = static_cast<std::ptrdiff_t>(std::floor(at + 0.5));
    out.count = 1;
    out.weight[0] = 1;
    return;
  }
  out.first = static_cast<std::ptrdiff_t>(low);
  out.count = static_cast<std::size_t>(high - low) + 1;
  // exp(-(d + i)^2 / 2 k^2): the ratio of neighbours changes by a constant factor.
  const double h = 1 / (kernel * kernel), d = low - at;
  double value = std::exp(-0.5 * h * d * d), ratio = std::exp(-h * (d + 0.5)), sum = 0;
  const double step = std::exp(-h);
  for (std::size_t i = 0; i < out.count; ++i) {
    out.weight[i] = value;
    sum += value;
    value *= ratio;
    ratio *= step;
  }
  for (std::size_t i = 0; i < out.count; ++i) out.weight[i] /= sum;
}

// A map being filled by one block of samples.
class MapBlock {
 public:
  explicit MapBlock(const DifferenceParameters& parameters)
      : parameters_(parameters),
        scale_(parameters.cells / (2 * parameters.range)),
        sums_(std::size_t{parameters.cells} * parameters.cells, 0.0) {}

  void add(double qx, double qy, double weight) {
    const double margin = cut_off * parameters_.kernel + 1;
    const double x = (qx + parameters_.range) * scale_ - 0.5, y = (qy + parameters_.range) * scale_ - 0.5;
    const double cells = parameters_.cells;
    if (!(x > -margin && x < cells + margin && y > -margin && y < cells + margin)) return;
    weigh(x, parameters_.kernel, across_);
    weigh(y, parameters_.kernel, up_);
    const auto side = static_cast<std::ptrdiff_t>(parameters_.cells);
    const std::ptrdiff_t from = std::max<std::ptrdiff_t>(0, -across_.first);
    const std::ptrdiff_t to =
        std::min(static_cast<std::ptrdiff_t>(across_.count), side - across_.first);  // exclusive
    for (std::size_t j = 0; j < up_.count; ++j) {
      const std::ptrdiff_t row = up_.first + static_cast<std::ptrdiff_t>(j);
      if (row < 0 || row >= side) continue;
      const double w = weight * up_.weight[j];
      double* out = sums_.data() + row * side + across_.first;
      for (std::ptrdiff_t i = from; i < to; ++i) out[i] += w * across_.weight[static_cast<std::size_t>(i)];
    }
  }

  const std::vector<double>& sums() const { return sums_; }

 private:
  DifferenceParameters parameters_;
  double scale_;  // cells per unit
  std::vector<double> sums_;
  AxisWeights across_, up_;
};

// Largest |q| that can touch the map: its corner and the tail of the kernel.
double reach_of(const DifferenceParameters& parameters) {
  const double cell = 2 * parameters.range / parameters.cells;
  return std::numbers::sqrt2 * (parameters.range + cut_off * parameters.kernel * cell);
}

// Calls visit(block map, position in the tree's order) for every sample, in fixed blocks, then adds the maps
// and their mirror images: each unordered pair was visited once.
template <class Visit>
void add_blocks(DifferenceMap& map, std::size_t samples, const Visit& visit) {
  const std::size_t affordable = std::max<std::size_t>(2, most_map_cells / map.sum.size());
  const std::size_t blocks = std::clamp<std::size_t>(samples / 64, 1, std::min(most_blocks, affordable));
  std::vector<std::vector<double>> sums(blocks);
  parallel_tasks(blocks, [&](std::size_t b) {
    MapBlock block(map.parameters);
    for (std::size_t p = samples * b / blocks; p < samples * (b + 1) / blocks; ++p) visit(block, p);
    sums[b] = block.sums();
  });
  const std::size_t cells = map.sum.size();
  for (const std::vector<double>& block : sums)
    for (std::size_t c = 0; c < cells; ++c) map.sum[c] += block[c] + block[cells - 1 - c];
  ++map.sets;
}

std::vector<double> planar_points(std::span<const double> x, std::span<const double> y,
                                  const PlaneDomain& domain) {
  require(x.size() == y.size(), "differences: as many x as y");
  require(domain.period_x >= 0 && domain.period_y >= 0 && std::isfinite(domain.period_x + domain.period_y),
          "differences: periods are finite and not negative");
  check_finite(x);
  check_finite(y);
  std::vector<double> points(2 * x.size());
  for (std::size_t i = 0; i < x.size(); ++i) {
    points[2 * i] = wrapped(x[i], domain.period_x);
    points[2 * i + 1] = wrapped(y[i], domain.period_y);
  }
  return points;
}

void check_spacing(std::span<const double> spacing, std::size_t samples) {
  require(spacing.size() == samples, "differences: as many spacings as samples");
  for (const double r : spacing) require(r > 0 && std::isfinite(r), "differences: spacings must be positive");
}

// Calls pair(block map, i, j, dx, dy) once for every pair i < j with |d| <= radius(i), d = point i - point j,
// on the torus; `radius` must be such that pairs that matter are within that of both.
template <class Radius, class Pair>
void add_planar(DifferenceMap& map, std::span<const double> x, std::span<const double> y,
                const PlaneDomain& domain, const Radius& radius, const Pair& pair) {
  const KdTree<2> tree(planar_points(x, y, domain));
  const auto fits = [](double period, double r) { return !(period > 0) || period >= 2 * r; };
  for (std::uint32_t i = 0; i < tree.count(); ++i)
    require(fits(domain.period_x, radius(i)) && fits(domain.period_y, radius(i)),
            "differences: a period must be at least twice the reach");
  add_blocks(map, tree.count(), [&](MapBlock& block, std::size_t p) {
    const std::uint32_t i = tree.index(p);
    const double r = radius(i);
    for_each_image(tree.point(p), domain.period_x, domain.period_y, [&](const auto& image) {
      tree.in_ball(image, r * r, [&](std::uint32_t j, const auto& other) {
        if (j > i) pair(block, i, j, image[0] - other[0], image[1] - other[1]);
      });
    });
  });
}

// Row-major 2 x 2 times a vector.
std::array<double, 2> times(const double* m, double dx, double dy) {
  return {m[0] * dx + m[1] * dy, m[2] * dx + m[3] * dy};
}

// The least singular value of a 2 x 2 matrix: |det| / the largest.
double least_stretch(const double* m) {
  const double sum = std::hypot(m[0] + m[3], m[1] - m[2]), difference = std::hypot(m[0] - m[3], m[1] + m[2]);
  return std::abs(m[0] * m[3] - m[1] * m[2]) / (0.5 * (sum + difference));
}

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

double square(const std::array<double, 2>& v) { return v[0] * v[0] + v[1] * v[1]; }

std::array<double, 2> times(TangentTensor m, double dx, double dy) {
  return {m.xx * dx + m.xy * dy, m.xy * dx + m.yy * dy};
}

// The weight of the deposit in the frame of each sample: one half where it is counted.
std::vector<double> half_weights(std::span<const std::uint8_t> counted, std::size_t samples) {
  require(counted.empty() || counted.size() == samples, "differences: `counted` is one a sample, or none");
  std::vector<double> weight(samples, 0.5);
  for (std::size_t i = 0; i < counted.size(); ++i) weight[i] = counted[i] != 0 ? 0.5 : 0;
  return weight;
}

}  // namespace

DifferenceMap make_difference_map(const DifferenceParameters& parameters) {
  require(parameters.range > 0 && std::isfinite(parameters.range), "make_difference_map: range > 0");
  require(parameters.cells >= 2 && parameters.cells <= 4096, "make_difference_map: 2..4096 cells");
  require(parameters.kernel > 0 && parameters.kernel <= widest_kernel,
          "make_difference_map: the kernel is in (0, 64] cells");
  DifferenceMap map;
  map.parameters = parameters;
  map.sum.assign(map.side() * map.side(), 0.0);
  return map;
}

void add_differences(DifferenceMap& map, std::span<const double> x, std::span<const double> y, double spacing,
                     const PlaneDomain& domain) {
  check_spacing({&spacing, 1}, 1);
  const double scale = 1 / spacing, radius = reach_of(map.parameters) * spacing;
  add_planar(
      map, x, y, domain, [&](std::uint32_t) { return radius; },
      [&](MapBlock& block, std::uint32_t, std::uint32_t, double dx, double dy) {
        block.add(scale * dx, scale * dy, 1);
      });
}

void add_density_differences(DifferenceMap& map, std::span<const double> x, std::span<const double> y,
                             std::span<const double> spacing, const PlaneDomain& domain) {
  check_spacing(spacing, x.size());
  const double reach = reach_of(map.parameters);
  add_planar(
      map, x, y, domain, [&](std::uint32_t i) { return reach * spacing[i]; },
      [&](MapBlock& block, std::uint32_t i, std::uint32_t j, double dx, double dy) {
        const double most = reach * spacing[j];
        if (dx * dx + dy * dy > most * most) return;
        const double scale = 2 / (spacing[i] + spacing[j]);
        block.add(scale * dx, scale * dy, 1);
      });
}

void add_anisotropic_differences(DifferenceMap& map, std::span<const double> x, std::span<const double> y,
                                 std::span<const double> inverse_jacobian, const PlaneDomain& domain) {
  require(inverse_jacobian.size() == 4 * x.size(), "differences: four numbers of J^-1 a sample");
  check_finite(inverse_jacobian);
  const double reach = reach_of(map.parameters);
  // |J^-1 d| <= reach is within |d| <= reach / least stretch of J^-1.
  std::vector<double> radius(x.size());
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double stretch = least_stretch(inverse_jacobian.data() + 4 * i);
    require(stretch > 0, "differences: J^-1 must not be singular");
    radius[i] = reach / stretch * (1 + 1e-12);
  }
  add_planar(
      map, x, y, domain, [&](std::uint32_t i) { return radius[i]; },
      [&](MapBlock& block, std::uint32_t i, std::uint32_t j, double dx, double dy) {
        const auto a = times(inverse_jacobian.data() + 4 * std::size_t{i}, dx, dy);
        const auto b = times(inverse_jacobian.data() + 4 * std::size_t{j}, dx, dy);
        if (std::max(a[0] * a[0] + a[1] * a[1], b[0] * b[0] + b[1] * b[1]) > reach * reach) return;
        block.add(0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1]), 1);
      });
}

void add_anisotropic_differences(DifferenceMap& map, std::span<const double> x, std::span<const double> y,
                                 std::span<const TangentTensor> log_spacing,
                                 const TensorDifferenceParameters& parameters, const PlaneDomain& domain) {
  const std::size_t samples = x.size();
  require(log_spacing.size() == samples, "differences: one tensor a sample");
  const std::vector<double> weight = half_weights(parameters.counted, samples);
  const bool by_area = parameters.units == DifferenceUnits::area;
  const double reach = reach_of(map.parameters);
  std::vector<TangentTensor> inverse(samples);  // what differences are multiplied with
  std::vector<TensorAxes> axes(samples);
  std::vector<double> radius(samples);
  for (std::size_t i = 0; i < samples; ++i) {
    const TangentTensor log_s = log_spacing[i];
    require(std::isfinite(log_s.xx) && std::isfinite(log_s.xy) && std::isfinite(log_s.yy),
            "differences: tensors must be finite");
    axes[i] = spacings_of(log_s);
    const double size = std::sqrt(axes[i].first * axes[i].second);
    require(axes[i].second > 0 && std::isfinite(axes[i].first), "differences: tensors out of range");
    inverse[i] = by_area ? TangentTensor{1 / size, 0, 1 / size} : exponential(-1.0 * log_s);
    radius[i] = reach * (by_area ? size : axes[i].first) * (1 + 1e-12);
  }
  add_planar(
      map, x, y, domain, [&](std::uint32_t i) { return radius[i]; },
      [&](MapBlock& block, std::uint32_t i, std::uint32_t j, double dx, double dy) {
        const auto a = times(inverse[i], dx, dy), b = times(inverse[j], dx, dy);
        if (std::max(square(a), square(b)) > reach * reach || weight[i] + weight[j] == 0) return;
        const double qx = 0.5 * (a[0] + b[0]), qy = 0.5 * (a[1] + b[1]);
        if (!parameters.principal_axes) {
          block.add(qx, qy, weight[i] + weight[j]);
          return;
        }
        for (const std::uint32_t k : {i, j})
          if (weight[k] > 0)
            block.add(axes[k].x * qx + axes[k].y * qy, axes[k].x * qy - axes[k].y * qx, weight[k]);
      });
}

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

std::vector<double> spacing_from_density(std::span<const double> density, double measure, double largest) {
  require(measure > 0 && std::isfinite(measure), "spacing_from_density: the measure must be positive");
  require(largest > 0, "spacing_from_density: the largest spacing must be positive");
  std::vector<double> spacing;
  spacing.reserve(density.size());
  for (const double phi : density) {
    require(phi >= 0 && std::isfinite(phi), "spacing_from_density: densities are finite and not negative");
    spacing.push_back(std::min(largest, std::sqrt(measure / (static_cast<double>(density.size()) * phi))));
    require(std::isfinite(spacing.back()), "spacing_from_density: a density of 0 needs a largest spacing");
  }
  return spacing;
}

DifferenceMap expected_differences(const DifferenceParameters& parameters, std::uint64_t samples) {
  DifferenceMap map = make_difference_map(parameters);
  const double pairs = samples > 0 ? static_cast<double>(samples - 1) : 0;
  std::fill(map.sum.begin(), map.sum.end(), pairs * map.cell() * map.cell());
  map.sets = 1;
  return map;
}

DifferenceMap expected_differences(const DifferenceParameters& parameters, std::uint64_t samples,
                                   double width, double height) {
  require(width > 0 && height > 0 && std::isfinite(width) && std::isfinite(height),
          "expected_differences: a rectangle has a width and a height");
  DifferenceMap map = expected_differences(parameters, samples);
  // The expectation is a product: along each axis, the share of the domain that overlaps itself after the
  // shift, spread by the kernel from finely spaced shifts.
  constexpr int steps = 64;  // per cell
  const double spacing = std::sqrt(width * height / static_cast<double>(std::max<std::uint64_t>(samples, 1)));
  const auto along = [&](double extent) {
    std::vector<double> share(map.side(), 0.0);
    AxisWeights weights;
    const double margin = std::ceil(cut_off * parameters.kernel) + 1;
    const double count = (static_cast<double>(map.side()) + 2 * margin) * steps;
    for (double k = 0; k < count; ++k) {
      const double at_cell = (k + 0.5) / steps - margin - 0.5;
      const double shift = spacing * ((at_cell + 0.5) * map.cell() - parameters.range);
      const double overlap = std::max(0.0, 1 - std::abs(shift) / extent);
      weigh(at_cell, parameters.kernel, weights);
      for (std::size_t i = 0; i < weights.count; ++i) {
        const std::ptrdiff_t cell = weights.first + static_cast<std::ptrdiff_t>(i);
        if (cell >= 0 && cell < static_cast<std::ptrdiff_t>(map.side()))
          share[static_cast<std::size_t>(cell)] += weights.weight[i] * overlap / steps;
      }
    }
    return share;
  };
  const std::vector<double> across = along(width), up = along(height);
  for (std::size_t j = 0; j < map.side(); ++j)
    for (std::size_t i = 0; i < map.side(); ++i) map.sum[j * map.side() + i] *= across[i] * up[j];
  return map;
}

std::vector<double> normalised_differences(const DifferenceMap& map, const DifferenceMap& expected) {
  require(map.parameters.range == expected.parameters.range &&
              map.parameters.cells == expected.parameters.cells &&
              map.parameters.kernel == expected.parameters.kernel,
          "normalised_differences: both maps need the same parameters");
  require(map.sets > 0 && expected.sets > 0, "normalised_differences: a map without sets");
  std::vector<double> ratio(map.sum.size());
  const double scale = static_cast<double>(expected.sets) / map.sets;
  for (std::size_t c = 0; c < ratio.size(); ++c)
    ratio[c] =
        expected.sum[c] > 0 ? scale * map.sum[c] / expected.sum[c] : std::numeric_limits<double>::quiet_NaN();
  return ratio;
}

RadialProfile radial_differences(const DifferenceMap& map, std::span<const double> normalised, double width) {
  require(width >= 1, "radial_differences: rings are at least one cell wide");
  return radial_profile(normalised, map.side(), 0, width);
}

}  // namespace meander
