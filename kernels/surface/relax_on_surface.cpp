#include "kernels/surface/relax_on_surface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "kernels/core/ordered_blocks.h"
#include "kernels/density/density.h"
#include "kernels/mesh/prepare_mesh.h"
#include "kernels/mesh/surface_walk.h"
#include "kernels/sample/relaxed_samples.h"

namespace meander {

namespace {

// Edges of the grid, in spacings, and its cells in a direction.
constexpr double longest_edge = 0.7;
constexpr std::size_t min_cells = 32, max_cells = 1 << 15;
// Lines of the square that lengths are taken from, and their points.
constexpr std::size_t lines = 33, line_points = 257;
// Points of the sides of the square that are nearer to each other, in diagonals, are one.
constexpr double joined_within = 1e-9;
constexpr std::size_t rows_of_task = 4;
constexpr std::uint32_t no_triangle = 0xFFFFFFFFu;
// The density of a point without an area element.
constexpr double unknown = -1;

// The longest of some lines of the square in each of its directions.
std::array<double, 2> longest_lines(const SurfaceMeasure& measure, const CancelToken& cancel) {
  std::array<double, 2> longest{};
  std::vector<double> along(line_points), across(line_points);
  MeasureBatch batch;
  for (std::size_t i = 0; i < line_points; ++i)
    along[i] = static_cast<double>(i) / static_cast<double>(line_points - 1);
  for (std::size_t line = 0; line < lines; ++line) {
    cancel.check();
    across.assign(line_points, static_cast<double>(line) / static_cast<double>(lines - 1));
    for (std::size_t k = 0; k < 2; ++k) {
      measure.evaluate(k == 0 ? along : across, k == 0 ? across : along, batch);
      double length = 0;
      for (std::size_t i = 1; i < line_points; ++i)
        length += distance(batch.position[i - 1], batch.position[i]);
      longest[k] = std::max(longest[k], length);
    }
  }
  return longest;
}

// A grid over the square, and the surface at its points.
class SurfaceGrid {
 public:
  SurfaceGrid(const SurfaceMeasure& measure, double area, std::size_t samples, const CancelToken& cancel) {
    const double edge = longest_edge * std::sqrt(area / static_cast<double>(samples));
    const std::array<double, 2> longest = longest_lines(measure, cancel);
    for (std::size_t k = 0; k < 2; ++k)
      cells_[k] = static_cast<std::size_t>(
          std::clamp(std::ceil(longest[k] / edge), double(min_cells), double(max_cells)));
    const double most = 8 * static_cast<double>(samples) + 65536,
                 over = static_cast<double>(cells_[0]) * static_cast<double>(cells_[1]) / most;
    if (over > 1)
      for (std::size_t& cells : cells_)
        cells = std::max(min_cells, static_cast<std::size_t>(static_cast<double>(cells) / std::sqrt(over)));
    evaluate(measure, cancel);
    join_sides(joined_within * measure.diagonal());
  }

  std::size_t triangle_count() const { return 2 * cells_[0] * cells_[1]; }
  const std::vector<double>& density() const { return density_; }

  // The points of a corner of a triangle, by number and in the square. Of the two triangles of a cell the
  // first is below the diagonal.
  std::size_t point_of(std::size_t triangle, std::size_t corner) const {
    const auto [i, j] = place_of(triangle, corner);
    return j * (cells_[0] + 1) + i;
  }
  UnitPair at(std::size_t triangle, std::size_t corner) const {
    const auto [i, j] = place_of(triangle, corner);
    return {static_cast<double>(i) / static_cast<double>(cells_[0]),
            static_cast<double>(j) / static_cast<double>(cells_[1])};
  }

  // The triangle of a point of the square, and its weights there.
  struct Place {
    std::size_t triangle;
    std::array<double, 3> weight;
  };
  Place find(const UnitPair& point) const {
    std::array<std::size_t, 2> cell;
    std::array<double, 2> in_cell;
    const std::array<double, 2> at{point.first, point.second};
    for (std::size_t k = 0; k < 2; ++k) {
      const double scaled = at[k] * static_cast<double>(cells_[k]);
      cell[k] = std::min(cells_[k] - 1, static_cast<std::size_t>(scaled));
      in_cell[k] = std::clamp(scaled - static_cast<double>(cell[k]), 0.0, 1.0);
    }
    const std::size_t first = 2 * (cell[1] * cells_[0] + cell[0]);
    const auto [s, t] = in_cell;
    if (s >= t) return {first, {1 - s, s - t, t}};
    return {first + 1, {1 - t, s, t - s}};
  }

