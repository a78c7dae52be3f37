#include "kernels/render/oriented_splats.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <stdexcept>

#include "kernels/core/parallel.h"
#include "kernels/render/depth_picture.h"
#include "kernels/render/shading.h"

namespace meander {

namespace {

constexpr std::int64_t tile_side = 32, fine_across = 3, fine_side = tile_side * fine_across;
constexpr double most_overlap = 512;
constexpr double filter_radius = 0.5;  // pixels

Vector3 triple(std::span<const float> values, std::size_t i) {
  return {values[3 * i], values[3 * i + 1], values[3 * i + 2]};
}
// ---- views ------------------------------------------------------------------------------------------------

SplatView directed_view(Vector3 towards, Vector3 up, std::uint32_t width, std::uint32_t height) {
  SplatView view{picture_axes(towards, up)};
  view.width = width;
  view.height = height;
  return view;
}

ViewBox box_along(std::span<const float> points, const std::array<Vector3, 3>& axes) {
  ViewBox box;
  for (std::size_t i = 0; i < points.size() / 3; ++i) {
    const Vector3 p = triple(points, i);
    box.add({dot(axes[0], p), dot(axes[1], p), dot(axes[2], p)});
  }
  return box;
}

// Pixels per unit for a model of these half sizes.
double fitting_scale(double half_width, double half_height, const SplatView& view, double margin) {
  const double border = margin * std::min(view.width, view.height);
  const double x = (0.5 * view.width - border) / half_width, y = (0.5 * view.height - border) / half_height;
  const double scale = std::min(x, y);
  return std::isfinite(scale) && scale > 0 ? scale : 1;
}

// ---- splats in the picture --------------------------------------------------------------------------------

// An ellipse in coordinates of the picture in which a pixel has `across` cells a side and cell (0, 0) its
// center at 0: x and y within it where xx dx^2 + 2 xy dx dy + yy dy^2 <= 1.
struct PlacedSplat {
  float x = 0, y = 0, z = 0;
  float xx = 0, xy = 0, yy = 0;
  float reach_x = -1, reach_y = -1;  // < 0: not in the picture
  float slope_x = 0, slope_y = 0;    // of the depth
  float depth_reach = 0, thickness = 0;
  std::array<float, 3> normal{};  // unit, facing the eye
};

struct Placing {
  double across = 1, filter = 0;  // cells a pixel, filter radius in cells
  double thickness = 0;
  bool backs = true;
};

PlacedSplat place_splat(const OrientedSplats& splats, std::size_t i, const SplatView& view,
                        const Placing& placing) {
  PlacedSplat placed;
  const double scale = view.scale * placing.across;
  const double a = scale * splats.half_axes[2 * i], b = scale * splats.half_axes[2 * i + 1];
  const Vector3 pixel = view.point(triple(splats.centers, i));
  Vector3 normal = view.direction(triple(splats.normals, i));
  const double length = norm(normal);
  // Splats this far outside the picture, or this large, exceed the precision of float.
  constexpr double most = 1e9;
  const double farthest = std::abs(pixel.x) + std::abs(pixel.y) + std::abs(pixel.z) + a + b;
  if (!(a > 0) || !(b > 0) || !(farthest < most) || !(length > 0) || !std::isfinite(length) ||
      (normal.z < 0 && !placing.backs))
    return placed;
  normal = ((normal.z < 0 ? -1 : 1) / length) * normal;
  Vector3 along = splats.directions.empty() ? Vector3{} : view.direction(triple(splats.directions, i));
  along = along - dot(along, normal) * normal;
  if (!(norm(along) > 1e-6) || !finite_vector(along))
    along = cross(normal, std::abs(normal.x) < 0.6 ? Vector3{1, 0, 0} : Vector3{0, 1, 0});
  along = unit_vector(along);
  const Vector3 first = a * along, second = b * cross(normal, along);
  // The image of the ellipse, widened by the filter: its covariance, and the inverse of that.
  const double widening = placing.filter * placing.filter;
  const double vxx = first.x * first.x + second.x * second.x + widening,
               vxy = first.x * first.y + second.x * second.y,
               vyy = first.y * first.y + second.y * second.y + widening;
  const double determinant = vxx * vyy - vxy * vxy;
  if (!(determinant > 1e-12 * vxx * vyy)) return placed;  // seen edge-on
  placed.x = static_cast<float>(pixel.x * placing.across - 0.5);
  placed.y = static_cast<float>(pixel.y * placing.across - 0.5);
  placed.z = static_cast<float>(pixel.z * placing.across);
  placed.xx = static_cast<float>(vyy / determinant);
  placed.xy = static_cast<float>(-vxy / determinant);
  placed.yy = static_cast<float>(vxx / determinant);
  placed.reach_x = static_cast<float>(std::sqrt(vxx));
  placed.reach_y = static_cast<float>(std::sqrt(vyy));
  const double facing = std::max(normal.z, 0.05);
  placed.slope_x = static_cast<float>(-normal.x / facing);
  placed.slope_y = static_cast<float>(-normal.y / facing);
  placed.depth_reach = static_cast<float>(std::hypot(first.z, second.z));
  placed.thickness = static_cast<float>(placing.thickness * std::sqrt(a * b));
  placed.normal = {static_cast<float>(normal.x), static_cast<float>(normal.y), static_cast<float>(normal.z)};
  return placed;
}

struct CellRange {
  std::int64_t first_x, last_x, first_y, last_y;
  bool empty() const { return first_x > last_x || first_y > last_y; }
};
std::int64_t clamped_cell(float v, std::int64_t least, std::int64_t most) {
  return static_cast<std::int64_t>(
      std::clamp(v, static_cast<float>(least - 1), static_cast<float>(most + 1)));
}
// Cells of [x0, x1] x [y0, y1] that a splat may cover.
CellRange cells_of(const PlacedSplat& s, std::int64_t x0, std::int64_t x1, std::int64_t y0, std::int64_t y1) {
  if (s.reach_x < 0) return {0, -1, 0, -1};
  return {std::max(x0, clamped_cell(std::ceil(s.x - s.reach_x), x0, x1)),
          std::min(x1, clamped_cell(std::floor(s.x + s.reach_x), x0, x1)),
          std::max(y0, clamped_cell(std::ceil(s.y - s.reach_y), y0, y1)),
          std::min(y1, clamped_cell(std::floor(s.y + s.reach_y), y0, y1))};
}

// Calls body(x, y, square of the distance in half-axes, depth) for the cells of `range` within the splat.
template <class Body>
inline void cover_cells(const PlacedSplat& s, const CellRange& range, const Body& body) {
  for (std::int64_t y = range.first_y; y <= range.last_y; ++y) {
    const float dy = static_cast<float>(y) - s.y, own = s.yy * dy * dy, mixed = 2 * s.xy * dy;
    for (std::int64_t x = range.first_x; x <= range.last_x; ++x) {
      const float dx = static_cast<float>(x) - s.x, square = own + dx * (mixed + s.xx * dx);
      if (square > 1) continue;
      // Seen nearly edge-on, the plane would leave the splat behind.
      const float rise = s.slope_x * dx + s.slope_y * dy;
      body(x, y, square, s.z + std::clamp(rise, -s.depth_reach, s.depth_reach));
    }
  }
}

// ---- tiles ------------------------------------------------------------------------------------------------

struct TileGrid {
  std::int64_t columns, rows;
  std::vector<std::size_t> begin;     // of each tile in `splats`, and the end
  std::vector<std::uint32_t> splats;  // ascending in each tile
};

TileGrid tiles_of(std::span<const PlacedSplat> placed, const SplatView& view) {
  TileGrid grid;
  grid.columns = (view.width + tile_side - 1) / tile_side;
  grid.rows = (view.height + tile_side - 1) / tile_side;
  grid.begin.assign(static_cast<std::size_t>(grid.columns * grid.rows) + 1, 0);
  const std::int64_t last_x = std::int64_t{view.width} * fine_across - 1,
                     last_y = std::int64_t{view.height} * fine_across - 1;
  const auto each_tile = [&](const PlacedSplat& s, const auto& body) {
    const CellRange range = cells_of(s, 0, last_x, 0, last_y);
    if (range.empty()) return;
    for (std::int64_t ty = range.first_y / fine_side; ty <= range.last_y / fine_side; ++ty)
      for (std::int64_t tx = range.first_x / fine_side; tx <= range.last_x / fine_side; ++tx)
        body(static_cast<std::size_t>(ty * grid.columns + tx));
  };
  for (const PlacedSplat& s : placed) each_tile(s, [&](std::size_t tile) { ++grid.begin[tile + 1]; });
  for (std::size_t t = 1; t < grid.begin.size(); ++t) grid.begin[t] += grid.begin[t - 1];
  grid.splats.resize(grid.begin.back());
  std::vector<std::size_t> next(grid.begin.begin(), grid.begin.end() - 1);
  for (std::size_t i = 0; i < placed.size(); ++i)
    each_tile(placed[i],
              [&](std::size_t tile) { grid.splats[next[tile]++] = static_cast<std::uint32_t>(i); });
  return grid;
}

using LinearRgb = std::array<float, 3>;

// The size of a tile in cells.
struct TileCells {
  std::array<float, fine_side * fine_side> depth, weight;
  std::array<std::array<float, 3>, fine_side * fine_side> normal, color;
};

// For every pixel: the lit color, summed over the covered cells; their share; and the mean of their depths.
struct SplatPixels {
  std::vector<LinearRgb> color;
  std::vector<float> covered, depth;
};

void blend_tile(TileCells& cells, std::span<const PlacedSplat> placed, std::span<const std::uint32_t> members,
                std::span<const LinearRgb> colors, const SplatLook& look, std::int64_t x0, std::int64_t y0) {
  cells.depth.fill(empty_depth);
  cells.weight.fill(0);
  const auto cell = [&](std::int64_t x, std::int64_t y) {
    return static_cast<std::size_t>((y - y0) * fine_side + (x - x0));
  };
  const auto range_of = [&](const PlacedSplat& s) {
    return cells_of(s, x0, x0 + fine_side - 1, y0, y0 + fine_side - 1);
  };
  for (const std::uint32_t i : members)
    cover_cells(placed[i], range_of(placed[i]), [&](std::int64_t x, std::int64_t y, float, float depth) {
      float& foremost = cells.depth[cell(x, y)];
      foremost = std::max(foremost, depth);
    });
  cells.normal.fill({});
  cells.color.fill({});
  const auto shown = static_cast<float>(look.shown * look.shown);
  for (const std::uint32_t i : members) {
    const PlacedSplat& s = placed[i];
    const LinearRgb& own = colors[colors.size() == 1 ? 0 : i];
    cover_cells(s, range_of(s), [&](std::int64_t x, std::int64_t y, float square, float depth) {
      const std::size_t c = cell(x, y);
      if (square > shown || depth < cells.depth[c] - s.thickness) return;
      const float rim = 1 - square, weight = rim * rim + 1e-4f;
      cells.weight[c] += weight;
      for (std::size_t k = 0; k < 3; ++k) {
        cells.normal[c][k] += weight * s.normal[k];
        cells.color[c][k] += weight * own[k];
      }
    });
  }
}

void resolve_tile(const TileCells& cells, const SplatView& view, std::int64_t x0, std::int64_t y0,
                  SplatPixels& pixels) {
  const auto width = std::int64_t{view.width}, height = std::int64_t{view.height};
  for (std::int64_t y = y0; y < std::min(y0 + tile_side, height); ++y)
    for (std::int64_t x = x0; x < std::min(x0 + tile_side, width); ++x) {
      LinearRgb sum{};
      float depth = 0;
      int covered = 0;
      for (std::int64_t k = 0; k < fine_across * fine_across; ++k) {
        const auto c = static_cast<std::size_t>(((y - y0) * fine_across + k / fine_across) * fine_side +
                                                (x - x0) * fine_across + k % fine_across);
        if (cells.weight[c] == 0) continue;
        ++covered;
        depth += cells.depth[c];
        const auto& n = cells.normal[c];
        const Vector3 normal{n[0], n[1], n[2]};
        const double length = norm(normal);
        const float light = light_on(length > 0 ? (1 / length) * normal : Vector3{0, 0, 1});
        for (std::size_t q = 0; q < 3; ++q)
          sum[q] += std::min(1.0f, light * cells.color[c][q] / cells.weight[c]);
      }
      const auto p = static_cast<std::size_t>(y * width + x);
      constexpr float share = 1.0f / (fine_across * fine_across);
      for (std::size_t q = 0; q < 3; ++q) pixels.color[p][q] = share * sum[q];
      pixels.covered[p] = share * static_cast<float>(covered);
      pixels.depth[p] =
          covered > 0 ? depth / (static_cast<float>(covered) * static_cast<float>(fine_across)) : empty_depth;
    }
}

SplatImage finished_image(const SplatPixels& pixels, const SplatView& view, double hollows) {
  SplatImage result;
  result.image = RgbImage(view.width, view.height);
  std::vector<float> light(pixels.depth.size(), 1.0f);
  float farthest = std::numeric_limits<float>::infinity();
  for (const float depth : pixels.depth)
    if (depth != empty_depth) farthest = std::min(farthest, depth);
  if (hollows > 0 && std::isfinite(farthest))
    darken_hollows(pixels.depth, light, view.width, view.height, farthest);
  const auto strength = static_cast<float>(hollows);
  parallel_blocks(pixels.depth.size(), 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t p = begin; p < end; ++p) {
      if (pixels.covered[p] == 0) continue;
      const float lit = 1 - strength * (1 - light[p]), paper = 1 - pixels.covered[p];
      for (std::size_t k = 0; k < 3; ++k)
        result.image.pixels[3 * p + k] = srgb_byte(lit * pixels.color[p][k] + paper);
    }
  });
  double covered = 0;
  for (const float share : pixels.covered) covered += share;
  result.covered = covered / static_cast<double>(std::max<std::size_t>(1, pixels.covered.size()));
  return result;
}

