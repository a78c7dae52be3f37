#include "kernels/query/shell_grid.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>

#include "kernels/query/segment_crossings.h"

namespace meander {

namespace {

constexpr std::size_t margin = 2, min_cells = 16, largest_cells = 256;
constexpr double max_marking = 134217728;  // 2^27

std::array<double, 3> axes_of(Vector3 v) { return {v.x, v.y, v.z}; }

// The cells of a triangle's box.
struct CellRange {
  std::array<std::size_t, 3> first{}, last{};

  double cells() const {
    double product = 1;
    for (std::size_t k = 0; k < 3; ++k) product *= static_cast<double>(last[k] - first[k] + 1);
    return product;
  }
};

std::size_t cell_at(const ShellGrid& grid, double from_low, std::size_t axis) {
  const double place = std::floor(from_low / grid.cell);
  return static_cast<std::size_t>(std::clamp(place, 0.0, static_cast<double>(grid.count[axis] - 1)));
}

CellRange range_of(const ShellGrid& grid, const std::array<Vector3, 3>& corner) {
  CellRange range;
  const std::array<double, 3> low = axes_of(grid.low), a = axes_of(corner[0]), b = axes_of(corner[1]),
                              c = axes_of(corner[2]);
  for (std::size_t k = 0; k < 3; ++k) {
    range.first[k] = cell_at(grid, std::min({a[k], b[k], c[k]}) - low[k] - 1e-9, k);
    range.last[k] = cell_at(grid, std::max({a[k], b[k], c[k]}) - low[k] + 1e-9, k);
  }
  return range;
}

std::array<Vector3, 3> triangle_at(const TriangleTree& tree, std::size_t position) {
  return {tree.corner(position, 0), tree.corner(position, 1), tree.corner(position, 2)};
}

// A grid without marks.
ShellGrid empty_grid(const TriangleTree& tree, std::size_t cells) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  std::array<double, 3> low, high;
  low.fill(infinity);
  high.fill(-infinity);
  for (std::size_t i = 0; i < tree.corners.size(); ++i) {
    low[i % 3] = std::min(low[i % 3], tree.corners[i]);
    high[i % 3] = std::max(high[i % 3], tree.corners[i]);
  }
  ShellGrid grid;
  const double longest = std::max({high[0] - low[0], high[1] - low[1], high[2] - low[2]});
  grid.cell = longest > 0 ? longest / static_cast<double>(cells - 2 * margin) : 1;
  for (std::size_t k = 0; k < 3; ++k)
    grid.count[k] =
        std::min(cells, static_cast<std::size_t>((high[k] - low[k]) / grid.cell) + 1 + 2 * margin);
  const double before = static_cast<double>(margin) * grid.cell;
  grid.low = {low[0] - before, low[1] - before, low[2] - before};
  return grid;
}

// Marks the cells that the triangle may meet: not beyond its box, its plane, or the planes through its edges
// at right angles to it.
void mark(ShellGrid& grid, const std::array<Vector3, 3>& corner) {
  struct Plane {
    Vector3 normal;
    double offset = 0, reach = 0;  // of a cell around its middle
  };
  std::array<Plane, 4> planes;
  const auto plane_through = [&](Vector3 normal, Vector3 point) {
    const double reach = 0.5 * grid.cell * (std::abs(normal.x) + std::abs(normal.y) + std::abs(normal.z));
    return Plane{normal, dot(normal, point), reach + 1e-9};
  };
  const Vector3 twice = cross(corner[1] - corner[0], corner[2] - corner[0]);
  const double area = norm(twice);
  if (area > 1e-12) {
    const Vector3 normal = (1 / area) * twice;
    planes[0] = plane_through(normal, corner[0]);
    for (std::size_t k = 0; k < 3; ++k) {
      const Vector3 edge = corner[(k + 1) % 3] - corner[k];
      planes[1 + k] = plane_through((1 / norm(edge)) * cross(edge, normal), corner[k]);
    }
  }
  const CellRange range = range_of(grid, corner);
  const auto middle = [&](std::size_t cell) { return (static_cast<double>(cell) + 0.5) * grid.cell; };
  for (std::size_t k = range.first[2]; k <= range.last[2]; ++k)
    for (std::size_t j = range.first[1]; j <= range.last[1]; ++j)
      for (std::size_t i = range.first[0]; i <= range.last[0]; ++i) {
        const Vector3 at = grid.low + Vector3{middle(i), middle(j), middle(k)};
        bool beyond = std::abs(dot(planes[0].normal, at) - planes[0].offset) > planes[0].reach;
        for (std::size_t p = 1; p < 4; ++p)
          beyond = beyond || dot(planes[p].normal, at) - planes[p].offset > planes[p].reach;
        if (!beyond) grid.kind[(k * grid.count[1] + j) * grid.count[0] + i] = ShellCell::surface;
      }
}

// Spreads over cells side by side that are not of the surface, from the first, which is outside.
void flood(ShellGrid& grid) {
  const auto [nx, ny, nz] = grid.count;
  std::vector<std::uint32_t> waiting{0};
  grid.kind[0] = ShellCell::outside;
  const auto reach = [&](std::size_t cell) {
    if (grid.kind[cell] != ShellCell::enclosed) return;
    grid.kind[cell] = ShellCell::outside;
    waiting.push_back(static_cast<std::uint32_t>(cell));
  };
  while (!waiting.empty()) {
    const std::size_t cell = waiting.back();
    waiting.pop_back();
    const std::size_t i = cell % nx, j = cell / nx % ny, k = cell / (nx * ny);
    if (i > 0) reach(cell - 1);
    if (i + 1 < nx) reach(cell + 1);
    if (j > 0) reach(cell - nx);
    if (j + 1 < ny) reach(cell + nx);
    if (k > 0) reach(cell - nx * ny);
    if (k + 1 < nz) reach(cell + nx * ny);
  }
}

using Cell = std::array<std::ptrdiff_t, 3>;

// The cell of a point; none beside the grid.
std::optional<Cell> cell_of(const ShellGrid& grid, Vector3 point) {
  const std::array<double, 3> from_low = axes_of(point - grid.low);
  Cell cell{};
  for (std::size_t k = 0; k < 3; ++k) {
    const double place = std::floor(from_low[k] / grid.cell);
    if (!(place >= 0 && place < static_cast<double>(grid.count[k]))) return std::nullopt;
    cell[k] = static_cast<std::ptrdiff_t>(place);
  }
  return cell;
}

std::size_t number_of(const ShellGrid& grid, const Cell& at) {
  return (static_cast<std::size_t>(at[2]) * grid.count[1] + static_cast<std::size_t>(at[1])) * grid.count[0] +
         static_cast<std::size_t>(at[0]);
}

}  // namespace