  // To the other triangle of the cell, if it has all corners in space of this one.
  bool move_to_other(Place& place) const {
    const std::size_t other = place.triangle ^ 1;
    std::array<double, 3> weight{};
    for (std::size_t k = 0; k < 3; ++k) {
      const Vector3& corner = position_[point_of(place.triangle, k)];
      std::size_t same = 0;
      while (same < 3 && !(distance(position_[point_of(other, same)], corner) == 0)) ++same;
      if (same == 3) return false;
      weight[same] += place.weight[k];
    }
    place = {other, weight};
    return true;
  }

  PolygonMesh mesh() const {
    PolygonMesh mesh;
    for (const Vector3& p : position_) {
      mesh.x.push_back(p.x);
      mesh.y.push_back(p.y);
      mesh.z.push_back(p.z);
    }
    for (std::size_t t = 0; t < triangle_count(); ++t)
      for (std::size_t k = 0; k < 3; ++k) mesh.corners.push_back(static_cast<std::uint32_t>(point_of(t, k)));
    mesh.polygon_begin.resize(triangle_count() + 1);
    for (std::size_t t = 0; t <= triangle_count(); ++t)
      mesh.polygon_begin[t] = static_cast<std::uint32_t>(3 * t);
    return mesh;
  }

 private:
  std::array<std::size_t, 2> place_of(std::size_t triangle, std::size_t corner) const {
    constexpr std::array<std::array<std::array<std::size_t, 2>, 3>, 2> corners{
        {{{{0, 0}, {1, 0}, {1, 1}}}, {{{0, 0}, {1, 1}, {0, 1}}}}};
    const std::size_t cell = triangle / 2;
    const auto& [i, j] = corners[triangle % 2][corner];
    return {cell % cells_[0] + i, cell / cells_[0] + j};
  }

  void evaluate(const SurfaceMeasure& measure, const CancelToken& cancel) {
    const std::size_t across = cells_[0] + 1, rows = cells_[1] + 1;
    position_.resize(across * rows);
    density_.resize(across * rows);
    ordered_blocks(rows, rows_of_task, [&](std::size_t begin, std::size_t end) {
      cancel.check();
      std::vector<double> s(across), t(across);
      MeasureBatch batch;
      for (std::size_t j = begin; j < end; ++j) {
        for (std::size_t i = 0; i < across; ++i)
          s[i] = static_cast<double>(i) / static_cast<double>(cells_[0]);
        t.assign(across, static_cast<double>(j) / static_cast<double>(cells_[1]));
        measure.evaluate(s, t, batch);
        std::copy(batch.position.begin(), batch.position.end(),
                  position_.begin() + static_cast<std::ptrdiff_t>(j * across));
        for (std::size_t i = 0; i < across; ++i)
          density_[j * across + i] = batch.area[i] > 0 ? batch.density[i] : unknown;
      }
    });
    find_unknown_densities();
  }

  // At a pole the density is that of the points beside it.
  void find_unknown_densities() {
    const std::size_t across = cells_[0] + 1;
    const std::vector<double> known = density_;
    for (std::size_t p = 0; p < known.size(); ++p) {
      if (known[p] != unknown) continue;
      density_[p] = 0;
      const auto take = [&](std::size_t other) { density_[p] = std::max(density_[p], known[other]); };
      if (p % across > 0) take(p - 1);
      if (p % across + 1 < across) take(p + 1);
      if (p >= across) take(p - across);
      if (p + across < known.size()) take(p + across);
    }
  }