void check_splats(const OrientedSplats& splats) {
  const std::size_t count = splats.centers.size() / 3;
  const auto is = [](std::size_t size, std::size_t wanted) { return size == wanted; };
  if (!is(splats.normals.size(), 3 * count) || !is(splats.half_axes.size(), 2 * count) ||
      (!splats.directions.empty() && !is(splats.directions.size(), 3 * count)))
    throw std::invalid_argument("normals, directions or half-axes are not as many as the splats");
}

std::vector<PlacedSplat> placed_splats(const OrientedSplats& splats, const SplatView& view,
                                       const Placing& placing) {
  std::vector<PlacedSplat> placed(splats.centers.size() / 3);
  parallel_blocks(placed.size(), 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) placed[i] = place_splat(splats, i, view, placing);
  });
  return placed;
}

}  // namespace

SplatView fitted_view(std::span<const float> points, Vector3 towards, Vector3 up, std::uint32_t width,
                      std::uint32_t height, double margin) {
  SplatView view = directed_view(towards, up, width, height);
  const ViewBox box = box_along(points, {view.right, view.down, view.back});
  if (box.empty()) return view;
  view.center = box.middle(view);
  view.scale = fitting_scale(0.5 * box.size(0), 0.5 * box.size(1), view, margin);
  return view;
}

