#include "kernels/render/seen_samples.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "kernels/render/shading.h"

namespace meander {

namespace {

Vector3 vector_of_sample(std::span<const float> values, std::size_t i) {
  return {values[3 * i], values[3 * i + 1], values[3 * i + 2]};
}

// Bins of the logarithm of the primary spacings between their 5 % and 95 % quantiles.
std::vector<std::uint8_t> length_bins(std::span<const float> spacings) {
  const std::size_t count = spacings.size() / 2;
  std::vector<float> logs(count), sorted;
  for (std::size_t i = 0; i < count; ++i) {
    const float s = spacings[2 * i];
    logs[i] = s > 0 && std::isfinite(s) ? std::log(s) : std::numeric_limits<float>::quiet_NaN();
    if (std::isfinite(logs[i])) sorted.push_back(logs[i]);
  }
  constexpr auto middle = static_cast<std::uint8_t>(brush_lengths / 2);
  std::vector<std::uint8_t> bins(count, middle);
  if (sorted.empty()) return bins;
  const auto quantile = [&](double q) {
    const auto k = static_cast<std::ptrdiff_t>(q * static_cast<double>(sorted.size() - 1));
    std::nth_element(sorted.begin(), sorted.begin() + k, sorted.end());
    return sorted[static_cast<std::size_t>(k)];
  };
  const float low = quantile(0.05), high = quantile(0.95);
  // Equal but for rounding: nothing to tell apart.
  if (!(high - low > 1e-4f)) return bins;
  for (std::size_t i = 0; i < count; ++i)
    if (std::isfinite(logs[i])) {
      const float t = (logs[i] - low) / (high - low) * static_cast<float>(brush_lengths);
      bins[i] = static_cast<std::uint8_t>(std::clamp(t, 0.0f, static_cast<float>(brush_lengths - 1)));
    }
  return bins;
}

// The pixel of a coordinate; -1 for what lies far outside.
std::int64_t pixel_of(double v) {
  return v > -1e9 && v < 1e9 ? static_cast<std::int64_t>(std::floor(v)) : -1;
}

}  // namespace

Lighting::Lighting(const StrokeModel& model, const StrokePictureParameters& parameters,
                   const PictureView& view) {
  const Vector3 wanted = parameters.light;
  towards_ = unit_vector({wanted.x, -wanted.y, wanted.z});
  world_ = towards_.x * view.right + towards_.y * view.down + towards_.z * view.back;
  const std::uint32_t size = std::clamp(parameters.height, 256u, 1024u);
  // Any direction not along the light.
  const Vector3 side = std::abs(world_.x) < 0.6 ? Vector3{1, 0, 0} : Vector3{0, 1, 0};
  view_ = framed_view(model.positions, world_, side, size, size, 2);
  seen_ = depth_picture(view_, model.positions, model.faces, size, size);
}

double Lighting::arriving(Vector3 point, double facing) const {
  const Vector3 at = view_.point(point);
  const double bias = 3 + 3 / std::max(0.15, std::abs(facing));
  int lit = 0;
  for (int k = 0; k < 9; ++k) {
    const auto x = pixel_of(at.x) + 2 * (k % 3 - 1), y = pixel_of(at.y) + 2 * (k / 3 - 1);
    lit += !seen_.covered(x, y) ||
           static_cast<double>(
               seen_.depth[static_cast<std::size_t>(y) * seen_.width + static_cast<std::size_t>(x)]) <=
               at.z + bias;
  }
  return lit / 9.0;
}

double Lighting::on(Vector3 normal, double arrives, double hollow) const {
  const double wrapped = std::max(0.0, (dot(normal, towards_) + 0.15) / 1.15);
  const double key = std::pow(wrapped, 1.15) * (0.22 + 0.78 * arrives);
  const Vector3 from_below = unit_vector({-0.8 * towards_.x, -0.6 * towards_.y, 0.25});
  const double reflected = std::max(0.0, dot(normal, from_below));
  return std::clamp((0.07 + 0.84 * key + 0.13 * reflected) * (1 - 0.5 * hollow), 0.0, 1.0);
}

double Lighting::shine(Vector3 normal, double arrives) const {
  const Vector3 half = unit_vector(towards_ + Vector3{0, 0, 1});
  return arrives * std::pow(std::max(0.0, dot(normal, half)), 24);
}

std::vector<SeenSample> seen_samples(const StrokeModel& model, const PictureView& view,
                                     const DepthPicture& depth, const Lighting& lighting) {
  const std::vector<std::uint8_t> bins = length_bins(model.spacings);
  const std::vector<float> hollow =
      hollowness(depth.depth, depth.width, depth.height, static_cast<float>(depth.far));
  std::vector<SeenSample> seen;
  for (std::size_t i = 0; i < model.points.size() / 3; ++i) {
    const Vector3 point{model.points[3 * i], model.points[3 * i + 1], model.points[3 * i + 2]};
    const Vector3 at = view.point(point);
    Vector3 normal = view.direction(vector_of_sample(model.normals, i)),
            along = view.direction(vector_of_sample(model.directions, i));
    if (!finite_vector(at) || !(norm(normal) > 0.5) || !(norm(along) > 0.5)) continue;
    normal = unit_vector(normal);
    // Just behind the silhouette, where the depth buffer lets samples through: turned to the eye, their
    // normals would face the wrong way, and the rim in the light be strewn with strokes of shadow.
    if (normal.z < 0 && normal.z > -0.1) continue;
    if (normal.z < 0) normal = -1.0 * normal;
    const auto x = pixel_of(at.x), y = pixel_of(at.y);
    if (!depth.covered(x, y)) continue;
    const std::size_t pixel = static_cast<std::size_t>(y) * depth.width + static_cast<std::size_t>(x);
    // Within its pixel a surface that is seen at this slope differs so much in depth.
    const double bias = 0.5 + 0.75 * std::min(8.0, std::sqrt(std::max(0.0, 1 - normal.z * normal.z)) /
                                                       std::max(normal.z, 0.05));
    if (at.z + bias < double{depth.depth[pixel]}) continue;
    const double arrives = lighting.arriving(point, dot(normal, lighting.towards()));
    seen.push_back({static_cast<std::uint32_t>(i), at, normal, unit_vector(along),
                    lighting.on(normal, arrives, hollow[pixel]), lighting.shine(normal, arrives), bins[i]});
  }
  return seen;
}

SeenGrid::SeenGrid(std::span<const SeenSample> seen, std::uint32_t width, std::uint32_t height, double cell,
                   bool contours)
    : cell_(cell),
      columns_(static_cast<std::int64_t>(width / cell) + 2),
      rows_(static_cast<std::int64_t>(height / cell) + 2),
      directions_(static_cast<std::size_t>(columns_ * rows_)),
      lights_(directions_.size()) {
  for (const SeenSample& sample : seen) {
    auto& light = lights_[index(sample.at.x, sample.at.y)];
    light[0] += sample.light;
    ++light[1];
    const Vector3 along = contours ? cross(sample.normal, {0, 0, 1}) : sample.along;
    if (along.x * along.x + along.y * along.y < 1e-6) continue;
    auto& sum = directions_[index(sample.at.x, sample.at.y)];
    // The doubled angle, weighted by how long the direction is seen.
    sum[0] += along.x * along.x - along.y * along.y;
    sum[1] += 2 * along.x * along.y;
  }
}

double SeenGrid::turn(double x, double y, double cosine, double sine) const {
  const auto& sum = directions_[index(x, y)];
  const double c = cosine * cosine - sine * sine, s = 2 * cosine * sine;
  if (sum[0] * sum[0] + sum[1] * sum[1] < 1e-12) return 0;
  return 0.5 * std::atan2(sum[1] * c - sum[0] * s, sum[0] * c + sum[1] * s);
}

double SeenGrid::light(double x, double y, double own) const {
  double sum = 0, count = 0;
  for (int k = 0; k < 9; ++k) {
    const auto& light = lights_[index(x + (k % 3 - 1) * cell_, y + (k / 3 - 1) * cell_)];
    sum += light[0];
    count += light[1];
  }
  return count > 0 ? sum / count : own;
}

std::size_t SeenGrid::index(double x, double y) const {
  const auto column = std::clamp(static_cast<std::int64_t>(x / cell_), std::int64_t{0}, columns_ - 1),
             row = std::clamp(static_cast<std::int64_t>(y / cell_), std::int64_t{0}, rows_ - 1);
  return static_cast<std::size_t>(row * columns_ + column);
}
}  // namespace meander