  // Gives points of the sides that lie together the position of the first of them, by which prepare_mesh
  // knows them.
  void join_sides(double within) {
    std::vector<std::size_t> side;
    for (std::size_t j = 0; j <= cells_[1]; ++j)
      for (std::size_t i = 0; i <= cells_[0]; i += j == 0 || j == cells_[1] ? 1 : cells_[0])
        side.push_back(j * (cells_[0] + 1) + i);
    std::stable_sort(side.begin(), side.end(),
                     [&](std::size_t a, std::size_t b) { return position_[a].x < position_[b].x; });
    std::vector<std::size_t> kept;  // in the order of x
    std::size_t near = 0;           // the first of these that may lie within
    for (const std::size_t p : side) {
      while (near < kept.size() && position_[kept[near]].x < position_[p].x - within) ++near;
      std::size_t k = near;
      while (k < kept.size() && !(distance(position_[kept[k]], position_[p]) <= within)) ++k;
      if (k < kept.size())
        position_[p] = position_[kept[k]];
      else
        kept.push_back(p);
    }
  }

  std::array<std::size_t, 2> cells_{};
  std::vector<Vector3> position_;
  std::vector<double> density_;
};

// The grid as a mesh, whose triangles are those of the grid that have an area, and their corners, in another
// order.
class GridMesh {
 public:
  GridMesh(const SurfaceGrid& grid, const CancelToken& cancel)
      : grid_(grid), mesh_(prepare_mesh(grid.mesh(), cancel)), number_(grid.triangle_count(), no_triangle) {
    for (std::uint32_t t = 0; t < mesh_.triangle_count(); ++t) number_[mesh_.polygon[t]] = t;
  }

  const PreparedMesh& mesh() const { return mesh_; }

  std::vector<double> corner_density() const {
    std::vector<double> density(mesh_.corner_slot.size());
    for (std::size_t c = 0; c < density.size(); ++c)
      density[c] = grid_.density()[grid_.point_of(mesh_.polygon[c / 3], mesh_.corner_slot[c] % 3)];
    return density;
  }

  // False where the surface has no area. At a pole one of the triangles of a cell has none, and its points
  // are taken as those of the other one, which is as narrow as they are apart.
  bool to_mesh(const UnitPair& point, SurfacePlace& place) const {
    SurfaceGrid::Place in_grid = grid_.find(point);
    if (number_[in_grid.triangle] == no_triangle && !grid_.move_to_other(in_grid)) return false;
    const std::uint32_t t = number_[in_grid.triangle];
    if (t == no_triangle) return false;
    place = {t, in_grid.weight[mesh_.corner_slot[3 * std::size_t{t} + 1] % 3],
             in_grid.weight[mesh_.corner_slot[3 * std::size_t{t} + 2] % 3]};
    return true;
  }
  UnitPair to_square(const SurfacePlace& place) const {
    const std::array<double, 3> weight{1 - place.b1 - place.b2, place.b1, place.b2};
    UnitPair point{0, 0};
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t corner = mesh_.corner_slot[3 * std::size_t{place.triangle} + k] % 3;
      const UnitPair at = grid_.at(mesh_.polygon[place.triangle], corner);
      point.first += weight[k] * at.first;
      point.second += weight[k] * at.second;
    }
    return {std::clamp(point.first, 0.0, 1.0), std::clamp(point.second, 0.0, 1.0)};
  }

 private:
  const SurfaceGrid& grid_;
  PreparedMesh mesh_;
  std::vector<std::uint32_t> number_;  // of a triangle of the grid
};

}  // namespace

std::uint32_t relax_on_surface(const SurfaceMeasure& measure, bool uniform, double area,
                               std::span<UnitPair> points, const CancelToken& cancel) {
  if (points.empty()) return 0;
  const SurfaceGrid grid(measure, area, points.size(), cancel);
  const GridMesh on_grid(grid, cancel);
  std::vector<SurfacePlace> places;
  std::vector<std::size_t> moving;
  for (std::size_t i = 0; i < points.size(); ++i) {
    SurfacePlace place;
    if (!on_grid.to_mesh(points[i], place)) continue;
    places.push_back(place);
    moving.push_back(i);
  }
  Density density;
  if (!uniform) density.corner = on_grid.corner_density();
  const MeshMeasure of_mesh = measure_of(on_grid.mesh(), std::move(density));
  const std::uint32_t held = relax_samples(on_grid.mesh(), of_mesh, places, cancel);
  for (std::size_t k = 0; k < places.size(); ++k) points[moving[k]] = on_grid.to_square(places[k]);
  return held + static_cast<std::uint32_t>(points.size() - places.size());
}

}  // namespace meander