SplatView turning_view(std::span<const float> points, Vector3 towards, Vector3 up, std::uint32_t width,
                       std::uint32_t height, double margin) {
  SplatView view = directed_view(towards, up, width, height);
  const Vector3 axis = unit_vector(up);
  const std::array<Vector3, 3> axes = {view.right, axis, cross(view.right, axis)};
  const ViewBox box = box_along(points, axes);
  if (box.empty()) return view;
  view.center = box.middle(axes);
  const double sine = std::abs(dot(axis, view.back)), cosine = std::sqrt(std::max(0.0, 1 - sine * sine));
  double half_width = 0, half_height = 0;
  for (std::size_t i = 0; i < points.size() / 3; ++i) {
    const Vector3 p = triple(points, i) - view.center;
    if (!finite_vector(p)) continue;
    const double along = dot(p, axis), beside = norm(p - along * axis);
    half_width = std::max(half_width, beside);
    half_height = std::max(half_height, std::abs(along) * cosine + beside * sine);
  }
  view.scale = fitting_scale(half_width, half_height, view, margin);
  return view;
}

HalfAxes ellipse_axes(double area, double ratio) {
  const double mean = std::sqrt(area / std::numbers::pi), root = std::sqrt(ratio);
  return {mean * root, mean / root};
}

