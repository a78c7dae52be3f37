#include "kernels/surface/height_field.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "kernels/core/status.h"
#include "kernels/surface/digest_bytes.h"

namespace meander {

namespace {

// Weights of the four samples -1, 0, 1, 2 around a cell, for the value and its first two derivatives by the
// cell's own coordinate.
struct Stencil {
  std::array<double, 4> value{}, first{}, second{};
};

Stencil linear_stencil(double t) {
  Stencil s;
  s.value = {0, 1 - t, t, 0};
  s.first = {0, -1, 1, 0};
  return s;
}

Stencil cubic_stencil(double t) {
  Stencil s;
  s.value = {t * (-0.5 + t * (1 - 0.5 * t)), 1 + t * t * (-2.5 + 1.5 * t), t * (0.5 + t * (2 - 1.5 * t)),
             t * t * (-0.5 + 0.5 * t)};
  s.first = {-0.5 + t * (2 - 1.5 * t), t * (-5 + 4.5 * t), 0.5 + t * (4 - 4.5 * t), t * (-1 + 1.5 * t)};
  s.second = {2 - 3 * t, -5 + 9 * t, 4 - 9 * t, -1 + 3 * t};
  return s;
}

class HeightField final : public PointwiseSurface<HeightField> {
 public:
  HeightField(std::span<const float> heights, std::size_t width, std::size_t height,
              const HeightFieldParameters& parameters)
      : width_(width), height_(height), parameters_(parameters), heights_(heights.begin(), heights.end()) {
    DigestBytes digest;
    digest.add(std::uint64_t{width});
    digest.add(static_cast<std::uint64_t>(parameters.interpolation));
    for (const double value : {parameters.extent_x, parameters.extent_y, parameters.scale}) digest.add(value);
    for (const float value : heights_) digest.add(static_cast<double>(value));
    content_ = digest.bytes();
  }

  std::string_view name() const override { return "height-field"; }
  std::array<std::uint8_t, 16> content() const override { return content_; }

 private:
  friend class PointwiseSurface<HeightField>;

  // The height at a grid point that may lie one step outside, where the field is extrapolated linearly.
  double sample(std::ptrdiff_t column, std::ptrdiff_t row) const {
    const auto along_row = [&](std::ptrdiff_t r) {
      const auto at = [&](std::ptrdiff_t c) {
        return static_cast<double>(
            heights_[static_cast<std::size_t>(r) * width_ + static_cast<std::size_t>(c)]);
      };
      const auto last = static_cast<std::ptrdiff_t>(width_) - 1;
      if (column < 0) return 2 * at(0) - at(1);
      if (column > last) return 2 * at(last) - at(last - 1);
      return at(column);
    };
    const auto last = static_cast<std::ptrdiff_t>(height_) - 1;
    if (row < 0) return 2 * along_row(0) - along_row(1);
    if (row > last) return 2 * along_row(last) - along_row(last - 1);
    return along_row(row);
  }

  SurfaceJet jet(double u, double v, int) const {
    const double cells_u = static_cast<double>(width_ - 1), cells_v = static_cast<double>(height_ - 1);
    const double column = std::min(std::floor(u * cells_u), cells_u - 1),
                 row = std::min(std::floor(v * cells_v), cells_v - 1);
    const bool linear = parameters_.interpolation == HeightInterpolation::bilinear;
    const double s = u * cells_u - column, t = v * cells_v - row;
    const Stencil a = linear ? linear_stencil(s) : cubic_stencil(s),
                  b = linear ? linear_stencil(t) : cubic_stencil(t);
    double z = 0, zu = 0, zv = 0, zuu = 0, zuv = 0, zvv = 0;
    const std::size_t from = linear ? 1 : 0, to = linear ? 3 : 4;
    for (std::size_t j = from; j < to; ++j) {
      double value = 0, first = 0, second = 0;
      for (std::size_t i = from; i < to; ++i) {
        const double h = sample(static_cast<std::ptrdiff_t>(column) + static_cast<std::ptrdiff_t>(i) - 1,
                                static_cast<std::ptrdiff_t>(row) + static_cast<std::ptrdiff_t>(j) - 1);
        value += a.value[i] * h;
        first += a.first[i] * h;
        second += a.second[i] * h;
      }
      z += b.value[j] * value;
      zu += b.value[j] * first;
      zuu += b.value[j] * second;
      zv += b.first[j] * value;
      zuv += b.first[j] * first;
      zvv += b.second[j] * value;
    }
    const double scale = parameters_.scale;
    return {{parameters_.extent_x * u, parameters_.extent_y * v, scale * z},
            {parameters_.extent_x, 0, scale * cells_u * zu},
            {0, parameters_.extent_y, scale * cells_v * zv},
            {0, 0, scale * cells_u * cells_u * zuu},
            {0, 0, scale * cells_u * cells_v * zuv},
            {0, 0, scale * cells_v * cells_v * zvv}};
  }

  std::size_t width_, height_;
  HeightFieldParameters parameters_;
  std::vector<float> heights_;
  std::array<std::uint8_t, 16> content_{};
};

}  // namespace

std::unique_ptr<ParametricSurface> make_height_field(std::span<const float> heights, std::size_t width,
                                                     std::size_t height,
                                                     const HeightFieldParameters& parameters) {
  if (width < 2 || height < 2)
    throw ItemError(Status::unreadable, "a height field needs at least 2 x 2 heights, not " +
                                            std::to_string(width) + " x " + std::to_string(height));
  if (heights.size() / width != height || heights.size() % width != 0)
    throw ItemError(Status::unreadable, "there are " + std::to_string(heights.size()) + " heights, not " +
                                            std::to_string(width) + " x " + std::to_string(height));
  const auto positive = [](double x) { return x > 0 && std::isfinite(x); };
  if (!positive(parameters.extent_x) || !positive(parameters.extent_y) || !std::isfinite(parameters.scale))
    throw ItemError(Status::unreadable,
                    "the extents of a height field must be positive and finite, its scale finite");
  for (std::size_t i = 0; i < heights.size(); ++i)
    if (!std::isfinite(heights[i]))
      throw ItemError(Status::non_finite, "the height in column " + std::to_string(i % width) + " of row " +
                                              std::to_string(i / width) + " is not finite");
  return std::make_unique<HeightField>(heights, width, height, parameters);
}

}  // namespace meander