ShellGrid build_shell_grid(const TriangleTree& tree, std::size_t max_cells) {
  if (max_cells < min_cells || max_cells > largest_cells)
    throw std::invalid_argument("build_shell_grid: 16 to 256 cells along a side");
  ShellGrid grid;
  for (std::size_t cells = max_cells;; cells /= 2) {
    grid = empty_grid(tree, cells);
    double marking = 0;
    for (std::size_t p = 0; p < tree.count(); ++p) marking += range_of(grid, triangle_at(tree, p)).cells();
    if (marking <= max_marking || cells / 2 < min_cells) break;
  }
  grid.kind.assign(grid.count[0] * grid.count[1] * grid.count[2], ShellCell::enclosed);
  for (std::size_t p = 0; p < tree.count(); ++p) mark(grid, triangle_at(tree, p));
  flood(grid);
  return grid;
}

bool is_surface_cell(const ShellGrid& grid, Vector3 point) {
  const std::optional<Cell> own = cell_of(grid, point);
  return own && grid.kind[number_of(grid, *own)] == ShellCell::surface;
}

ShellSide shell_side(const ShellGrid& grid, const TriangleTree& tree, Vector3 point,
                     std::span<const std::uint32_t> likely) {
  const std::optional<Cell> own = cell_of(grid, point);
  if (!own) return {false, true};
  if (const ShellCell kind = grid.kind[number_of(grid, *own)]; kind != ShellCell::surface)
    return {kind == ShellCell::enclosed, true};
  bool outside = false, enclosed = false;
  for (std::ptrdiff_t ring = 1; ring <= 2 && !(outside || enclosed); ++ring)
    for (std::ptrdiff_t dz = -ring; dz <= ring; ++dz)
      for (std::ptrdiff_t dy = -ring; dy <= ring; ++dy)
        for (std::ptrdiff_t dx = -ring; dx <= ring; ++dx) {
          if (std::max({std::abs(dx), std::abs(dy), std::abs(dz)}) != ring) continue;
          const Cell at{(*own)[0] + dx, (*own)[1] + dy, (*own)[2] + dz};
          bool there = true;
          for (std::size_t k = 0; k < 3; ++k)
            there = there && at[k] >= 0 && at[k] < static_cast<std::ptrdiff_t>(grid.count[k]);
          if (!there) continue;
          const ShellCell kind = grid.kind[number_of(grid, at)];
          if (kind == ShellCell::surface || (kind == ShellCell::outside ? outside : enclosed)) continue;
          const Vector3 middle = grid.low + grid.cell * Vector3{static_cast<double>(at[0]) + 0.5,
                                                                static_cast<double>(at[1]) + 0.5,
                                                                static_cast<double>(at[2]) + 0.5};
          if (!is_free_segment(tree, point, middle, likely)) continue;
          (kind == ShellCell::outside ? outside : enclosed) = true;
        }
  if (outside == enclosed) return {!outside, false};
  return {enclosed, true};
}

}  // namespace meander