SplatImage draw_splats(const OrientedSplats& splats, const SplatView& view, const SplatLook& look) {
  check_splats(splats);
  const std::size_t count = splats.centers.size() / 3;
  if (count > 0 && splats.colors.size() != 1 && splats.colors.size() != count)
    throw std::invalid_argument("one color per splat is needed, or one for all");
  const std::vector<PlacedSplat> placed = placed_splats(
      splats, view, {double{fine_across}, filter_radius * double{fine_across}, look.thickness, look.backs});
  double overlap = 0;
  for (std::size_t i = 0; i < count; ++i)
    if (placed[i].reach_x >= 0)
      overlap += double{splats.half_axes[2 * i]} * splats.half_axes[2 * i + 1] * view.scale * view.scale;
  if (std::numbers::pi * overlap > most_overlap * view.width * view.height)
    throw std::invalid_argument("splats that overlap more than 512 times are too large");
  const TileGrid grid = tiles_of(placed, view);
  std::vector<LinearRgb> colors(splats.colors.size());
  for (std::size_t i = 0; i < colors.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k) colors[i][k] = linear_light(splats.colors[i][k]);
  SplatPixels pixels;
  const std::size_t size = std::size_t{view.width} * view.height;
  pixels.color.resize(size);
  pixels.covered.assign(size, 0);
  pixels.depth.assign(size, empty_depth);
  parallel_tasks(static_cast<std::size_t>(grid.rows), [&](std::size_t row) {
    const auto cells = std::make_unique<TileCells>();
    for (std::int64_t column = 0; column < grid.columns; ++column) {
      const std::size_t tile =
          row * static_cast<std::size_t>(grid.columns) + static_cast<std::size_t>(column);
      const std::size_t begin = grid.begin[tile], end = grid.begin[tile + 1];
      if (begin == end) continue;
      const std::int64_t x0 = column * tile_side, y0 = static_cast<std::int64_t>(row) * tile_side;
      blend_tile(*cells, placed, std::span(grid.splats).subspan(begin, end - begin), colors, look,
                 x0 * fine_across, y0 * fine_across);
      resolve_tile(*cells, view, x0, y0, pixels);
    }
  });
  return finished_image(pixels, view, look.hollows);
}

