#include "kernels/render/depth_picture.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "kernels/render/shading.h"

namespace meander {

void add_triangle_depth(std::span<float> depth, std::uint32_t width, std::uint32_t height, Vector3 a,
                        Vector3 b, Vector3 c) {
  const double area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
  if (area == 0 || !std::isfinite(area)) return;
  const auto clamped = [](double v, std::uint32_t size) {
    return static_cast<std::int64_t>(std::clamp(v, 0.0, static_cast<double>(size)));
  };
  const std::int64_t first_x = clamped(std::ceil(std::min({a.x, b.x, c.x}) - 0.5), width),
                     last_x = clamped(std::floor(std::max({a.x, b.x, c.x}) + 0.5), width),
                     first_y = clamped(std::ceil(std::min({a.y, b.y, c.y}) - 0.5), height),
                     last_y = clamped(std::floor(std::max({a.y, b.y, c.y}) + 0.5), height);
  const double inverse = 1 / area;
  for (std::int64_t y = first_y; y < last_y; ++y) {
    const double py = static_cast<double>(y) + 0.5;
    for (std::int64_t x = first_x; x < last_x; ++x) {
      const double px = static_cast<double>(x) + 0.5;
      const auto edge = [&](Vector3 p, Vector3 q) {
        return ((q.x - p.x) * (py - p.y) - (q.y - p.y) * (px - p.x)) * inverse;
      };
      const double wa = edge(b, c), wb = edge(c, a), wc = edge(a, b);
      if (wa < 0 || wb < 0 || wc < 0) continue;
      float& nearest = depth[static_cast<std::size_t>(y) * width + static_cast<std::size_t>(x)];
      nearest = std::max(nearest, static_cast<float>(wa * a.z + wb * b.z + wc * c.z));
    }
  }
}

bool DepthPicture::covered(std::int64_t x, std::int64_t y) const {
  return x >= 0 && y >= 0 && x < width && y < height &&
         depth[static_cast<std::size_t>(y) * width + static_cast<std::size_t>(x)] != empty_depth;
}

PictureView framed_view(std::span<const double> points, Vector3 view, Vector3 up, std::uint32_t width,
                        std::uint32_t height, double margin) {
  PictureView made{picture_axes(view, up)};
  made.middle_x = 0.5 * width;
  made.middle_y = 0.5 * height;
  ViewBox box;
  for (std::size_t i = 0; i + 2 < points.size(); i += 3)
    box.add(made.direction({points[i], points[i + 1], points[i + 2]}));
  if (box.empty()) return made;
  const double scale = std::min(std::max(1.0, width - 2 * margin) / box.size(0),
                                std::max(1.0, height - 2 * margin) / box.size(1));
  if (std::isfinite(scale)) made.scale = scale;
  made.center = box.middle(made);
  return made;
}

DepthPicture depth_picture(const PictureView& view, std::span<const double> positions,
                           std::span<const std::uint32_t> faces, std::uint32_t width, std::uint32_t height) {
  DepthPicture picture;
  picture.width = width;
  picture.height = height;
  picture.depth.assign(std::size_t{width} * height, empty_depth);
  for (std::size_t f = 0; f + 2 < faces.size(); f += 3) {
    std::array<Vector3, 3> corner;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t v = 3 * std::size_t{faces[f + k]};
      corner[k] = view.point({positions[v], positions[v + 1], positions[v + 2]});
    }
    add_triangle_depth(picture.depth, width, height, corner[0], corner[1], corner[2]);
  }
  for (const float depth : picture.depth)
    if (depth != empty_depth) picture.far = std::min(picture.far, static_cast<double>(depth));
  return picture;
}

}  // namespace meander
