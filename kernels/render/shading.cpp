#include "kernels/render/shading.h"

#include <algorithm>
#include <cmath>

#include "kernels/core/parallel.h"

namespace meander {

namespace {

// Along each of `lines` lines of `length` values, with running sums; the ends repeat.
void blur_lines(std::vector<float>& values, std::int64_t lines, std::int64_t length, std::int64_t line_step,
                std::int64_t value_step, std::int64_t reach) {
  const double share = 1.0 / static_cast<double>(2 * reach + 1);
  parallel_tasks(static_cast<std::size_t>((lines + 63) / 64), [&](std::size_t block) {
    std::vector<float> line(static_cast<std::size_t>(length));
    const auto begin = static_cast<std::int64_t>(64 * block);
    for (std::int64_t l = begin; l < std::min(lines, begin + 64); ++l) {
      float* const first = values.data() + l * line_step;
      const auto at = [&](std::int64_t i) -> float& {
        return first[std::clamp<std::int64_t>(i, 0, length - 1) * value_step];
      };
      double sum = 0;
      for (std::int64_t i = -reach; i <= reach; ++i) sum += double{at(i)};
      for (std::int64_t i = 0; i < length; ++i) {
        line[static_cast<std::size_t>(i)] = static_cast<float>(sum * share);
        sum += double{at(i + reach + 1)} - double{at(i - reach)};
      }
      for (std::int64_t i = 0; i < length; ++i) first[i * value_step] = line[static_cast<std::size_t>(i)];
    }
  });
}

}  // namespace

float light_on(Vector3 normal) {
  static const Vector3 key = unit_vector({-0.45, -0.65, 0.75}), fill = unit_vector({0.7, 0.35, 0.4});
  const double lit = 0.34 + 0.62 * std::max(0.0, dot(normal, key)) + 0.16 * std::max(0.0, dot(normal, fill));
  return static_cast<float>(lit);
}

void blur(std::vector<float>& values, std::int64_t width, std::int64_t height, std::int64_t reach) {
  blur_lines(values, height, width, width, 1, reach);
  blur_lines(values, width, height, 1, width, reach);
}

std::vector<float> hollowness(const std::vector<float>& depth, std::int64_t width, std::int64_t height,
                              float background) {
  std::vector<float> hollow(depth.size());
  for (std::size_t i = 0; i < hollow.size(); ++i) hollow[i] = depth[i] == empty_depth ? background : depth[i];
  const std::int64_t size = std::max(width, height), reach = std::max<std::int64_t>(1, size / 40);
  for (int pass = 0; pass < 2; ++pass) blur(hollow, width, height, reach);
  const float unit = static_cast<float>(size) * 0.05f;
  for (std::size_t i = 0; i < hollow.size(); ++i)
    hollow[i] = depth[i] == empty_depth ? 0 : std::clamp((hollow[i] - depth[i]) / unit, 0.0f, 1.0f);
  return hollow;
}

void darken_hollows(const std::vector<float>& depth, std::vector<float>& light, std::int64_t width,
                    std::int64_t height, float background) {
  const std::vector<float> hollow = hollowness(depth, width, height, background);
  for (std::size_t i = 0; i < light.size(); ++i) light[i] *= 1 - 0.55f * hollow[i];
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
