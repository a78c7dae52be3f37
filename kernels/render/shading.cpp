#include "kernels/render/shading.h"

#include <algorithm>
#include <cmath>

namespace meander {

namespace {

// Mean over a square window of 2 reach + 1, along one axis, with running sums; the border repeats. `lines` of
// `size` values `step` apart begin `line` apart.
void blur(std::vector<float>& values, std::int64_t size, std::int64_t lines, std::int64_t reach,
          std::int64_t step, std::int64_t line) {
  std::vector<float> row(static_cast<std::size_t>(size));
  const float share = 1.0f / static_cast<float>(2 * reach + 1);
  for (std::int64_t l = 0; l < lines; ++l) {
    const auto at = [&](std::int64_t i) -> float& {
      return values[static_cast<std::size_t>(l * line + std::clamp<std::int64_t>(i, 0, size - 1) * step)];
    };
    double sum = 0;
    for (std::int64_t i = -reach; i <= reach; ++i) sum += at(i);
    for (std::int64_t i = 0; i < size; ++i) {
      row[static_cast<std::size_t>(i)] = static_cast<float>(sum) * share;
      sum += at(i + reach + 1) - at(i - reach);
    }
    for (std::int64_t i = 0; i < size; ++i) at(i) = row[static_cast<std::size_t>(i)];
  }
}

}  // namespace

float light_on(Vector3 normal) {
  static const Vector3 key = unit_vector({-0.45, -0.65, 0.75}), fill = unit_vector({0.7, 0.35, 0.4});
  const double lit = 0.34 + 0.62 * std::max(0.0, dot(normal, key)) + 0.16 * std::max(0.0, dot(normal, fill));
  return static_cast<float>(lit);
}

void darken_hollows(const std::vector<float>& depth, std::vector<float>& light, std::int64_t width,
                    std::int64_t height, float background) {
  const std::int64_t size = std::max(width, height);
  std::vector<float> smooth(depth.size());
  for (std::size_t i = 0; i < smooth.size(); ++i) smooth[i] = depth[i] == empty_depth ? background : depth[i];
  const std::int64_t reach = std::max<std::int64_t>(1, size / 40);
  for (int pass = 0; pass < 2; ++pass) {
    blur(smooth, width, height, reach, 1, width);
    blur(smooth, height, width, reach, width, 1);
  }
  const float unit_depth = static_cast<float>(size) * 0.05f;
  for (std::size_t i = 0; i < smooth.size(); ++i) {
    if (depth[i] == empty_depth) continue;
    const float hollow = std::clamp((smooth[i] - depth[i]) / unit_depth, 0.0f, 1.0f);
    light[i] *= 1 - 0.55f * hollow;
  }
}

std::uint8_t srgb_byte(float linear) {
  const float c = std::clamp(linear, 0.0f, 1.0f);
  const float s = c <= 0.0031308f ? 12.92f * c : 1.055f * std::pow(c, 1 / 2.4f) - 0.055f;
  return static_cast<std::uint8_t>(std::lround(255 * s));
}

float linear_light(std::uint8_t byte) {
  const float s = static_cast<float>(byte) / 255;
  return s <= 0.04045f ? s / 12.92f : std::pow((s + 0.055f) / 1.055f, 2.4f);
}

}  // namespace meander
