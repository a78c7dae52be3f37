#include "kernels/render/section_picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "kernels/core/parallel.h"

namespace meander {

namespace {

constexpr double bands = 40;         // of distance, in the width of the picture
constexpr double least_light = 0.5;  // of the band that is farthest from the surface
constexpr double line_width = 1.6;   // pixels
constexpr std::uint32_t hatch = 3;   // pixels

std::array<double, 3> axes_of(Vector3 v) { return {v.x, v.y, v.z}; }

// From places in the plane to pixels.
struct Frame {
  std::size_t right, up;  // axes
  std::array<double, 2> middle;
  double pixel;  // working units
  double half;   // of the size, pixels

  double column(double right_at) const { return (right_at - middle[0]) / pixel + half; }
  double row(double up_at) const { return half - (up_at - middle[1]) / pixel; }
};

Frame frame_of(const PreparedMesh& mesh, const SectionParameters& parameters) {
  std::array<double, 3> low, high;
  low.fill(1);
  high.fill(-1);
  for (const std::uint32_t v : mesh.triangles) {
    const std::array<double, 3> at = axes_of(mesh.position(v));
    for (std::size_t k = 0; k < 3; ++k) {
      low[k] = std::min(low[k], at[k]);
      high[k] = std::max(high[k], at[k]);
    }
  }
  Frame frame{parameters.axis == 0 ? 1u : 0u, parameters.axis == 2 ? 1u : 2u, {}, 1, 0};
  frame.middle = {0.5 * (low[frame.right] + high[frame.right]), 0.5 * (low[frame.up] + high[frame.up])};
  const double extent = std::max(high[frame.right] - low[frame.right], high[frame.up] - low[frame.up]);
  frame.pixel = (extent > 0 ? extent : 1) / (parameters.size * (1 - 2 * parameters.margin));
  frame.half = 0.5 * parameters.size;
  return frame;
}

std::vector<double> pixel_middles(const Frame& frame, const SectionParameters& parameters) {
  std::vector<double> points;
  points.reserve(std::size_t{3} * parameters.size * parameters.size);
  for (std::uint32_t row = 0; row < parameters.size; ++row)
    for (std::uint32_t column = 0; column < parameters.size; ++column) {
      std::array<double, 3> at{};
      at[parameters.axis] = parameters.at;
      at[frame.right] = frame.middle[0] + (column + 0.5 - frame.half) * frame.pixel;
      at[frame.up] = frame.middle[1] - (row + 0.5 - frame.half) * frame.pixel;
      points.insert(points.end(), at.begin(), at.end());
    }
  return points;
}

// How much of each pixel the outline covers.
class Outline {
 public:
  explicit Outline(std::uint32_t size) : size_(size), covered_(std::size_t{size} * size, 0) {}

  float covered(std::size_t pixel) const { return covered_[pixel]; }

  void add(std::array<double, 2> from, std::array<double, 2> to) {
    const double reach = 0.5 * line_width + 0.5;
    const auto [first_column, last_column] = pixels_between(from[0], to[0], reach);
    const auto [first_row, last_row] = pixels_between(from[1], to[1], reach);
    const double u = to[0] - from[0], v = to[1] - from[1], squared = u * u + v * v;
    for (std::int64_t row = first_row; row <= last_row; ++row)
      for (std::int64_t column = first_column; column <= last_column; ++column) {
        const double x = static_cast<double>(column) + 0.5 - from[0],
                     y = static_cast<double>(row) + 0.5 - from[1];
        const double along = squared > 0 ? std::clamp((x * u + y * v) / squared, 0.0, 1.0) : 0;
        const double away = norm({x - along * u, y - along * v, 0});
        float& covered = covered_[static_cast<std::size_t>(row) * size_ + static_cast<std::size_t>(column)];
        covered = std::max(covered, static_cast<float>(std::clamp(reach - away, 0.0, 1.0)));
      }
  }

 private:
  std::pair<std::int64_t, std::int64_t> pixels_between(double a, double b, double reach) const {
    const double last = static_cast<double>(size_) - 1;
    return {static_cast<std::int64_t>(std::clamp(std::floor(std::min(a, b) - reach), 0.0, last + 1)),
            static_cast<std::int64_t>(std::clamp(std::floor(std::max(a, b) + reach), -1.0, last))};
  }

  std::uint32_t size_;
  std::vector<float> covered_;
};

Outline outline_of(const PreparedMesh& mesh, const Frame& frame, const SectionParameters& parameters) {
  Outline outline(parameters.size);
  for (std::size_t t = 0; t < mesh.triangle_count(); ++t) {
    std::array<std::array<double, 2>, 2> ends;
    std::size_t count = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::array<double, 3> a = axes_of(mesh.position(mesh.triangles[3 * t + k])),
                                  b = axes_of(mesh.position(mesh.triangles[3 * t + (k + 1) % 3]));
      const double from = a[parameters.axis] - parameters.at, to = b[parameters.axis] - parameters.at;
      if ((from >= 0) == (to >= 0)) continue;
      const double along = from / (from - to);
      ends[count++] = {frame.column(a[frame.right] + along * (b[frame.right] - a[frame.right])),
                       frame.row(a[frame.up] + along * (b[frame.up] - a[frame.up]))};
    }
    if (count == 2) outline.add(ends[0], ends[1]);
  }
  return outline;
}

}  // namespace

Section section_picture(const PreparedMesh& mesh, const TriangleTree& tree, const OrientedSurface& oriented,
                        SignRule rule, const SectionParameters& parameters, const CancelToken& cancel) {
  if (parameters.axis > 2 || parameters.size < 16 || parameters.size > 4096 ||
      !(parameters.margin >= 0 && parameters.margin < 0.5) || !(std::abs(parameters.at) <= farthest_point))
    throw std::invalid_argument(
        "section_picture: an axis of 0 to 2, a finite place, 16 to 4096 pixels, a margin below 0.5");
  const Frame frame = frame_of(mesh, parameters);
  const std::vector<double> points = pixel_middles(frame, parameters);
  const LabeledPoints labels = label_points(tree, oriented, rule, points, cancel);
  const PointSides& sides = labels.sides;
  const Outline outline = outline_of(mesh, frame, parameters);
  Section section;
  section.picture = RgbImage(parameters.size, parameters.size);
  for (std::uint32_t row = 0; row < parameters.size; ++row)
    for (std::uint32_t column = 0; column < parameters.size; ++column) {
      const std::size_t i = std::size_t{row} * parameters.size + column;
      const bool inside = sides.inside[i] != 0, certain = sides.certain[i] != 0;
      section.inside += inside;
      section.uncertain += !certain;
      const double band = std::floor(labels.nearest.distance[i] / (frame.pixel * parameters.size) * bands);
      const double light = least_light + (1 - least_light) / (1 + 0.15 * band);
      SrgbColor color = rule == SignRule::none ? section_without_side
                        : inside               ? section_inside
                                               : section_outside;
      if (rule != SignRule::none && !certain && (row + column) / hatch % 2 == 0) color = section_uncertain;
      for (std::size_t k = 0; k < 3; ++k)
        section.picture.pixel(column, row)[k] = static_cast<std::uint8_t>(
            std::lround(color[k] * light * (1 - static_cast<double>(outline.covered(i)))));
    }
  const auto pixels = static_cast<double>(points.size() / 3);
  section.inside /= pixels;
  section.uncertain /= pixels;
  return section;
}

}  // namespace meander
