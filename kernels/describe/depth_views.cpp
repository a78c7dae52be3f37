#include "kernels/describe/depth_views.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <span>
#include <stdexcept>

#include "kernels/core/portable_angles.h"
#include "kernels/core/vector3.h"
#include "kernels/describe/shape_moments.h"

namespace meander {

namespace {

constexpr int max_pixels_across = 128, min_pixels_across = 16;
constexpr double max_drawn_pixels = 1 << 26;  // of one view
constexpr double half_width = 2;              // of the cube, over the root mean square radius
constexpr int highest = view_magnitude_radius;
constexpr std::size_t checked_triangles = 1 << 16;  // between two checks of the deadline

// Positions in the principal frame, where the cube is [-1, 1]^3.
std::array<std::vector<double>, 3> principal_positions(const PreparedMesh& mesh) {
  const ShapeMoments moments = shape_moments(mesh.x, mesh.y, mesh.z, mesh.triangles);
  const std::array<double, 6>& inertia = moments.inertia;
  // The trace of the inertia tensor is twice the integral of the squared distance.
  const double radius = std::sqrt((inertia[0] + inertia[1] + inertia[2]) / (2 * moments.area));
  std::array<std::vector<double>, 3> positions;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Vector3 direction = (1 / (half_width * radius)) * moments.principal_axes[axis];
    positions[axis].resize(mesh.vertex_count());
    for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v)
      positions[axis][v] = dot(mesh.position(v) - moments.centroid, direction);
  }
  return positions;
}

// The interval of coordinates along the line of sight in every pixel, min > max where there is no surface.
struct DepthRange {
  int across = 0;
  std::vector<double> min, max;
};

// Draws the surface as seen along one axis; the other two, in order, are right and up.
class Rasterizer {
 public:
  Rasterizer(const PreparedMesh& mesh, const std::array<std::vector<double>, 3>& positions, std::size_t axis,
             const CancelToken& cancel)
      : mesh_(mesh),
        right_(positions[axis == 0 ? 1 : 0]),
        up_(positions[axis == 2 ? 1 : 2]),
        depth_(positions[axis]),
        cancel_(cancel) {}

  DepthRange draw() const {
    DepthRange range;
    range.across = max_pixels_across;
    while (range.across > min_pixels_across && pixels_at(range.across) > max_drawn_pixels) range.across /= 2;
    const auto count = static_cast<std::size_t>(range.across) * static_cast<std::size_t>(range.across);
    range.min.assign(count, 2);
    range.max.assign(count, -2);
    for (std::size_t t = 0; t < mesh_.triangle_count(); ++t) {
      if (t % checked_triangles == 0) cancel_.check();
      draw(t, range);
    }
    return range;
  }

 private:
  struct Corner {
    double x, y, z;  // x, y in pixels, the center of pixel i at i; z: depth
  };

  std::array<Corner, 3> corners(std::size_t triangle, int across) const {
    std::array<Corner, 3> result;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t v = mesh_.triangles[3 * triangle + k];
      result[k] = {(right_[v] + 1) * across / 2 - 0.5, (up_[v] + 1) * across / 2 - 0.5, depth_[v]};
    }
    return result;
  }

  // An upper bound of the pixels drawn: rows and half of the area, because boxes would be too large for
  // needles.
  double pixels_at(int across) const {
    double sum = 0;
    for (std::size_t t = 0; t < mesh_.triangle_count(); ++t) {
      const auto [a, b, c] = corners(t, across);
      const double rows = std::max({a.y, b.y, c.y}) - std::min({a.y, b.y, c.y});
      const double area = std::abs((b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y)) / 2;
      sum += std::min(1.0 * across * across, rows + area);
    }
    return sum;
  }

  void draw(std::size_t triangle, DepthRange& range) const {
    std::array<Corner, 3> corner = corners(triangle, range.across);
    const auto [a, b, c] = corner;
    const double det = (b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y);
    if (det == 0) return;  // seen edge-on
    const double right = ((b.z - a.z) * (c.y - a.y) - (c.z - a.z) * (b.y - a.y)) / det;
    const double up = ((b.x - a.x) * (c.z - a.z) - (c.x - a.x) * (b.z - a.z)) / det;
    const double low = std::min({a.z, b.z, c.z}), high = std::max({a.z, b.z, c.z});
    std::sort(corner.begin(), corner.end(), [](const Corner& p, const Corner& q) { return p.y < q.y; });
    const double last = range.across - 1;
    const auto first_row = static_cast<int>(std::ceil(std::clamp(corner[0].y, 0.0, last + 1)));
    const auto last_row = static_cast<int>(std::floor(std::clamp(corner[2].y, -1.0, last)));
    const auto at_row = [](const Corner& p, const Corner& q, double y) {
      return q.y > p.y ? p.x + (q.x - p.x) * ((y - p.y) / (q.y - p.y)) : p.x;
    };
    for (int row = first_row; row <= last_row; ++row) {
      const double y = row;
      const double one = at_row(corner[0], corner[2], y);
      const double other =
          y < corner[1].y ? at_row(corner[0], corner[1], y) : at_row(corner[1], corner[2], y);
      const auto begin = static_cast<int>(std::ceil(std::clamp(std::min(one, other), 0.0, last + 1)));
      const auto end = static_cast<int>(std::floor(std::clamp(std::max(one, other), -1.0, last)));
      for (int column = begin; column <= end; ++column) {
        const double z = std::clamp(a.z + right * (column - a.x) + up * (y - a.y), low, high);
        const auto pixel = static_cast<std::size_t>(row * range.across + column);
        range.min[pixel] = std::min(range.min[pixel], z);
        range.max[pixel] = std::max(range.max[pixel], z);
      }
    }
  }

  const PreparedMesh& mesh_;
  const std::vector<double>&right_, &up_, &depth_;
  const CancelToken& cancel_;
};

