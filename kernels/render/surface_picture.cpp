#include "kernels/render/surface_picture.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "kernels/render/picture_camera.h"
#include "kernels/render/shading.h"

namespace meander {

namespace {

constexpr std::uint32_t samples_across = 3;

// From the model to fine pixels: x to the right, y down, z towards the eye.
struct View : PictureAxes {
  Vector3 center{};
  double scale = 1, middle = 0, far = 0;

  Vector3 vector(Vector3 v) const { return scale * direction(v); }
  Vector3 point(Vector3 p) const { return vector(p - center) + Vector3{middle, middle, 0}; }
};

View place_view(const SurfaceScene& scene, const SurfacePictureParameters& parameters) {
  View view{picture_axes(parameters.view, parameters.up)};
  ViewBox box;
  for (const std::uint32_t v : scene.faces)
    box.add(view.direction({scene.positions[3 * v], scene.positions[3 * v + 1], scene.positions[3 * v + 2]}));
  if (box.empty()) return view;
  const double fine = static_cast<double>(parameters.size) * samples_across;
  const double extent = std::max(box.size(0), box.size(1));
  view.scale = extent > 0 ? fine * (1 - 2 * parameters.margin) / extent : 1;
  view.middle = 0.5 * fine;
  view.center = box.middle(view);
  view.far = -0.5 * box.size(2) * view.scale;
  return view;
}

// Every fine pixel: depth towards the eye, light, color, and the unit normal that faces the eye.
struct SurfaceCanvas {
  std::int64_t size = 0;
  std::vector<float> depth, light;
  std::vector<std::array<float, 3>> normal;
  std::vector<SrgbColor> color;
};

struct PixelRange {
  std::int64_t first_x, last_x, first_y, last_y;
};
PixelRange pixels_around(const SurfaceCanvas& canvas, double x0, double x1, double y0, double y1) {
  const double most = static_cast<double>(canvas.size - 1);
  const auto clamped = [&](double v) { return static_cast<std::int64_t>(std::clamp(v, -1.0, most + 1)); };
  return {
      std::max<std::int64_t>(0, clamped(std::ceil(x0))), std::min(canvas.size - 1, clamped(std::floor(x1))),
      std::max<std::int64_t>(0, clamped(std::ceil(y0))), std::min(canvas.size - 1, clamped(std::floor(y1)))};
}

// The normals are on the side of the triangle that faces the eye; at a contour they may lean away from it.
void draw_triangle(SurfaceCanvas& canvas, const std::array<Vector3, 3>& p,
                   const std::array<Vector3, 3>& normal, SrgbColor color) {
  const double area = (p[1].x - p[0].x) * (p[2].y - p[0].y) - (p[1].y - p[0].y) * (p[2].x - p[0].x);
  if (area == 0 || !std::isfinite(area)) return;
  const PixelRange range =
      pixels_around(canvas, std::min({p[0].x, p[1].x, p[2].x}), std::max({p[0].x, p[1].x, p[2].x}),
                    std::min({p[0].y, p[1].y, p[2].y}), std::max({p[0].y, p[1].y, p[2].y}));
  for (std::int64_t y = range.first_y; y <= range.last_y; ++y)
    for (std::int64_t x = range.first_x; x <= range.last_x; ++x) {
      const double px = static_cast<double>(x), py = static_cast<double>(y);
      const auto edge = [&](Vector3 a, Vector3 b) {
        return ((b.x - a.x) * (py - a.y) - (b.y - a.y) * (px - a.x)) / area;
      };
      // Pixels on an edge belong to both triangles: no gaps; which one wins is the same every time.
      const double w0 = edge(p[1], p[2]), w1 = edge(p[2], p[0]), w2 = edge(p[0], p[1]);
      if (w0 < 0 || w1 < 0 || w2 < 0) continue;
      const auto depth = static_cast<float>(w0 * p[0].z + w1 * p[1].z + w2 * p[2].z);
      const auto i = static_cast<std::size_t>(y * canvas.size + x);
      if (depth <= canvas.depth[i]) continue;
      Vector3 n = w0 * normal[0] + w1 * normal[1] + w2 * normal[2];
      n.z = std::max(n.z, 0.0);
      const double length = norm(n);
      n = length > 1e-12 ? (1 / length) * n : Vector3{0, 0, 1};
      canvas.depth[i] = depth;
      canvas.light[i] = light_on(n);
      canvas.normal[i] = {static_cast<float>(n.x), static_cast<float>(n.y), static_cast<float>(n.z)};
      canvas.color[i] = color;
    }
}

void draw_mesh(SurfaceCanvas& canvas, const View& view, const SurfaceScene& scene, double crease) {
  const std::size_t vertices = scene.positions.size() / 3, faces = scene.faces.size() / 3;
  std::vector<Vector3> at(vertices), mean(vertices), face_normal(faces);
  for (std::size_t v = 0; v < vertices; ++v)
    at[v] = view.point({scene.positions[3 * v], scene.positions[3 * v + 1], scene.positions[3 * v + 2]});
  for (std::size_t f = 0; f < faces; ++f) {
    const std::uint32_t* c = scene.faces.data() + 3 * f;
    face_normal[f] = cross(at[c[1]] - at[c[0]], at[c[2]] - at[c[0]]);
    if (finite_vector(face_normal[f]))
      for (std::size_t k = 0; k < 3; ++k) mean[c[k]] = mean[c[k]] + face_normal[f];
  }
  constexpr SrgbColor pale = {218, 217, 213};
  for (std::size_t f = 0; f < faces; ++f) {
    const std::uint32_t* c = scene.faces.data() + 3 * f;
    const double length = norm(face_normal[f]);
    if (!(length > 0) || !std::isfinite(length)) continue;
    const Vector3 flat = (1 / length) * face_normal[f];
    const double side = flat.z < 0 ? -1 : 1;
    std::array<Vector3, 3> normal;
    for (std::size_t k = 0; k < 3; ++k) {
      const double mean_length = norm(mean[c[k]]);
      const bool smooth = mean_length > 0 && dot(flat, mean[c[k]]) >= crease * mean_length;
      normal[k] = side * (smooth ? (1 / mean_length) * mean[c[k]] : flat);
    }
    draw_triangle(canvas, {at[c[0]], at[c[1]], at[c[2]]}, normal,
                  scene.face_colors.empty() ? pale : scene.face_colors[f]);
  }
}

// Calls paint(pixel, difference from `center`) for every covered pixel within `reach` of it in the picture.
template <class Paint>
void around(const SurfaceCanvas& canvas, Vector3 center, double reach, Paint paint) {
  const PixelRange range =
      pixels_around(canvas, center.x - reach, center.x + reach, center.y - reach, center.y + reach);
  for (std::int64_t y = range.first_y; y <= range.last_y; ++y)
    for (std::int64_t x = range.first_x; x <= range.last_x; ++x) {
      const auto i = static_cast<std::size_t>(y * canvas.size + x);
      if (canvas.depth[i] == empty_depth) continue;
      paint(i, Vector3{static_cast<double>(x), static_cast<double>(y), double{canvas.depth[i]}} - center);
    }
}

void paint_ellipses(SurfaceCanvas& canvas, const View& view, const std::vector<SurfaceEllipse>& ellipses) {
  if (ellipses.empty()) return;
  std::vector<float> nearest(canvas.depth.size(), 1.0f);
  for (const SurfaceEllipse& ellipse : ellipses) {
    const Vector3 center = view.point(ellipse.center), a = view.vector(ellipse.first),
                  b = view.vector(ellipse.second);
    const double aa = dot(a, a), bb = dot(b, b);
    if (!finite_vector(center) || !(aa > 0) || !(bb > 0) || !std::isfinite(aa + bb)) continue;
    Vector3 normal = unit_vector(cross(a, b));
    if (normal.z < 0) normal = -1.0 * normal;
    const double reach = std::sqrt(std::max(aa, bb));
    around(canvas, center, reach, [&](std::size_t i, Vector3 d) {
      const double p = dot(d, a) / aa, q = dot(d, b) / bb, square = p * p + q * q;
      if (square >= nearest[i]) return;
      // Not the other side of a thin part, nor a fold that comes near.
      if (std::abs(dot(d, normal)) > 0.6 * reach) return;
      const auto& own = canvas.normal[i];
      if (own[0] * normal.x + own[1] * normal.y + own[2] * normal.z < 0.3) return;
      nearest[i] = static_cast<float>(square);
      canvas.color[i] = ellipse.color;
    });
  }
  // A darker rim keeps ellipses apart that touch.
  for (std::size_t i = 0; i < nearest.size(); ++i)
    if (nearest[i] < 1 && nearest[i] > 0.72f) canvas.light[i] *= 0.62f;
}

void paint_lines(SurfaceCanvas& canvas, const View& view, const std::vector<SurfaceLine>& lines) {
  for (const SurfaceLine& line : lines) {
    const Vector3 from = view.point(line.from), along = view.vector(line.to - line.from);
    const double square = dot(along, along), radius = 0.5 * samples_across * line.width;
    if (!finite_vector(from) || !std::isfinite(square)) continue;
    around(canvas, from + 0.5 * along, 0.5 * std::sqrt(square) + radius, [&](std::size_t i, Vector3 d) {
      const Vector3 e = d + 0.5 * along;
      const double t = square > 0 ? std::clamp(dot(e, along) / square, 0.0, 1.0) : 0.0;
      const Vector3 off = e - t * along;
      // A chord of a curved surface lies beside it in depth: there it may be farther than half its width.
      if (off.x * off.x + off.y * off.y > radius * radius) return;
      if (std::abs(off.z) > 2.5 * radius + 0.15 * std::sqrt(square)) return;
      canvas.color[i] = line.color;
      canvas.light[i] = 0.3f * canvas.light[i] + 0.7f;
    });
  }
}

void paint_dots(SurfaceCanvas& canvas, const View& view, const std::vector<SurfaceDot>& dots) {
  for (const SurfaceDot& dot_mark : dots) {
    const Vector3 center = view.point(dot_mark.center);
    const double radius = samples_across * dot_mark.radius;
    if (!finite_vector(center) || center.x < 0 || center.y < 0) continue;
    // Whole disks, where the surface at the center is not hidden.
    const auto x = static_cast<std::int64_t>(std::lround(center.x)),
               y = static_cast<std::int64_t>(std::lround(center.y));
    if (x >= canvas.size || y >= canvas.size) continue;
    const float seen = canvas.depth[static_cast<std::size_t>(y * canvas.size + x)];
    if (seen != empty_depth && seen > center.z + 2 * radius) continue;
    const PixelRange range =
        pixels_around(canvas, center.x - radius, center.x + radius, center.y - radius, center.y + radius);
    for (std::int64_t py = range.first_y; py <= range.last_y; ++py)
      for (std::int64_t px = range.first_x; px <= range.last_x; ++px) {
        const double dx = static_cast<double>(px) - center.x, dy = static_cast<double>(py) - center.y;
        const double square = (dx * dx + dy * dy) / (radius * radius);
        if (square > 1) continue;
        const auto i = static_cast<std::size_t>(py * canvas.size + px);
        canvas.color[i] = square > 0.62 ? SrgbColor{255, 255, 255} : dot_mark.color;
        canvas.light[i] = 1;
        if (canvas.depth[i] == empty_depth) canvas.depth[i] = static_cast<float>(center.z);
      }
  }
}

RgbImage resolve(const SurfaceCanvas& canvas, std::uint32_t size) {
  std::array<float, 256> linear;
  for (std::size_t b = 0; b < linear.size(); ++b) linear[b] = linear_light(static_cast<std::uint8_t>(b));
  RgbImage image(size, size);
  for (std::uint32_t y = 0; y < size; ++y)
    for (std::uint32_t x = 0; x < size; ++x) {
      std::array<float, 3> sum{};
      for (std::uint32_t s = 0; s < samples_across * samples_across; ++s) {
        const std::size_t fx = x * samples_across + s % samples_across,
                          fy = y * samples_across + s / samples_across;
        const std::size_t i = fy * static_cast<std::size_t>(canvas.size) + fx;
        const bool empty = canvas.depth[i] == empty_depth;
        for (std::size_t k = 0; k < 3; ++k)
          sum[k] += empty ? 1.0f : std::min(1.0f, canvas.light[i] * linear[canvas.color[i][k]]);
      }
      for (std::size_t k = 0; k < 3; ++k)
        image.pixel(x, y)[k] = srgb_byte(sum[k] / (samples_across * samples_across));
    }
  return image;
}

}  // namespace

RgbImage surface_picture(const SurfaceScene& scene, const SurfacePictureParameters& parameters) {
  const std::size_t faces = scene.faces.size() / 3;
  for (const std::uint32_t v : scene.faces)
    if (v >= scene.positions.size() / 3)
      throw std::invalid_argument("a face names a vertex that is not there");
  if (!scene.face_colors.empty() && scene.face_colors.size() != faces)
    throw std::invalid_argument("one color per face is needed, or none");
  if (faces == 0) return RgbImage(parameters.size, parameters.size);
  const View view = place_view(scene, parameters);
  SurfaceCanvas canvas;
  canvas.size = static_cast<std::int64_t>(parameters.size) * samples_across;
  canvas.depth.assign(static_cast<std::size_t>(canvas.size * canvas.size), empty_depth);
  canvas.light.assign(canvas.depth.size(), 0.0f);
  canvas.normal.resize(canvas.depth.size());
  canvas.color.resize(canvas.depth.size());
  draw_mesh(canvas, view, scene, parameters.crease);
  darken_hollows(canvas.depth, canvas.light, canvas.size, canvas.size, static_cast<float>(view.far));
  paint_ellipses(canvas, view, scene.ellipses);
  paint_lines(canvas, view, scene.lines);
  paint_dots(canvas, view, scene.dots);
  return resolve(canvas, parameters.size);
}

}  // namespace meander