std::vector<float> surface_depth(std::span<const double> positions, std::span<const std::uint32_t> faces,
                                 const SplatView& view) {
  for (const std::uint32_t v : faces)
    if (v >= positions.size() / 3) throw std::invalid_argument("a face names a vertex that is not there");
  std::vector<float> depth(std::size_t{view.width} * view.height, empty_depth);
  for (std::size_t f = 0; f + 2 < faces.size(); f += 3) {
    std::array<Vector3, 3> p;
    for (std::size_t k = 0; k < 3; ++k) {
      const double* at = positions.data() + std::size_t{3} * faces[f + k];
      p[k] = view.point({at[0], at[1], at[2]});
    }
    add_triangle_depth(depth, view.width, view.height, p[0], p[1], p[2]);
  }
  return depth;
}

WhiteSpace white_space(const OrientedSplats& splats, const SplatView& view, std::span<const float> depth) {
  check_splats(splats);
  if (depth.size() != std::size_t{view.width} * view.height)
    throw std::invalid_argument("the depths are not those of the view");
  std::vector<std::uint8_t> covered(depth.size(), 0);
  const std::vector<PlacedSplat> placed = placed_splats(splats, view, {1, 0, 0, true});
  for (std::size_t i = 0; i < placed.size(); ++i) {
    const PlacedSplat& s = placed[i];
    const CellRange range = cells_of(s, 0, std::int64_t{view.width} - 1, 0, std::int64_t{view.height} - 1);
    const auto tolerance =
        static_cast<float>(view.scale * std::max(splats.half_axes[2 * i], splats.half_axes[2 * i + 1]));
    cover_cells(s, range, [&](std::int64_t x, std::int64_t y, float, float at) {
      const auto p = static_cast<std::size_t>(y * std::int64_t{view.width} + x);
      if (std::abs(at - depth[p]) <= tolerance) covered[p] = 1;
    });
  }
  WhiteSpace result;
  for (std::size_t p = 0; p < depth.size(); ++p) {
    if (depth[p] == empty_depth) continue;
    ++result.pixels;
    result.white += covered[p] == 0;
  }
  return result;
}

}  // namespace meander