// The four parts of a Fourier coefficient: sums over the pixels of the image times cos or sin of u x, times
// cos or sin of v y, with x and y from the center.
struct FourierParts {
  double cos_cos = 0, cos_sin = 0, sin_cos = 0, sin_sin = 0;

  // The mean of the roots of the magnitudes at (u, v) and (-u, v).
  double mean_root() const {
    const double re = cos_cos - sin_sin, im = cos_sin + sin_cos;
    const double mirrored_re = cos_cos + sin_sin, mirrored_im = cos_sin - sin_cos;
    return (std::sqrt(std::sqrt(re * re + im * im)) +
            std::sqrt(std::sqrt(mirrored_re * mirrored_re + mirrored_im * mirrored_im))) /
           2;
  }
};

constexpr std::size_t frequencies = highest + 1;
using Spectrum = std::array<FourierParts, frequencies * frequencies>;  // v slower than u

Spectrum transform(std::span<const double> image, int across) {
  const auto side = static_cast<std::size_t>(across);
  std::vector<Direction> wave(frequencies * side);  // cos and sin of u x
  for (std::size_t u = 0; u < frequencies; ++u)
    for (std::size_t x = 0; x < side; ++x) {
      const double from_center = static_cast<double>(x) + 0.5 - static_cast<double>(side) / 2;
      wave[u * side + x] = direction_of(2 * std::numbers::pi * static_cast<double>(u) * from_center /
                                        static_cast<double>(side));
    }
  Spectrum spectrum{};
  const double pixel = 1 / (static_cast<double>(side) * static_cast<double>(side));
  for (std::size_t y = 0; y < side; ++y)
    for (std::size_t u = 0; u < frequencies; ++u) {
      double cosine = 0, sine = 0;
      for (std::size_t x = 0; x < side; ++x) {
        cosine += image[y * side + x] * wave[u * side + x].cosine;
        sine += image[y * side + x] * wave[u * side + x].sine;
      }
      for (std::size_t v = 0; v < frequencies; ++v) {
        const Direction turn = wave[v * side + y];
        FourierParts& parts = spectrum[v * frequencies + u];
        parts.cos_cos += pixel * cosine * turn.cosine;
        parts.cos_sin += pixel * cosine * turn.sine;
        parts.sin_cos += pixel * sine * turn.cosine;
        parts.sin_sin += pixel * sine * turn.sine;
      }
    }
  return spectrum;
}

void add_root(std::vector<float>& values, double value) {
  values.push_back(static_cast<float>(std::sqrt(std::abs(value))));
}

// Adds the values of two opposite views. A turn of the axis swaps them, which changes the sign of
// differences.
void add_views(const Spectrum& one, const Spectrum& other, std::vector<float>& values) {
  const auto for_each_frequency = [&](std::uint32_t radius, const auto& body) {
    for (std::uint32_t v = 0; v <= radius; ++v)
      for (std::uint32_t u = 0; u * u + v * v <= radius * radius; ++u) body(u, v, v * frequencies + u);
  };
  for_each_frequency(view_magnitude_radius, [&](std::uint32_t, std::uint32_t, std::size_t at) {
    const double a = one[at].mean_root(), b = other[at].mean_root();
    values.push_back(static_cast<float>((a + b) / 2));
    values.push_back(static_cast<float>(std::abs(a - b) / 2));
  });
  for_each_frequency(view_part_radius, [&](std::uint32_t u, std::uint32_t v, std::size_t at) {
    const auto add = [&](double a, double b) {
      add_root(values, (a + b) / 2);
      add_root(values, (a - b) / 2);
    };
    add(one[at].cos_cos, other[at].cos_cos);
    if (v > 0) add(one[at].cos_sin, other[at].cos_sin);
    if (u > 0) add(one[at].sin_cos, other[at].sin_cos);
    if (u > 0 && v > 0) add(one[at].sin_sin, other[at].sin_sin);
  });
}

}  // namespace

std::vector<float> depth_views(const PreparedMesh& mesh, const CancelToken& cancel) {
  const std::array<std::vector<double>, 3> positions = principal_positions(mesh);
  std::vector<float> values;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const DepthRange range = Rasterizer(mesh, positions, axis, cancel).draw();
    std::vector<double> from_above(range.min.size()), from_below(range.min.size());
    for (std::size_t i = 0; i < range.min.size(); ++i) {
      if (range.min[i] > range.max[i]) continue;
      from_above[i] = (1 + std::clamp(range.max[i], -1.0, 1.0)) / 2;
      from_below[i] = (1 - std::clamp(range.min[i], -1.0, 1.0)) / 2;
    }
    add_views(transform(from_above, range.across), transform(from_below, range.across), values);
  }
  if (values.size() != depth_view_values) throw std::logic_error("another number of values of depth views");
  return values;
}

}  // namespace meander
