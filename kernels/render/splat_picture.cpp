#include "kernels/render/splat_picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "kernels/render/picture_camera.h"
#include "kernels/render/shading.h"

namespace meander {

namespace {

constexpr std::uint32_t oversampling = 3;

struct Camera : PictureAxes {
  Vector3 center;            // model point in the middle of the picture
  double scale = 1;          // fine pixels per unit of the model
  double spacing = 1;        // sqrt(area / N) in fine pixels
  double middle = 0;         // fine pixels from the border to the middle
  double near = 0, far = 1;  // range of depths (along `back`) in fine pixels
};

Vector3 vector_at(std::span<const float> values, std::size_t i) {
  return {values[3 * i], values[3 * i + 1], values[3 * i + 2]};
}

// Fits all finite points and their discs into the picture; false if there are no such points.
bool place_camera(Camera& camera, std::span<const float> points, double area,
                  const SplatParameters& parameters) {
  static_cast<PictureAxes&>(camera) = picture_axes(parameters.view, parameters.up);
  ViewBox box;
  for (std::size_t i = 0; i < points.size() / 3; ++i) box.add(camera.direction(vector_at(points, i)));
  if (box.empty()) return false;
  const double fine = static_cast<double>(parameters.size) * oversampling;
  // Discs of few samples are kept small, or they would hide the shape.
  constexpr double largest_spacing = 0.08;
  const double extent = std::max(box.size(0), box.size(1));
  double spacing = std::sqrt(area / static_cast<double>(points.size() / 3));
  if (!(spacing > 0) || !(spacing < largest_spacing * extent)) spacing = largest_spacing * extent;
  const double room = fine * (1 - 2 * parameters.margin);
  camera.scale = extent > 0 ? room / (extent + 2 * parameters.disc_radius * spacing) : 1;
  camera.spacing = extent > 0 ? spacing * camera.scale : largest_spacing * room;
  camera.middle = 0.5 * fine;
  camera.center = box.middle(camera);
  camera.near = 0.5 * box.size(2) * camera.scale;
  camera.far = -camera.near;
  return true;
}

// Every fine pixel: depth (towards the eye), brightness, and the number of the bead there plus one, 0 for the
// discs below.
struct Canvas {
  std::int64_t size = 0;
  std::vector<float> depth, light;
  std::vector<std::uint32_t> bead;
};

// A round spot perpendicular to `normal` (unit, facing the eye). `bend`: how far the normals of a bead lean
// outwards at its rim, 0 for a flat disc.
void draw_spot(Canvas& canvas, Vector3 at, Vector3 normal, double radius, double bend, std::uint32_t bead) {
  // Spots seen edge-on keep a thin outline: a slope of more than 4 would leave gaps at contours.
  normal.z = std::max(normal.z, 0.25);
  normal = unit_vector(normal);
  const double slope_x = -normal.x / normal.z, slope_y = -normal.y / normal.z;
  const auto first_x = std::max<std::int64_t>(0, static_cast<std::int64_t>(std::ceil(at.x - radius)));
  const auto last_x = std::min(canvas.size - 1, static_cast<std::int64_t>(std::floor(at.x + radius)));
  const auto first_y = std::max<std::int64_t>(0, static_cast<std::int64_t>(std::ceil(at.y - radius)));
  const auto last_y = std::min(canvas.size - 1, static_cast<std::int64_t>(std::floor(at.y + radius)));
  const double inverse = 1 / (radius * radius);
  for (std::int64_t y = first_y; y <= last_y; ++y)
    for (std::int64_t x = first_x; x <= last_x; ++x) {
      const double dx = static_cast<double>(x) - at.x, dy = static_cast<double>(y) - at.y;
      const double dz = slope_x * dx + slope_y * dy;
      const double q = (dx * dx + dy * dy + dz * dz) * inverse;
      if (q > 1) continue;
      const auto depth = static_cast<float>(at.z + dz);
      const auto i = static_cast<std::size_t>(y * canvas.size + x);
      if (depth <= canvas.depth[i]) continue;
      canvas.depth[i] = depth;
      const double lean = bend / radius;
      canvas.light[i] = light_on(unit_vector(normal + Vector3{lean * dx, lean * dy, lean * dz}));
      canvas.bead[i] = bead;
    }
}

using LinearColor = std::array<float, 3>;

RgbImage resolve(const Canvas& canvas, const Camera& camera, std::uint32_t size,
                 std::span<const SrgbColor> colors) {
  // Beads without colors from the nearest to the farthest, and the discs below them.
  constexpr LinearColor near_color = {0.80f, 0.16f, 0.03f}, far_color = {0.05f, 0.16f, 0.48f};
  constexpr LinearColor disc_color = {0.80f, 0.79f, 0.76f};
  std::vector<LinearColor> own(colors.size());
  for (std::size_t i = 0; i < colors.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k) own[i][k] = linear_light(colors[i][k]);
  RgbImage image(size, size);
  const auto range = static_cast<float>(std::max(camera.near - camera.far, 1e-9));
  for (std::uint32_t y = 0; y < size; ++y)
    for (std::uint32_t x = 0; x < size; ++x) {
      std::array<float, 3> sum{};
      for (std::uint32_t s = 0; s < oversampling * oversampling; ++s) {
        const std::size_t fx = x * oversampling + s % oversampling, fy = y * oversampling + s / oversampling;
        const std::size_t i = fy * static_cast<std::size_t>(canvas.size) + fx;
        const bool empty = canvas.depth[i] == empty_depth;
        const float t =
            empty ? 0 : std::clamp((static_cast<float>(camera.near) - canvas.depth[i]) / range, 0.0f, 1.0f);
        LinearColor color = disc_color;
        if (canvas.bead[i] > 0 && !own.empty()) {
          color = own[own.size() == 1 ? 0 : canvas.bead[i] - 1];
        } else if (canvas.bead[i] > 0) {
          for (std::size_t k = 0; k < 3; ++k) color[k] = near_color[k] + t * (far_color[k] - near_color[k]);
        }
        for (std::size_t k = 0; k < 3; ++k) sum[k] += empty ? 1.0f : canvas.light[i] * color[k];
      }
      for (std::size_t k = 0; k < 3; ++k)
        image.pixel(x, y)[k] = srgb_byte(sum[k] / (oversampling * oversampling));
    }
  return image;
}

}  // namespace

RgbImage splat_picture(std::span<const float> points, std::span<const float> normals, double area,
                       const SplatParameters& parameters, std::span<const SrgbColor> colors) {
  if (colors.size() > 1 && colors.size() != points.size() / 3)
    throw std::invalid_argument("one color per point is needed, one for all, or none");
  Camera camera;
  if (!place_camera(camera, points, area, parameters)) return RgbImage(parameters.size, parameters.size);
  const std::size_t count = points.size() / 3;
  const double disc = parameters.disc_radius * camera.spacing;
  const double bead = std::max(parameters.bead_radius * camera.spacing, 1.5);  // half a pixel at least

  Canvas canvas;
  canvas.size = static_cast<std::int64_t>(parameters.size) * oversampling;
  canvas.depth.assign(static_cast<std::size_t>(canvas.size * canvas.size), empty_depth);
  canvas.light.assign(canvas.depth.size(), 0.0f);
  canvas.bead.assign(canvas.depth.size(), 0);
  for (std::size_t i = 0; i < count; ++i) {
    const Vector3 p = vector_at(points, i), n = vector_at(normals, i);
    if (!finite_vector(p)) continue;
    const Vector3 offset = camera.scale * (p - camera.center);
    const Vector3 at = camera.direction(offset) + Vector3{camera.middle, camera.middle, 0};
    Vector3 facing = camera.direction(n);
    if (!finite_vector(facing) || norm(facing) < 1e-6) facing = {0, 0, 1};
    if (facing.z < 0) facing = -1.0 * facing;
    facing = unit_vector(facing);
    // The discs lie a little farther, so that on a curved surface they do not cover their neighbors' beads.
    if (disc > 0) draw_spot(canvas, at - Vector3{0, 0, 0.45 * camera.spacing}, facing, disc, 0, 0);
    draw_spot(canvas, at, facing, bead, 0.7, static_cast<std::uint32_t>(i + 1));
  }
  // Background counts as a little behind the model: contours stay bright.
  darken_hollows(canvas.depth, canvas.light, canvas.size, canvas.size, static_cast<float>(camera.far));
  return resolve(canvas, camera, parameters.size, colors);
}

}  // namespace meander
